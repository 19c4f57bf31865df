// Linear RGB spaces, and chromatic adaptation.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

namespace togishi {

/// A linear RGB space by its primaries and white as CIE x, y; or XYZ itself.
struct ColourSpace {
    std::string_view name;
    std::string_view title;
    glm::dvec3 white_xyz;     ///< Y = 1
    glm::dmat3 rgb_from_xyz;  ///< column vectors: rgb = rgb_from_xyz * xyz
};

/// | name       | what |
/// |------------|------|
/// | rec709     | ITU-R BT.709 primaries, D65: Blender's default working space (the default here) |
/// | rec2020    | ITU-R BT.2020 primaries, D65 |
/// | acescg     | ACES AP1 primaries and white (S-2014-004), XYZ taken as it is |
/// | acescg_d65 | AP1 after a fixed Bradford adaptation from D65 to the ACES white, as OpenColorIO
/// and |            | Blender convert to ACEScg: D65 is (1, 1, 1) | | xyz        | CIE XYZ; its
/// white is equal energy |
[[nodiscard]] std::span<const ColourSpace> colour_spaces();
inline constexpr std::string_view default_colour_space = "rec709";
/// Throws InputError listing the names that exist.
[[nodiscard]] const ColourSpace& find_colour_space(std::string_view name);

enum class Adaptation { none, bradford, cat16 };
/// "none", "bradford" or "cat16". Throws InputError.
[[nodiscard]] Adaptation find_adaptation(std::string_view name);

/// Linear von Kries adaptation in the cone space of Bradford (Lam 1985) or CAT16 (Li et al. 2017),
/// full degree: maps white `from` to white `to`, both XYZ. Adaptation::none is the identity. Throws
/// InputError where `from` is too saturated to be a white (a cone response of 1e-6 or less, as
/// under a spectral line).
[[nodiscard]] glm::dmat3 adaptation_matrix(Adaptation adaptation, const glm::dvec3& from,
                                           const glm::dvec3& to);

/// XYZ to linear RGB of the space for things under a light of this white, adapted to the space's
/// white or not.
[[nodiscard]] glm::dmat3 rgb_from_xyz(const ColourSpace& space, Adaptation adaptation,
                                      const glm::dvec3& light_white);

}  // namespace togishi
