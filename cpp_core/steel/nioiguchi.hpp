// The nioiguchi: how hardened steel passes into the ji. A misty line that is brightest just inside
// the critical cooling rate, soft towards the ji, fading slowly into the ha.
#pragma once
#include <algorithm>
#include <cmath>

namespace togishi {

struct Nioiguchi {
    float w = 0;     ///< share of hardened steel, [0, 1]
    float glow = 0;  ///< the misty line itself, [0, 1]: finer crystals than in the ha behind it
};

/// depth_mm: distance into the hardened steel; width_mm: of the line. The ha behind the line keeps
/// `ha_share` of w.
[[nodiscard]] inline Nioiguchi nioiguchi_at(float depth_mm, float width_mm, float ha_share) {
    const float t = depth_mm / width_mm;
    Nioiguchi n;
    const float line = t < 0.0F ? 0.5F * std::exp(1.8F * t) : 1.0F - 0.5F * std::exp(-2.6F * t);
    const float x = (t - 0.6F) / (t < 0.6F ? 0.8F : 1.3F);
    const float core = std::exp(-x * x);
    const float mist = t > 0.0F ? 0.3F * std::exp(-t / 5.0F) * (1.0F - std::exp(-3.0F * t)) : 0.0F;
    n.glow = std::min(1.0F, std::max(core, mist));
    n.w = line * (ha_share + (1.0F - ha_share) * n.glow);
    if (n.w < 0.003F) n.w = 0.0F;
    return n;
}

}  // namespace togishi
