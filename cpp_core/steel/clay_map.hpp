// The clay on one side of the blade: thick on the ji, thin on the ha, with strips laid across the
// ha.
#pragma once
#include "steel/boshi.hpp"
#include "steel/field_grid.hpp"
#include "steel/hamon_line.hpp"

namespace togishi {

/// Two fields over the side, s and q as in SteelOutline.
struct ClayMap {
    FieldGrid
        distance_mm;  ///< to the line between thick and thin clay; negative on the thin side (ha)
    FieldGrid conductance;  ///< how well heat passes into the water: 1 through thin clay,
                            ///< thick_clay through thick
    static constexpr float thick_clay = 0.3F;
};

[[nodiscard]] ClayMap lay_clay(const SteelOutline& outline, const SteelParameters& p,
                               const HamonLine& line, const Boshi& boshi, bool omote,
                               unsigned threads);

}  // namespace togishi
