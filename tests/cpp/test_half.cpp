// Half floats against the definition of IEEE 754 binary16, computed in double.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "bake/half.hpp"

namespace {

using togishi::float_from_half;
using togishi::half_from_float;

// Value of a half by its definition: (-1)^s 2^(e-15) (1 + m/1024), subnormals m 2^-24.
double value_of(std::uint16_t half) {
    const int exponent = (half >> 10) & 31;
    const int mantissa = half & 1023;
    const double sign = (half & 0x8000) != 0 ? -1.0 : 1.0;
    if (exponent == 31) return mantissa != 0 ? std::nan("") : sign * INFINITY;
    if (exponent == 0) return sign * std::ldexp(mantissa, -24);
    return sign * std::ldexp(1024 + mantissa, exponent - 25);
}

// Round to nearest even by the definition, from the value in double.
std::uint16_t expected_half(float value) {
    const std::uint16_t sign = std::signbit(value) ? 0x8000 : 0;
    const double magnitude = std::abs(static_cast<double>(value));
    if (magnitude >= 65520.0) return sign | 0x7c00;
    if (magnitude == 0.0) return sign;
    const int exponent = std::max(std::ilogb(magnitude), -14);
    const double units = std::nearbyint(std::ldexp(magnitude, 10 - exponent));  // ties to even
    const auto rounded = static_cast<std::uint32_t>(units);
    // units is 1024..2048 for normals: 2048 carries into the exponent by itself.
    return static_cast<std::uint16_t>(
        sign | (rounded + (static_cast<std::uint32_t>(exponent + 14) << 10)));
}

TEST(Half, EveryHalfIsReadExactlyAndComesBack) {
    for (std::uint32_t i = 0; i < 65536; ++i) {
        const auto half = static_cast<std::uint16_t>(i);
        const float read = float_from_half(half);
        if (std::isnan(value_of(half))) {
            EXPECT_TRUE(std::isnan(read));
            EXPECT_TRUE(std::isnan(float_from_half(half_from_float(read))));
        } else {
            EXPECT_EQ(static_cast<double>(read), value_of(half));
            EXPECT_EQ(half_from_float(read), half);
        }
    }
}

TEST(Half, RoundsToNearestEvenAroundEveryHalf) {
    for (std::uint32_t i = 0; i < 0x7c00; ++i) {
        const double low = value_of(static_cast<std::uint16_t>(i));
        const double high = i + 1 == 0x7c00 ? 65536.0 : value_of(static_cast<std::uint16_t>(i + 1));
        const auto middle = static_cast<float>(0.5 * (low + high));
        for (const float f : {std::nextafter(middle, 0.0F), middle, std::nextafter(middle, 1e9F)}) {
            EXPECT_EQ(half_from_float(f), expected_half(f)) << f;
            EXPECT_EQ(half_from_float(-f), expected_half(-f)) << -f;
        }
    }
}

TEST(Half, RandomBitPatterns) {
    std::mt19937 random(1);
    for (int i = 0; i < 1'000'000; ++i) {
        const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
        if (std::isnan(value)) {
            EXPECT_TRUE(std::isnan(float_from_half(half_from_float(value))));
        } else {
            EXPECT_EQ(half_from_float(value), expected_half(value)) << value;
        }
    }
}

TEST(Half, Limits) {
    EXPECT_EQ(half_from_float(togishi::half_max), 0x7bff);
    EXPECT_EQ(half_from_float(65519.996F), 0x7bff);
    EXPECT_EQ(half_from_float(65520.0F), 0x7c00);
    EXPECT_EQ(half_from_float(-std::numeric_limits<float>::infinity()), 0xfc00);
    EXPECT_EQ(half_from_float(-0.0F), 0x8000);
    EXPECT_EQ(half_from_float(std::numeric_limits<float>::denorm_min()), 0x0000);
    static_assert(half_from_float(1.0F) == 0x3c00 && float_from_half(0x3c00) == 1.0F);
}

}  // namespace
