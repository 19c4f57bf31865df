// Mip levels of a normal map by the leans of its texels: a texel of level n holds the mean lean of
// the texels that it covers and the covariance of theirs about it, so that a lobe widened by it
// (shaders/shared/detail/normal_map.glsl) keeps the energy and the shape of what the texels reflect
// together.
//
// Exact for the first two moments at every level. What remains is that the mixture is taken as a
// Gaussian: a single groove in a flat texel gives a wider and lower lobe than the narrow peak with
// a faint skirt that it is.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bake/mip_atlas.hpp"

namespace togishi {

/// A map in memory: rows from v = 0 upwards, without gaps; the first three floats of a texel are
/// red, green and blue, 0.5 + 0.5 n of the unit normal n in the chart (docs/conventions.md).
struct NormalMapView {
    const float* rgb = nullptr;
    std::size_t texel_stride = 3;  ///< floats from texel to texel, 3 or more
    std::size_t width = 0;
    std::size_t height = 0;
};

/// Leans beyond this (84 degrees) are shortened to it.
inline constexpr float steepest_lean = 10.0F;

/// How many texels of a map were mended.
struct NormalRepair {
    std::size_t without_normal = 0;  ///< NaN, infinite or of no length: taken as flat
    std::size_t too_steep =
        0;  ///< leaning 84 degrees or more, or pointing inwards: leaning 84 degrees

    /// One sentence for a person; empty where nothing was mended.
    [[nodiscard]] std::string sentence(const std::string& what) const;
};

/// One level, row by row. Level 0 has no spread: its last three planes are empty.
struct NormalLevel {
    std::size_t width = 0, height = 0;
    std::vector<float> lean_x, lean_y;
    std::vector<float> sd_x, sd_y, correlation;
};

/// Levels 0 to 1 x 1. Throws InputError for a size of 0 or above 65536.
[[nodiscard]] std::vector<NormalLevel> normal_levels(const NormalMapView& map, NormalRepair& repair,
                                                     unsigned threads = 0);

/// Writes the levels into `leans` (layout.height rows of layout.width times lean x, y and standard
/// deviation x, y) and `correlations` (one number each), half floats that the caller zeroed.
void fill_normal_atlas(const AtlasLayout& layout, const std::vector<NormalLevel>& levels,
                       std::uint16_t* leans, std::uint16_t* correlations);

}  // namespace togishi
