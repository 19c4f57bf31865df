// Half-precision floats (IEEE 754 binary16) as 16 bits, for tables and maps that a GPU samples.
//
// | quantity           | value |
// |--------------------|-------|
// | largest finite     | 65504 |
// | smallest normal    | 2^-14 = 6.1e-5 |
// | smallest subnormal | 2^-24 = 6.0e-8 |
// | rounding error     | <= 2^-11 of the value, or 2^-25 below 2^-14 |
#pragma once
#include <bit>
#include <cstdint>

namespace togishi {

inline constexpr float half_max = 65504.0F;

/// Nearest half, ties to even, exactly as IEEE 754 demands: >= 65520 gives infinity, NaN stays NaN
/// (quiet).
[[nodiscard]] constexpr std::uint16_t half_from_float(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = (bits >> 16U) & 0x8000U;
    std::uint32_t magnitude = bits & 0x7fffffffU;
    if (magnitude >= 0x47800000U) {  // 65536 and more, infinity, NaN
        const bool nan = magnitude > 0x7f800000U;
        return static_cast<std::uint16_t>(sign | (nan ? 0x7e00U : 0x7c00U));
    }
    if (magnitude < 0x38800000U) {  // below 2^-14: subnormal half, one unit is 2^-24
        // Adding 0.5 makes the sum's last bit worth 2^-24, and lets the adder do the rounding.
        const float shifted = std::bit_cast<float>(magnitude) + 0.5F;
        return static_cast<std::uint16_t>(sign |
                                          (std::bit_cast<std::uint32_t>(shifted) - 0x3f000000U));
    }
    const std::uint32_t odd = (magnitude >> 13U) & 1U;
    magnitude -= 0x38000000U;        // rebias the exponent from 127 to 15
    magnitude += 0x00000fffU + odd;  // round to nearest, ties to even; may carry into infinity
    return static_cast<std::uint16_t>(sign | (magnitude >> 13U));
}

/// Exact: every half is a float.
[[nodiscard]] constexpr float float_from_half(std::uint16_t half) {
    const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16U;
    const std::uint32_t magnitude = half & 0x7fffU;
    if (magnitude >= 0x7c00U) {  // infinity, NaN
        return std::bit_cast<float>(sign | 0x7f800000U | ((magnitude & 0x3ffU) << 13U));
    }
    if (magnitude < 0x0400U) {  // zero and subnormals: magnitude units of 2^-24
        const float value = static_cast<float>(magnitude) * 5.9604644775390625e-8F;
        return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(value));
    }
    return std::bit_cast<float>(sign | ((magnitude << 13U) + 0x38000000U));
}

}  // namespace togishi
