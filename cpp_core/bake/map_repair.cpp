#include "bake/map_repair.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "blade/part.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr std::size_t texels_per_range = 1 << 16;

bool is_ln_mu(MapChannel c) {
    return c == MapChannel::ji_ln_mu_deg || c == MapChannel::ha_ln_mu_deg;
}
bool is_shape(MapChannel c) {
    return c == MapChannel::ji_e1 || c == MapChannel::ji_e2 || c == MapChannel::ha_e1 ||
           c == MapChannel::ha_e2;
}
constexpr std::pair<MapChannel, MapChannel> shapes[]{{MapChannel::ji_e1, MapChannel::ji_e2},
                                                     {MapChannel::ha_e1, MapChannel::ha_e2}};
// Rounding of an aspect of exactly 100:1 is no fault of the map's.
constexpr float longest_e = TG_MAX_E * 1.00001F;

float in_range(MapChannel c, float value) {
    if (is_ln_mu(c)) return f32::sanitise_lobe({value, 0.0F, 0.0F}).ln_mu_deg;
    if (c == MapChannel::w || c == MapChannel::h) return f32::sanitise_share(value);
    if (c == MapChannel::part) {
        return value >= 0 && value < TG_PART_COUNT && value == std::floor(value) ? value : 0.0F;
    }
    return value;
}

bool shape_in_range(float e1, float e2) {
    return e1 * e1 + e2 * e2 <= longest_e * longest_e;
}

// Every value that is not finite takes that of the nearest texel that is: a wave of equal speed
// from all valid ones.
std::size_t fill_from_nearest(std::vector<float>& plane, std::size_t width, std::size_t height) {
    std::vector<std::uint32_t> front;
    std::size_t bad = 0;
    for (const float value : plane) bad += std::isfinite(value) ? 0 : 1;
    if (bad == 0) return 0;
    if (bad == plane.size()) {
        std::fill(plane.begin(), plane.end(), 0.0F);  // 1 degree, isotropic, no hamon, part "other"
        return bad;
    }
    const auto spread = [&](std::size_t from, auto&& give) {
        const std::size_t x = from % width, y = from / width;
        if (x > 0) give(from - 1);
        if (x + 1 < width) give(from + 1);
        if (y > 0) give(from - width);
        if (y + 1 < height) give(from + width);
    };
    for (std::size_t i = 0; i < plane.size(); ++i) {
        if (!std::isfinite(plane[i])) continue;
        bool at_border = false;
        spread(i, [&](std::size_t to) { at_border = at_border || !std::isfinite(plane[to]); });
        if (at_border) front.push_back(static_cast<std::uint32_t>(i));
    }
    std::vector<std::uint32_t> next;
    while (!front.empty()) {
        next.clear();
        for (const std::uint32_t from : front) {
            spread(from, [&](std::size_t to) {
                if (std::isfinite(plane[to])) return;
                plane[to] = plane[from];
                next.push_back(static_cast<std::uint32_t>(to));
            });
        }
        front.swap(next);
    }
    return bad;
}

}  // namespace

std::string MapRepair::sentence(const std::string& what) const {
    if (!any()) return {};
    std::string text = what + ": ";
    if (not_finite > 0) {
        text += std::to_string(not_finite) +
                " values were NaN or infinite and took the nearest valid value of their channel";
    }
    if (not_finite > 0 && out_of_range > 0) text += "; ";
    if (out_of_range > 0) {
        text += std::to_string(out_of_range) + " values were out of range and were clamped";
    }
    return text;
}

bool is_valid(const MapView& map) {
    std::atomic<bool> valid{true};
    parallel_for(map.width * map.height, texels_per_range, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = 0; c < map_channel_count && valid; ++c) {
            const auto channel = static_cast<MapChannel>(c);
            const ChannelView& view = map.channels[c];
            if (!view.present() || is_shape(channel)) continue;
            const std::size_t last = view.constant() ? begin + 1 : end;
            bool fine = true;
            for (std::size_t i = begin; i < last; ++i) {
                const float value = view.data[view.texel_stride * i];
                fine = fine && in_range(channel, value) == value;  // false for NaN
            }
            if (!fine) valid = false;
        }
        for (const auto& [c1, c2] : shapes) {
            const ChannelView &e1 = map[c1], &e2 = map[c2];
            bool fine = true;
            for (std::size_t i = begin; i < end && (e1.present() || e2.present()); ++i) {
                const float x = e1.present() ? e1.data[e1.texel_stride * i] : 0.0F;
                const float y = e2.present() ? e2.data[e2.texel_stride * i] : 0.0F;
                fine = fine && shape_in_range(x, y);
            }
            if (!fine) valid = false;
        }
    });
    return valid;
}

MapRepair repair_map(PropertyMaps& maps) {
    MapRepair repair;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        auto& plane = maps.channels[c];
        const bool constant = plane.size() == 1;
        repair.not_finite += plane.empty() ? 0
                                           : fill_from_nearest(plane, constant ? 1 : maps.width,
                                                               constant ? 1 : maps.height);
        if (is_shape(static_cast<MapChannel>(c))) continue;
        for (float& value : plane) {
            const float valid = in_range(static_cast<MapChannel>(c), value);
            repair.out_of_range += valid == value ? 0 : 1;
            value = valid;
        }
    }
    for (const auto& [c1, c2] : shapes) {
        auto &e1 = maps[c1], &e2 = maps[c2];
        if (e1.empty() && e2.empty()) continue;
        const auto value = [](const std::vector<float>& plane, std::size_t i) {
            return plane.empty() ? 0.0F : plane[plane.size() == 1 ? 0 : i];
        };
        const std::size_t count = std::max(e1.size(), e2.size());
        for (std::size_t i = 0; i < count; ++i) {
            if (shape_in_range(value(e1, i), value(e2, i))) continue;
            ++repair.out_of_range;
            // Shortening one of two needs both as planes.
            if (e1.size() == 1) e1.assign(count, e1[0]);
            if (e2.size() == 1) e2.assign(count, e2[0]);
            const f32::Lobe lobe = f32::sanitise_lobe({0.0F, value(e1, i), value(e2, i)});
            if (!e1.empty()) e1[i] = lobe.e1;
            if (!e2.empty()) e2[i] = lobe.e2;
        }
    }
    return repair;
}

PropertyMaps copy_of(const MapView& map) {
    PropertyMaps copy;
    copy.width = map.width;
    copy.height = map.height;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        const ChannelView& view = map.channels[c];
        if (!view.present()) continue;
        copy.channels[c].resize(view.constant() ? 1 : map.width * map.height);
        for (std::size_t i = 0; i < copy.channels[c].size(); ++i) {
            copy.channels[c][i] = view.data[view.texel_stride * i];
        }
    }
    return copy;
}

}  // namespace togishi
