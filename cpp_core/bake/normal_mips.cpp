#include "bake/normal_mips.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "bake/mip_taps.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"

namespace togishi {
namespace {

constexpr std::size_t max_size = 65536;

// Mean and covariance of the leans of an area. In double: the covariance of a flat area must stay
// that of its rounding.
struct Moments {
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

enum class Mended { no, without_normal, too_steep };

Mended lean_of(const float* rgb, float& lean_x, float& lean_y) {
    const double x = 2.0 * rgb[0] - 1.0, y = 2.0 * rgb[1] - 1.0, z = 2.0 * rgb[2] - 1.0;
    const double across = std::hypot(x, y);
    lean_x = lean_y = 0.0F;
    // NaN fails both.
    if (!(across + std::abs(z) > 1.0e-6 && across + std::abs(z) < 1.0e6))
        return Mended::without_normal;
    if (z * static_cast<double>(steepest_lean) > across) {
        lean_x = static_cast<float>(x / z);
        lean_y = static_cast<float>(y / z);
        return Mended::no;
    }
    if (!(across > 1.0e-6)) return Mended::without_normal;  // straight inwards
    lean_x = static_cast<float>(x / across) * steepest_lean;
    lean_y = static_cast<float>(y / across) * steepest_lean;
    return Mended::too_steep;
}

NormalLevel decoded(const NormalMapView& map, NormalRepair& repair, unsigned threads) {
    NormalLevel level;
    level.width = map.width;
    level.height = map.height;
    const std::size_t count = map.width * map.height;
    level.lean_x.resize(count);
    level.lean_y.resize(count);
    std::atomic<std::size_t> without{0}, steep{0};
    parallel_for(
        count, 16384,
        [&](std::size_t begin, std::size_t end) {
            std::size_t own_without = 0, own_steep = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Mended mended =
                    lean_of(map.rgb + map.texel_stride * i, level.lean_x[i], level.lean_y[i]);
                own_without += mended == Mended::without_normal ? 1 : 0;
                own_steep += mended == Mended::too_steep ? 1 : 0;
            }
            without += own_without;
            steep += own_steep;
        },
        threads);
    repair.without_normal += without;
    repair.too_steep += steep;
    return level;
}

Moments moments_at(const NormalLevel& level, std::size_t i) {
    Moments m;
    m.x = level.lean_x[i];
    m.y = level.lean_y[i];
    if (!level.sd_x.empty()) {
        const double sx = level.sd_x[i], sy = level.sd_y[i];
        m.xx = sx * sx;
        m.yy = sy * sy;
        m.xy = sx * sy * level.correlation[i];
    }
    return m;
}

// The texels below together. Deviations are taken from the common mean, not from zero: no
// difference of large squares.
Moments joined(const NormalLevel& below, const MipTaps& across, const MipTaps& up) {
    Moments all;
    for (int pass = 0; pass < 2; ++pass) {
        for (std::size_t j = 0; j < up.count; ++j) {
            for (std::size_t i = 0; i < across.count; ++i) {
                const double share = static_cast<double>(across.weight.at(i)) * up.weight.at(j);
                const Moments m =
                    moments_at(below, (up.first + j) * below.width + across.first + i);
                if (pass == 0) {
                    all.x += share * m.x;
                    all.y += share * m.y;
                    continue;
                }
                const double dx = m.x - all.x, dy = m.y - all.y;
                all.xx += share * (m.xx + dx * dx);
                all.xy += share * (m.xy + dx * dy);
                all.yy += share * (m.yy + dy * dy);
            }
        }
    }
    return all;
}

NormalLevel coarser_level(const NormalLevel& below, unsigned threads) {
    NormalLevel level;
    level.width = coarser_size(below.width);
    level.height = coarser_size(below.height);
    const std::size_t count = level.width * level.height;
    for (auto* plane :
         {&level.lean_x, &level.lean_y, &level.sd_x, &level.sd_y, &level.correlation}) {
        plane->resize(count);
    }
    parallel_for(
        level.height, std::max<std::size_t>(1, 8192 / level.width),
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y) {
                const MipTaps up = mip_taps(y, below.height);
                for (std::size_t x = 0; x < level.width; ++x) {
                    const Moments m = joined(below, mip_taps(x, below.width), up);
                    const std::size_t i = y * level.width + x;
                    const double sd_x = std::sqrt(m.xx), sd_y = std::sqrt(m.yy);
                    level.lean_x[i] = static_cast<float>(m.x);
                    level.lean_y[i] = static_cast<float>(m.y);
                    level.sd_x[i] = static_cast<float>(sd_x);
                    level.sd_y[i] = static_cast<float>(sd_y);
                    // Below what a half float holds there is no direction.
                    const double both = sd_x * sd_y;
                    level.correlation[i] =
                        both > 1.0e-12 ? static_cast<float>(std::clamp(m.xy / both, -1.0, 1.0))
                                       : 0.0F;
                }
            }
        },
        threads);
    return level;
}

ChannelView view_of_plane(const std::vector<float>& plane) {
    if (plane.empty()) return {};
    return {plane.data(), 1};
}

}  // namespace

std::string NormalRepair::sentence(const std::string& what) const {
    std::string text;
    if (without_normal > 0) {
        text = std::to_string(without_normal) + " texels hold no normal and are taken as flat";
    }
    if (too_steep > 0) {
        text += text.empty() ? "" : "; ";
        text += std::to_string(too_steep) + " lean more than 84 degrees and are taken as 84";
    }
    return text.empty() ? text : what + ": " + text;
}

std::vector<NormalLevel> normal_levels(const NormalMapView& map, NormalRepair& repair,
                                       unsigned threads) {
    if (map.width == 0 || map.height == 0 || map.width > max_size || map.height > max_size) {
        throw InputError("normal map", "size",
                         std::to_string(map.width) + " x " + std::to_string(map.height),
                         "1 to 65536 texels either way");
    }
    std::vector<NormalLevel> levels;
    levels.push_back(decoded(map, repair, threads));
    while (levels.back().width > 1 || levels.back().height > 1) {
        NormalLevel next = coarser_level(levels.back(), threads);
        levels.push_back(std::move(next));
    }
    return levels;
}

void fill_normal_atlas(const AtlasLayout& layout, const std::vector<NormalLevel>& levels,
                       std::uint16_t* leans, std::uint16_t* correlations) {
    std::vector<std::vector<ChannelView>> four, one;
    four.reserve(levels.size());
    one.reserve(levels.size());
    for (const NormalLevel& level : levels) {
        four.push_back({view_of_plane(level.lean_x), view_of_plane(level.lean_y),
                        view_of_plane(level.sd_x), view_of_plane(level.sd_y)});
        one.push_back({view_of_plane(level.correlation)});
    }
    fill_atlas(layout, four, leans);
    fill_atlas(layout, one, correlations);
}

}  // namespace togishi
