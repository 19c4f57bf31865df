// Colour differences: CIE L*a*b* and CIEDE2000.
#pragma once
#include <glm/glm.hpp>

namespace togishi {

/// L*, a*, b* (CIE 015:2018, 8.2.1) of XYZ under a white, both on the same scale. A component of
/// the white that is zero (a spectral line) carries no signal: its ratio is taken as 0.
[[nodiscard]] glm::dvec3 lab_from_xyz(const glm::dvec3& xyz, const glm::dvec3& white_xyz);

/// CIEDE2000 with k_L = k_C = k_H = 1 (CIE 142:2001; G. Sharma, W. Wu and E. N. Dalal, Color Res.
/// Appl. 30 (2005) 21). Error against their 34 published pairs: <= 5e-5, the rounding of the print.
[[nodiscard]] double delta_e00(const glm::dvec3& lab_a, const glm::dvec3& lab_b);

}  // namespace togishi
