// The columns of intensities: what each of them saw.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "scan/scan.hpp"

namespace togishi {

/// "intensity" (photopic), "intensity_x|_y|_z|_r|_g|_b", "intensity_550nm" (400 to 700 nm); else
/// nothing.
[[nodiscard]] std::optional<ScanChannel> parse_channel(std::string_view title);

/// A channel's reading = dot(xyz_weights, XYZ under the light at Y = 1); 1 for the light itself.
struct ChannelSpectrum {
    std::string light;  ///< as find_light takes it
    glm::dvec3 xyz_weights;
};

/// Throws InputError where the channel sees nothing of the light.
[[nodiscard]] ChannelSpectrum channel_spectrum(const ScanChannel& channel,
                                               const std::string& light);

/// A number in its shortest form, for messages and titles.
[[nodiscard]] std::string format_number(double value);

}  // namespace togishi
