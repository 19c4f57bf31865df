// What a map must not hold: NaN, infinity, values outside the model's range.
#pragma once
#include <cstddef>
#include <string>

#include "bake/map_view.hpp"

namespace togishi {

/// How many values of a map were mended, over all channels.
struct MapRepair {
    std::size_t not_finite = 0;    ///< NaN or infinite: took the nearest valid value of its channel
    std::size_t out_of_range = 0;  ///< finite: brought into the range below

    [[nodiscard]] bool any() const { return not_finite + out_of_range > 0; }
    /// One sentence for a person, e.g. "map: 3 values were NaN or infinite and took ..."; empty
    /// where nothing was mended.
    [[nodiscard]] std::string sentence(const std::string& what) const;
};

/// Whether every value is finite and in range, so that no copy is needed.
[[nodiscard]] bool is_valid(const MapView& map);

/// Mends a map in place. Nearest is by steps along rows and columns.
///
/// | channel     | range                                               | no valid value at all |
/// |-------------|-----------------------------------------------------|-----------------------|
/// | *.ln_mu_deg | ln 0.001 to ln 80                                   | 0, that is 1 degree   |
/// | *.e1, *.e2  | length of (e1, e2) to ln 10 (aspect 100), shortened | 0                     |
/// | w, h        | 0 to 1                                              | 0                     |
/// | part        | whole numbers 0 to 7; others become 0 ("other")     | 0                     |
MapRepair repair_map(PropertyMaps& maps);

/// The view's texels as planes of their own.
[[nodiscard]] PropertyMaps copy_of(const MapView& map);

}  // namespace togishi
