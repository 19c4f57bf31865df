// The atlas: levels that do not touch, frames that repeat the border, sizes that a GPU takes.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bake/half.hpp"
#include "bake/map_mips.hpp"
#include "bake/mip_atlas.hpp"
#include "base/error.hpp"

namespace {

using namespace togishi;
using enum MapChannel;

const std::pair<std::size_t, std::size_t> sizes[]{
    {1, 1},    {2, 1},    {1, 2},        {7, 5},     {64, 64},
    {512, 64}, {37, 300}, {16384, 1024}, {16384, 1}, {1024, 16384}};

TEST(MipAtlas, FramedLevelsDoNotTouchAndFit) {
    for (const auto& [width, height] : sizes) {
        const AtlasLayout layout = atlas_layout(width, height);
        EXPECT_EQ(layout.levels.front().width, width);
        EXPECT_EQ(layout.levels.front().height, height);
        EXPECT_EQ(layout.levels.back().width * layout.levels.back().height, 1U);
        EXPECT_LE(layout.width, largest_texture) << width << " x " << height;
        EXPECT_LE(layout.height, largest_texture) << width << " x " << height;
        if (width >= 64) {
            EXPECT_LE(layout.width * layout.height, 2 * width * height + 40 * (width + height));
        }
        const auto& levels = layout.levels;
        for (std::size_t a = 0; a < levels.size(); ++a) {
            // Framed, except where the atlas itself ends.
            EXPECT_TRUE(levels[a].x >= 1 || a == 0);
            EXPECT_LE(levels[a].x + levels[a].width + (a == 0 ? 0 : 1), layout.width);
            EXPECT_LE(levels[a].y + levels[a].height + (a == 0 ? 0 : 1), layout.height);
            for (std::size_t b = a + 1; b < levels.size(); ++b) {
                const bool apart_x = levels[a].x + levels[a].width + 1 < levels[b].x ||
                                     levels[b].x + levels[b].width + 1 < levels[a].x;
                const bool apart_y = levels[a].y + levels[a].height + 1 < levels[b].y ||
                                     levels[b].y + levels[b].height + 1 < levels[a].y;
                EXPECT_TRUE(apart_x || apart_y)
                    << width << " x " << height << ": " << a << ' ' << b;
            }
        }
    }
    EXPECT_THROW((void)atlas_layout(0, 4), InputError);
    EXPECT_THROW((void)atlas_layout(4, 65537), InputError);
}

// Bilinear look-up in the whole atlas with clamped edges, as a texture unit does it.
double sample(const AtlasLayout& layout, const std::vector<std::uint16_t>& texels,
              std::size_t level, double u, double v, std::size_t channel) {
    const AtlasLevel& at = layout.levels[level];
    const double x = static_cast<double>(at.x) + u * static_cast<double>(at.width) - 0.5;
    const double y = static_cast<double>(at.y) + v * static_cast<double>(at.height) - 0.5;
    const auto texel = [&](double tx, double ty) {
        const auto cx =
            static_cast<std::size_t>(std::clamp(tx, 0.0, static_cast<double>(layout.width - 1)));
        const auto cy =
            static_cast<std::size_t>(std::clamp(ty, 0.0, static_cast<double>(layout.height - 1)));
        return static_cast<double>(float_from_half(texels[4 * (cy * layout.width + cx) + channel]));
    };
    const double x0 = std::floor(x), y0 = std::floor(y), fx = x - x0, fy = y - y0;
    return (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0)) +
           fy * ((1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1));
}

TEST(MipAtlas, LookUpsAreThoseOfEachLevelAlone) {
    for (const auto& [width, height] :
         {std::pair<std::size_t, std::size_t>{7, 5}, {16, 64}, {3, 1}, {16384, 2}}) {
        PropertyMaps maps;
        maps.width = width;
        maps.height = height;
        maps[w].resize(width * height);
        maps[ji_ln_mu_deg].resize(width * height);
        for (std::size_t i = 0; i < width * height; ++i) {
            maps[w][i] = static_cast<float>((i * 37) % 101) / 101.0F;
            maps[ji_ln_mu_deg][i] = static_cast<float>((i * 11) % 17) / 10.0F;
        }
        maps[ha_ln_mu_deg] = {1.625F};
        auto levels = coarser_levels(view_of(maps));
        levels.insert(levels.begin(), maps);
        std::vector<MapView> views;
        for (const auto& level : levels) views.push_back(view_of(level));
        const AtlasLayout layout = atlas_layout(width, height);
        std::vector<std::uint16_t> texels(layout.width * layout.height * 4);
        fill_atlas(layout, views, {ji_ln_mu_deg, ha_ln_mu_deg, w, h}, texels.data());
        for (std::size_t n = 0; n < levels.size(); ++n) {
            const PropertyMaps& level = levels[n];
            for (const double u : {0.0, 0.01, 0.37, 0.5, 0.999, 1.0}) {
                for (const double v : {0.0, 0.2, 0.5, 1.0}) {
                    // The level as a texture of its own.
                    AtlasLayout alone;
                    alone.width = level.width;
                    alone.height = level.height;
                    alone.levels = {{0, 0, level.width, level.height}};
                    std::vector<std::uint16_t> own(level.width * level.height * 4);
                    for (std::size_t i = 0; i < level.width * level.height; ++i) {
                        own[4 * i] = half_from_float(level[ji_ln_mu_deg][i]);
                        own[4 * i + 1] = half_from_float(level[ha_ln_mu_deg][0]);
                        own[4 * i + 2] = half_from_float(level[w][i]);
                    }
                    for (const std::size_t channel : {0, 1, 2, 3}) {
                        EXPECT_NEAR(sample(layout, texels, n, u, v, channel),
                                    sample(alone, own, 0, u, v, channel), 1e-12)
                            << width << " level " << n << " at " << u << ' ' << v;
                    }
                }
            }
        }
    }
}

}  // namespace
