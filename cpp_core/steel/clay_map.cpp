#include "steel/clay_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "steel/noise.hpp"

namespace togishi {
namespace {

constexpr double grid_step_mm = 0.125;
constexpr double brush_mm = 0.25;  // how soft the clay's own border is, half width
constexpr float far_mm = 4.0F;     // distances are not told apart beyond this

float smooth_union(float a, float b, float k) {
    const float h = std::max(k - std::abs(a - b), 0.0F) / k;
    return std::min(a, b) - 0.25F * k * h * h;
}

/// Approximate distance to an ellipse about the origin, exact on its line and to first order beside
/// it.
float ellipse_distance(float x, float y, float rx, float ry) {
    const float ax = x / rx;
    const float ay = y / ry;
    const float k0 = std::sqrt(ax * ax + ay * ay);
    const float bx = ax / rx;
    const float by = ay / ry;
    const float k1 = std::sqrt(bx * bx + by * by);
    return k1 > 1e-6F ? k0 * (k0 - 1.0F) / k1 : -std::min(rx, ry);
}

struct Nearest {
    float along;  // 0 at a, 1 at b
    float distance;
};

Nearest to_segment(float px, float py, float ax, float ay, float bx, float by) {
    const float dx = bx - ax;
    const float dy = by - ay;
    const float length2 = std::max(dx * dx + dy * dy, 1e-9F);
    const float t = std::clamp(((px - ax) * dx + (py - ay) * dy) / length2, 0.0F, 1.0F);
    return {t, std::hypot(px - ax - t * dx, py - ay - t * dy)};
}

float crest_distance(const HamonCrest& c, float s, float q) {
    const auto x = s - static_cast<float>(c.s);
    const auto y = q - static_cast<float>(c.foot_q);
    const auto lean = static_cast<float>(c.lean);
    const auto half = static_cast<float>(c.head_half);
    const auto high = static_cast<float>(c.head_high);
    const auto rise = static_cast<float>(c.head_q - c.foot_q);
    switch (c.kind) {
        case HamonCrest::Kind::arch:
            return ellipse_distance(x - lean * y / high, y, half, high);
        case HamonCrest::Kind::island:
            return ellipse_distance(x, y, half, high);
        case HamonCrest::Kind::clove: {
            const Nearest n = to_segment(x, y, 0.0F, 0.0F, lean, rise);
            const auto neck = static_cast<float>(c.neck_half);
            return smooth_union(n.distance - neck * (1.15F - 0.25F * n.along),
                                ellipse_distance(x - lean, y - rise, half, high), 0.4F);
        }
        case HamonCrest::Kind::point: {
            const Nearest n = to_segment(x, y, 0.0F, 0.0F, lean, rise);
            return n.distance -
                   std::lerp(static_cast<float>(c.neck_half), half, std::sqrt(n.along));
        }
    }
    return far_mm;
}

/// Share of the insulation that a strip adds at (s, q).
float strip_cover(const ClayStrip& strip, float s, float q) {
    const Nearest n = to_segment(s, q, static_cast<float>(strip.s0), static_cast<float>(strip.q0),
                                 static_cast<float>(strip.s1), static_cast<float>(strip.q1));
    const float half = static_cast<float>(strip.half_width) * (1.0F - 0.35F * n.along);
    const float t = n.distance / half;
    // The brush runs dry towards the edge.
    return static_cast<float>(strip.strength) * (1.0F - 0.4F * n.along) * std::exp(-t * t);
}

/// The items of a list sorted by s that may reach into [s - reach, s + reach].
template <typename Item, typename Position>
std::pair<std::size_t, std::size_t> around(const std::vector<Item>& items, double s, double reach,
                                           Position position) {
    const auto low = std::lower_bound(items.begin(), items.end(), s - reach,
                                      [&](const Item& a, double b) { return position(a) < b; });
    const auto high = std::upper_bound(low, items.end(), s + reach,
                                       [&](double b, const Item& a) { return b < position(a); });
    return {static_cast<std::size_t>(low - items.begin()),
            static_cast<std::size_t>(high - items.begin())};
}

}  // namespace

FieldGrid lay_clay(const SteelOutline& outline, const SteelParameters& p, const HamonLine& line,
                   const Boshi& boshi, bool omote, unsigned threads) {
    double crest_reach = 1.0;
    double strip_reach = 1.0;
    double top = 1.0;
    for (const double b : line.base) top = std::max(top, b);
    for (const HamonCrest& c : line.crests) {
        crest_reach =
            std::max(crest_reach, std::max(c.head_half, c.neck_half) + std::abs(c.lean) + 1.5);
        top = std::max(top, c.head_q + c.head_high);
    }
    for (const ClayStrip& c : line.strips) {
        strip_reach = std::max(strip_reach, std::abs(c.s1 - c.s0) + 3.0 * c.half_width + 0.6);
    }
    const double s0 = -1.5;
    const double highest = std::max(top + 5.0, outline.edge(outline.kissaki_s()) + 2.5);
    const auto columns = static_cast<std::size_t>((outline.nagasa() + 1.5 - s0) / grid_step_mm) + 2;
    const auto rows = static_cast<std::size_t>((highest + 1.0) / grid_step_mm) + 2;
    FieldGrid clay(s0, -1.0, grid_step_mm, columns, rows);
    const auto seed = static_cast<std::uint32_t>(p.seed * 0xC2B2AE35U) + (omote ? 3U : 903U);
    // A hand does not draw perfect circles: the drawing is bent a little, at the size of the
    // crests.
    const double bend = std::clamp(p.hamon_scale, 0.5, 1.5);

    parallel_for(
        columns, 32,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const double s = clay.s_of(i);
                const double boshi_share = boshi.share(s);
                const auto crests =
                    around(line.crests, s, crest_reach, [](const HamonCrest& c) { return c.s; });
                const auto strips =
                    around(line.strips, s, strip_reach, [](const ClayStrip& c) { return c.s0; });
                float* conductance = clay.column(i);
                for (std::size_t j = 0; j < rows; ++j) {
                    const double q = std::max(clay.q_of(j), 0.0);
                    float d = far_mm;
                    double bent_s = s;
                    double bent_q = q;
                    if (q < top + 1.5) {
                        bent_s +=
                            0.28 * bend * noise_value(s / (2.9 * bend), q / (2.3 * bend), seed);
                        bent_q +=
                            0.16 * bend * noise_value(s / (2.3 * bend), q / (2.9 * bend), seed + 1);
                        const double base = line.base_at(bent_s);
                        const double slope =
                            (line.base_at(bent_s + 0.5) - line.base_at(bent_s - 0.5));
                        d = static_cast<float>((bent_q - base) / std::sqrt(1.0 + slope * slope));
                        for (std::size_t k = crests.first; k < crests.second; ++k) {
                            d = smooth_union(
                                d,
                                crest_distance(line.crests[k], static_cast<float>(bent_s),
                                               static_cast<float>(bent_q)),
                                0.45F);
                        }
                    }
                    if (boshi_share > 0.0) {
                        d = static_cast<float>(
                            std::lerp(static_cast<double>(d), boshi.distance(s, q), boshi_share));
                    }
                    float cover = 0;
                    if (boshi_share < 1.0) {
                        for (std::size_t k = strips.first; k < strips.second; ++k) {
                            cover = std::max(cover,
                                             strip_cover(line.strips[k], static_cast<float>(bent_s),
                                                         static_cast<float>(q)));
                        }
                        cover *= static_cast<float>(1.0 - boshi_share);
                    }
                    const float thin = 1.0F - smooth_step(-static_cast<float>(brush_mm),
                                                          static_cast<float>(brush_mm), d);
                    conductance[j] = thick_clay_conductance +
                                     (1.0F - thick_clay_conductance) * thin * (1.0F - cover);
                }
            }
        },
        threads);
    return clay;
}

}  // namespace togishi
