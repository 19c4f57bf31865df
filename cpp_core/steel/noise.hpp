// Band-limited random fields without period, as functions of position and seed only.
//
// Gradient noise on a unit lattice whose gradients come from an integer hash, so nothing repeats
// over a blade and every thread computes the same bits. Fields are scaled to unit variance: an
// amplitude in millimetres before a noise is that field's standard deviation. Source of the
// construction: Perlin, Improving Noise, 2002 (quintic fade).
#pragma once
#include <cmath>
#include <cstdint>

namespace togishi {

/// 32 mixed bits of a lattice point.
[[nodiscard]] inline std::uint32_t hash_lattice(std::int32_t x, std::int32_t y,
                                                std::uint32_t seed) {
    std::uint32_t h = seed ^ (static_cast<std::uint32_t>(x) * 0x9E3779B1U);
    h ^= h >> 15;
    h *= 0x2C1B3C6DU;
    h ^= static_cast<std::uint32_t>(y) * 0x85EBCA77U;
    h ^= h >> 16;
    h *= 0x297A2D39U;
    h ^= h >> 15;
    return h;
}

/// A hash as a number in [0, 1).
[[nodiscard]] inline float unit_from_hash(std::uint32_t h) {
    return static_cast<float>(h >> 8) * (1.0F / 16777216.0F);
}

/// Value and gradient of a plane noise, per unit of its own arguments.
struct NoiseSample {
    float value = 0;
    float dx = 0;
    float dy = 0;
};

/// Plane noise of feature size about 1, mean 0, standard deviation 1/2.
[[nodiscard]] NoiseSample noise_2d(double x, double y, std::uint32_t seed);

/// noise_2d's value alone, the same bits.
[[nodiscard]] float noise_value(double x, double y, std::uint32_t seed);

/// Line noise of feature size about 1, mean 0, standard deviation 1/2.
[[nodiscard]] float noise_1d(double x, std::uint32_t seed);

/// What remains of a wave after averaging over a sample's footprint.
/// cycles: how many features the footprint spans; 1 at 0, below 1 % from 1.2 on.
[[nodiscard]] inline float footprint_fade(float cycles) {
    return cycles < 0.02F ? 1.0F : std::exp(-3.3F * cycles * cycles);
}

/// sqrt(x^2 + y^2) for values that cannot overflow.
[[nodiscard]] inline float hypotenuse(float x, float y) {
    return std::sqrt(x * x + y * y);
}

/// S-curve: 0 below `low`, 1 above `high`.
template <typename Real>
[[nodiscard]] Real smooth_step(Real low, Real high, Real x) {
    Real t = (x - low) / (high - low);
    t = t < Real(0) ? Real(0) : (t > Real(1) ? Real(1) : t);
    return t * t * (Real(3) - Real(2) * t);
}

}  // namespace togishi
