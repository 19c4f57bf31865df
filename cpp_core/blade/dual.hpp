// A number with its two partial derivatives, so that a surface written once gives exact normals.
#pragma once
#include <cmath>

namespace togishi {

/// value, and its derivatives along the blade (q) and across a strip of its surface (f).
struct Dual {
    double v = 0;
    double q = 0;
    double f = 0;

    // A plain number is a constant: implicit, so that formulas read as formulas.
    Dual(double value = 0) : v(value) {}  // NOLINT(google-explicit-constructor)
    Dual(double value, double by_q, double by_f) : v(value), q(by_q), f(by_f) {}
    static Dual along(double value) { return {value, 1, 0}; }
    static Dual across(double value) { return {value, 0, 1}; }
};

inline Dual operator-(const Dual& a) {
    return {-a.v, -a.q, -a.f};
}
inline Dual operator+(const Dual& a, const Dual& b) {
    return {a.v + b.v, a.q + b.q, a.f + b.f};
}
inline Dual operator-(const Dual& a, const Dual& b) {
    return {a.v - b.v, a.q - b.q, a.f - b.f};
}
inline Dual operator*(const Dual& a, const Dual& b) {
    return {a.v * b.v, a.q * b.v + a.v * b.q, a.f * b.v + a.v * b.f};
}
inline Dual operator/(const Dual& a, const Dual& b) {
    const double r = 1 / b.v;
    const double v = a.v * r;
    return {v, (a.q - v * b.q) * r, (a.f - v * b.f) * r};
}
/// The derivative of a function of one number, carried over.
inline Dual chain(const Dual& a, double value, double slope) {
    return {value, slope * a.q, slope * a.f};
}
inline Dual sqrt(const Dual& a) {
    const double v = std::sqrt(a.v);
    return chain(a, v, 0.5 / v);
}
inline Dual sin(const Dual& a) {
    return chain(a, std::sin(a.v), std::cos(a.v));
}
inline Dual cos(const Dual& a) {
    return chain(a, std::cos(a.v), -std::sin(a.v));
}
inline Dual atan(const Dual& a) {
    return chain(a, std::atan(a.v), 1 / (1 + a.v * a.v));
}
inline Dual lerp(const Dual& a, const Dual& b, const Dual& x) {
    return a + (b - a) * x;
}

}  // namespace togishi
