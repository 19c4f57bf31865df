// Nie: grains of martensite large enough to be seen one by one, densest just inside the hamon's
// line.
#pragma once
#include <cstdint>

namespace togishi {

/// Grains within a footprint.
struct NieSample {
    float cover = 0;  ///< share of the footprint that grains take, [0, 1]
    float ln_mu =
        0;  ///< what they add to ln(half width), cover included: grains differ in how they glint
};

/// amount: expected share of the surface under grains, [0, 0.5]. At (s, y) in mm, averaged over the
/// footprint.
[[nodiscard]] NieSample nie_grains(double s, double y, float amount, float footprint_s,
                                   float footprint_y, std::uint32_t seed);

}  // namespace togishi
