// shaders/shared/lobe.glsl once more, with exp and log that a compiler turns into vector code: maps
// have millions of lobes, and the C library takes them one by one. The formulas are the same text;
// only the elementary functions differ (error of both <= 2e-7 relative or absolute, over the
// arguments that lobes have).
#pragma once
#include <bit>
#include <cstdint>

#include "brdf/model.hpp"

#define TG_FN inline

namespace togishi::lanes {

/// e^x for |x| <= 80. Taylor's series to the 6th power over |r| <= ln2/2, times a power of two set
/// by bits.
inline float exp(float x) {
    const float shifted =
        x * 1.44269504F + 12582912.0F;  // 1.5 2^23: the sum's last bits are round(x/ln2)
    const float n = shifted - 12582912.0F;
    // ln2 in two pieces, the first with trailing zeros: n times it is exact.
    const float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
    const float series =
        1.0F +
        r * (1.0F + r * (0.5F + r * (0.16666667F + r * (0.041666668F +
                                                        r * (0.0083333338F + r * 0.0013888889F)))));
    const auto exponent = (std::bit_cast<std::uint32_t>(shifted) - 0x4b400000U) << 23U;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(series) + exponent);
}

/// ln x for normal x > 0: x = m 2^e with m in [sqrt(1/2), sqrt(2)), ln m = 2 atanh(s), s = (m -
/// 1)/(m + 1), by its series.
inline float log(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const auto e = static_cast<std::int32_t>(bits - 0x3f3504f3U) >> 23;
    const float m = std::bit_cast<float>(bits - (static_cast<std::uint32_t>(e) << 23U));
    const float s = (m - 1.0F) / (m + 1.0F), s2 = s * s;
    const float series =
        0.66666667F + s2 * (0.4F + s2 * (0.28571429F + s2 * (0.22222222F + s2 * 0.18181818F)));
    const auto power = static_cast<float>(e);
    return (s + s) + (s * s2 * series + (power * 0.693359375F - power * 2.12194440e-4F));
}

using namespace glm;
#include "shared/lobe.glsl"

}  // namespace togishi::lanes

#undef TG_FN
