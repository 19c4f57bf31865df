// Property maps with all mip levels in one texture, for GPUs reached through an interface without
// mip uploads.
//
// Level 0 lies in the corner, level 1 beyond its long side, level 2 beside level 1, and the rest
// stacked behind level 2. Each level is framed by one texel that repeats its border, so that a
// bilinear look-up at
//     (x + u width, y + v height) / (atlas size),  u, v in [0, 1],
// reads exactly what a texture of that level with clamped edges would, and never a neighbouring
// level. Where the frame would make the atlas larger than a common GPU's largest texture (16384),
// the outer frame is left out on that axis: the texture unit's own clamp (wrap mode "extend") does
// its work there. Unused texels are 0.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bake/map_view.hpp"

namespace togishi {

inline constexpr std::size_t largest_texture = 16384;

/// Where the texels of a level lie, without their frame.
struct AtlasLevel {
    std::size_t x = 0, y = 0, width = 0, height = 0;
    friend bool operator==(const AtlasLevel&, const AtlasLevel&) = default;
};

struct AtlasLayout {
    std::size_t width = 0, height = 0;
    std::vector<AtlasLevel> levels;
};
/// Throws InputError for a size of 0 or above 65536.
[[nodiscard]] AtlasLayout atlas_layout(std::size_t width, std::size_t height);

/// Writes the levels of one plane into `texels` (layout.height rows of layout.width times
/// `channels` half floats, zeroed by the caller): level n's channel c is planes[n][c], absent ones
/// 0.
void fill_atlas(const AtlasLayout& layout, const std::vector<std::vector<ChannelView>>& planes,
                std::uint16_t* texels);

/// Writes the levels into `texels` (layout.height rows of layout.width RGBA half floats, zeroed by
/// the caller): RGBA = the four channels, absent ones 0. levels[0] is the map, the others as
/// coarser_levels gives them. Values beyond 65504 become infinity: maps are repaired before.
void fill_atlas(const AtlasLayout& layout, const std::vector<MapView>& levels,
                const std::array<MapChannel, 4>& rgba, std::uint16_t* texels);

}  // namespace togishi
