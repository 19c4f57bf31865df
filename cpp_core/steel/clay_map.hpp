// The clay on one side of the blade: thick on the ji, thin on the ha, with strips laid across the
// ha.
#pragma once
#include "steel/boshi.hpp"
#include "steel/field_grid.hpp"
#include "steel/hamon_line.hpp"

namespace togishi {

/// Conductance of thick clay; that of thin clay is 1.
inline constexpr float thick_clay_conductance = 0.3F;

/// How well heat passes into the water over one side, in [thick_clay_conductance, 1]; s and q as in
/// SteelOutline. The grid reaches as far up as the hamon and the whole kissaki need.
[[nodiscard]] FieldGrid lay_clay(const SteelOutline& outline, const SteelParameters& p,
                                 const HamonLine& line, const Boshi& boshi, bool omote,
                                 unsigned threads);

}  // namespace togishi
