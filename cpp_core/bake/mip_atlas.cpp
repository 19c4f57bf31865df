#include "bake/mip_atlas.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "bake/half.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"

namespace togishi {
namespace {

constexpr std::size_t max_size = 65536;

// For maps at least as wide as high; the other kind is laid out the same way with x and y
// exchanged.
AtlasLayout layout_of_wide(std::size_t width, std::size_t height) {
    AtlasLayout layout;
    const std::size_t frame_x = width + 2 > largest_texture ? 0 : 1;
    layout.levels.push_back({frame_x, 1, width, height});
    layout.width = width + 2 * frame_x;
    layout.height = height + 2;
    std::size_t y = layout.height + 1;  // first row inside the frame of level 1
    std::size_t x = 1;
    for (std::size_t level = 1; width > 1 || height > 1; ++level) {
        width = std::max<std::size_t>(1, width / 2);
        height = std::max<std::size_t>(1, height / 2);
        layout.levels.push_back({x, y, width, height});
        layout.width = std::max(layout.width, x + width + 1);
        layout.height = std::max(layout.height, y + height + 1);
        if (level == 1) {
            x += width + 2;
        } else {
            y += height + 2;
        }
    }
    return layout;
}

}  // namespace

AtlasLayout atlas_layout(std::size_t width, std::size_t height) {
    if (width == 0 || height == 0 || width > max_size || height > max_size) {
        throw InputError("property maps", "size",
                         std::to_string(width) + " x " + std::to_string(height),
                         "1 to 65536 texels either way");
    }
    if (width >= height) return layout_of_wide(width, height);
    AtlasLayout layout = layout_of_wide(height, width);
    std::swap(layout.width, layout.height);
    for (AtlasLevel& level : layout.levels) {
        std::swap(level.x, level.y);
        std::swap(level.width, level.height);
    }
    return layout;
}

void fill_atlas(const AtlasLayout& layout, const std::vector<std::vector<ChannelView>>& planes,
                std::uint16_t* texels) {
    const std::size_t count = planes.at(0).size();
    for (std::size_t n = 0; n < layout.levels.size(); ++n) {
        const AtlasLevel& at = layout.levels[n];
        const std::vector<ChannelView>& channels = planes.at(n);
        // The frame, as far as the atlas reaches.
        const std::size_t left = at.x > 0 ? 1 : 0, right = at.x + at.width < layout.width ? 1 : 0;
        const std::size_t below = at.y > 0 ? 1 : 0,
                          above = at.y + at.height < layout.height ? 1 : 0;
        const std::size_t rows = at.height + below + above;
        parallel_for(
            rows, std::max<std::size_t>(1, 16384 / at.width),
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t row = begin; row < end; ++row) {
                    const std::size_t y = std::min(row < below ? 0 : row - below, at.height - 1);
                    std::uint16_t* line =
                        texels + count * ((at.y - below + row) * layout.width + at.x);
                    for (std::size_t c = 0; c < count; ++c) {
                        const ChannelView& view = channels.at(c);
                        if (!view.present()) continue;
                        const float* from = view.data + view.texel_stride * y * at.width;
                        for (std::size_t x = 0; x < at.width; ++x) {
                            line[count * x + c] = half_from_float(from[view.texel_stride * x]);
                        }
                    }
                    if (left != 0) std::copy_n(line, count, line - count);
                    if (right != 0)
                        std::copy_n(line + count * (at.width - 1), count, line + count * at.width);
                }
            });
    }
}

void fill_atlas(const AtlasLayout& layout, const std::vector<MapView>& levels,
                const std::array<MapChannel, 4>& rgba, std::uint16_t* texels) {
    std::vector<std::vector<ChannelView>> planes;
    planes.reserve(levels.size());
    for (const MapView& map : levels) {
        planes.push_back({map[rgba[0]], map[rgba[1]], map[rgba[2]], map[rgba[3]]});
    }
    fill_atlas(layout, planes, texels);
}

}  // namespace togishi
