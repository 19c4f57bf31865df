// The polishing strokes of each part: the lobe's mean shape, turned a little from place to place,
// since a hand moves the stone.
#pragma once
#include <cmath>
#include <cstdint>

#include "brdf/model.hpp"
#include "steel/noise.hpp"

namespace togishi {

/// Direction of the strokes against the part's mean (rad) at (x, y) mm of the chart.
[[nodiscard]] inline float stroke_wander_rad(double x, double y, double wander_deg,
                                             float footprint_x, float footprint_y,
                                             std::uint32_t seed) {
    const float stone = noise_value(x / 21.0, y / 6.0, seed);
    const float hand = footprint_fade(hypotenuse(footprint_x / 3.5F, footprint_y / 0.9F)) *
                       noise_value(x / 3.5, y / 0.9, seed + 1);
    return static_cast<float>(wander_deg) * 0.0174533F * (1.6F * stone + 1.2F * hand);
}

/// The lobe with its wide axis turned by `angle_rad`.
[[nodiscard]] inline f32::Lobe turned(const f32::Lobe& lobe, float angle_rad) {
    const float c = std::cos(2.0F * angle_rad);
    const float s = std::sin(2.0F * angle_rad);
    f32::Lobe out = lobe;
    out.e1 = lobe.e1 * c - lobe.e2 * s;
    out.e2 = lobe.e1 * s + lobe.e2 * c;
    return out;
}

}  // namespace togishi
