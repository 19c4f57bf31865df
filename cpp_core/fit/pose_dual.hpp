// The shared formulas with derivatives: shaders/shared compiled with a number that carries four of
// them.
//
// For the geometry of a reading the four are its pose: the two tilts of the sample, the receive
// angle and the way out of the plane. For the lobe's form the first three are ln_mu_deg, e1, e2.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace togishi::pose {

inline constexpr std::size_t derivative_count = 4;

struct Dual {
    double v = 0;
    std::array<double, derivative_count> d{};
    Dual() = default;
    // A plain number is a constant: implicit, so that formulas read as formulas.
    Dual(double value) : v(value) {}  // NOLINT(google-explicit-constructor)
    static Dual variable(double value, std::size_t index) {
        Dual x(value);
        x.d[index] = 1;
        return x;
    }
};

/// value, with the derivatives of a scaled by one slope.
inline Dual chain(const Dual& a, double value, double slope) {
    Dual r(value);
    for (std::size_t i = 0; i < derivative_count; ++i) r.d[i] = slope * a.d[i];
    return r;
}
inline Dual chain(const Dual& a, const Dual& b, double value, double slope_a, double slope_b) {
    Dual r(value);
    for (std::size_t i = 0; i < derivative_count; ++i) r.d[i] = slope_a * a.d[i] + slope_b * b.d[i];
    return r;
}
inline Dual operator-(const Dual& a) {
    return chain(a, -a.v, -1);
}
inline Dual operator+(const Dual& a, const Dual& b) {
    return chain(a, b, a.v + b.v, 1, 1);
}
inline Dual operator-(const Dual& a, const Dual& b) {
    return chain(a, b, a.v - b.v, 1, -1);
}
inline Dual operator*(const Dual& a, const Dual& b) {
    return chain(a, b, a.v * b.v, b.v, a.v);
}
inline Dual operator/(const Dual& a, const Dual& b) {
    const double r = 1 / b.v, q = a.v * r;
    return chain(a, b, q, r, -q * r);
}
inline bool operator<(const Dual& a, const Dual& b) {
    return a.v < b.v;
}
inline bool operator>(const Dual& a, const Dual& b) {
    return a.v > b.v;
}
inline bool operator<=(const Dual& a, const Dual& b) {
    return a.v <= b.v;
}
inline bool operator>=(const Dual& a, const Dual& b) {
    return a.v >= b.v;
}

inline Dual abs(const Dual& a) {
    return a.v < 0 ? -a : a;
}
inline Dual min(const Dual& a, const Dual& b) {
    return b.v < a.v ? b : a;
}
inline Dual max(const Dual& a, const Dual& b) {
    return a.v < b.v ? b : a;
}
inline Dual clamp(const Dual& x, const Dual& low, const Dual& high) {
    return min(max(x, low), high);
}
inline Dual sqrt(const Dual& a) {
    const double v = std::sqrt(a.v);
    return chain(a, v, v > 0 ? 0.5 / v : 0);
}
inline Dual exp(const Dual& a) {
    const double v = std::exp(a.v);
    return chain(a, v, v);
}
inline Dual log(const Dual& a) {
    return chain(a, std::log(a.v), 1 / a.v);
}
inline Dual sin(const Dual& a) {
    return chain(a, std::sin(a.v), std::cos(a.v));
}
inline Dual cos(const Dual& a) {
    return chain(a, std::cos(a.v), -std::sin(a.v));
}
inline Dual tan(const Dual& a) {
    const double v = std::tan(a.v);
    return chain(a, v, 1 + v * v);
}
inline Dual atan(const Dual& y, const Dual& x) {
    const double r = 1 / (x.v * x.v + y.v * y.v);
    return chain(y, x, std::atan2(y.v, x.v), x.v * r, -y.v * r);
}

inline Dual atan(const Dual& x) {
    return chain(x, std::atan(x.v), 1 / (1 + x.v * x.v));
}

struct Vec2 {
    Dual x, y;
    Vec2(const Dual& x_, const Dual& y_) : x(x_), y(y_) {}
};
struct Vec3 {
    Dual x, y, z;
    Vec3() = default;
    Vec3(const Dual& x_, const Dual& y_, const Dual& z_) : x(x_), y(y_), z(z_) {}
};
inline Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(const Vec3& a, const Dual& s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 operator*(const Dual& s, const Vec3& a) {
    return a * s;
}
inline Dual dot(const Vec3& a, const Vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Dual length(const Vec3& a) {
    return sqrt(dot(a, a));
}

#define TG_FN inline
#define TG_PRECISE
#define TG_DOUBLE
#define TG_PLAIN_HALF_ANGLE
#define float Dual
#define vec2 Vec2
#define vec3 Vec3
// In the order of dependence.
// clang-format off
#include "shared/constants.glsl"
#include "shared/lobe.glsl"
#include "shared/half_angle.glsl"
#include "shared/shadowing.glsl"
#include "shared/frame.glsl"
#include "shared/surface.glsl"
// clang-format on
#undef float
#undef vec2
#undef vec3
#undef TG_FN
#undef TG_PRECISE
#undef TG_DOUBLE
#undef TG_PLAIN_HALF_ANGLE

}  // namespace togishi::pose
