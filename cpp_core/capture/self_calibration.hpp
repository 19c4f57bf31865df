// Where the lights really stood: half-vector offsets that many pixels agree on.
#pragma once
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "capture/light_stack.hpp"
#include "capture/pixel_kernel.hpp"
#include "capture/pixel_result.hpp"

namespace togishi {

/// Blocks of 16 pixels of one region: (block, count, 16) each.
struct SampleBlocks {
    std::size_t blocks = 0;
    std::vector<float> value, scale;
    [[nodiscard]] PixelSamples block(std::size_t b, std::size_t lights) const {
        const std::size_t at = b * lights * block_pixels;
        return {value.data() + at, scale.data() + at};
    }
};

struct Calibration {
    std::vector<glm::dvec2> offset_deg;  ///< per light, to add to (u, v)
    double sigma_h_deg = 0;              ///< error that is left, per axis, for the fit's weights
    SharedError shared;                  ///< what it cannot find out
    double rms_deg = 0;                  ///< of the offsets
    std::size_t pixels = 0;              ///< that were good enough to count
    int rounds = 0;
};

/// Rounds of: every pixel fitted with the lights where they are; then one Gauss-Newton step of all
/// lights together, with each pixel's own unknowns eliminated (Schur's complement), and the prior
/// that offsets have the stated error. One light after the other would leave the soft turns and
/// stretches of the whole field, which hardly change a pixel's residuals, where they are. `lights`
/// is moved along. The same result for any number of threads (0: all).
[[nodiscard]] Calibration self_calibrate(RegionLights& lights, const SampleBlocks& samples,
                                         const PixelKernelOptions& options, int rounds = 5,
                                         unsigned threads = 0);

}  // namespace togishi
