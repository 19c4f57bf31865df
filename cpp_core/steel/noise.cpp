#include "steel/noise.hpp"

namespace togishi {
namespace {

// Scales to a standard deviation of 1/2 (the tests hold them).
constexpr float plane_scale = 2.86F;
constexpr float line_scale = 2.53F;

float signed_low(std::uint32_t h) {
    return static_cast<float>(h & 0xFFFFU) * (2.0F / 65535.0F) - 1.0F;
}
float signed_high(std::uint32_t h) {
    return static_cast<float>(h >> 16) * (2.0F / 65535.0F) - 1.0F;
}
float fade(float t) {
    return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F);
}
float fade_slope(float t) {
    return 30.0F * t * t * (t - 1.0F) * (t - 1.0F);
}

template <bool with_gradient>
NoiseSample plane_noise(double x, double y, std::uint32_t seed) {
    const double floor_x = std::floor(x);
    const double floor_y = std::floor(y);
    const auto ix = static_cast<std::int32_t>(floor_x);
    const auto iy = static_cast<std::int32_t>(floor_y);
    const auto fx = static_cast<float>(x - floor_x);
    const auto fy = static_cast<float>(y - floor_y);
    const std::uint32_t h00 = hash_lattice(ix, iy, seed);
    const std::uint32_t h10 = hash_lattice(ix + 1, iy, seed);
    const std::uint32_t h01 = hash_lattice(ix, iy + 1, seed);
    const std::uint32_t h11 = hash_lattice(ix + 1, iy + 1, seed);
    const float ax = signed_low(h00);
    const float ay = signed_high(h00);
    const float bx = signed_low(h10);
    const float by = signed_high(h10);
    const float cx = signed_low(h01);
    const float cy = signed_high(h01);
    const float dx = signed_low(h11);
    const float dy = signed_high(h11);
    const float va = ax * fx + ay * fy;
    const float vb = bx * (fx - 1.0F) + by * fy;
    const float vc = cx * fx + cy * (fy - 1.0F);
    const float vd = dx * (fx - 1.0F) + dy * (fy - 1.0F);
    const float u = fade(fx);
    const float v = fade(fy);
    const float twist = va - vb - vc + vd;
    NoiseSample n;
    n.value = plane_scale * (va + u * (vb - va) + v * (vc - va) + u * v * twist);
    if constexpr (with_gradient) {
        n.dx = plane_scale * (ax + u * (bx - ax) + v * (cx - ax) + u * v * (ax - bx - cx + dx) +
                              fade_slope(fx) * (vb - va + v * twist));
        n.dy = plane_scale * (ay + u * (by - ay) + v * (cy - ay) + u * v * (ay - by - cy + dy) +
                              fade_slope(fy) * (vc - va + u * twist));
    }
    return n;
}

}  // namespace

NoiseSample noise_2d(double x, double y, std::uint32_t seed) {
    return plane_noise<true>(x, y, seed);
}

float noise_value(double x, double y, std::uint32_t seed) {
    return plane_noise<false>(x, y, seed).value;
}

float noise_1d(double x, std::uint32_t seed) {
    const double floor_x = std::floor(x);
    const auto ix = static_cast<std::int32_t>(floor_x);
    const auto f = static_cast<float>(x - floor_x);
    const float a = signed_low(hash_lattice(ix, 0, seed)) * f;
    const float b = signed_low(hash_lattice(ix + 1, 0, seed)) * (f - 1.0F);
    // A second, unaligned lattice: one alone is zero at every whole number, which shows as a
    // rhythm.
    const double shifted = x * 1.37 + 0.5;
    const double floor_s = std::floor(shifted);
    const auto is = static_cast<std::int32_t>(floor_s);
    const auto g = static_cast<float>(shifted - floor_s);
    const float c = signed_low(hash_lattice(is, 1, seed)) * g;
    const float d = signed_low(hash_lattice(is + 1, 1, seed)) * (g - 1.0F);
    return line_scale * (a + fade(f) * (b - a) + c + fade(g) * (d - c));
}

}  // namespace togishi
