#include "spectral/delta_e.hpp"

#include <cmath>
#include <numbers>

namespace togishi {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double rad_per_deg = pi / 180.0;

double lab_curve(double ratio) {
    constexpr double delta = 6.0 / 29.0;
    return ratio > delta * delta * delta ? std::cbrt(ratio)
                                         : ratio / (3.0 * delta * delta) + 4.0 / 29.0;
}

// c^7/(c^7 + 25^7), finite for any chroma.
double blue_share(double c) {
    const double c7 = std::pow(c / 25.0, 7);
    return c7 / (c7 + 1.0);
}

// Hue angle in [0, 2 pi), 0 for grey.
double hue(double b, double a) {
    if (a == 0.0 && b == 0.0) return 0.0;
    const double h = std::atan2(b, a);
    return h < 0.0 ? h + 2.0 * pi : h;
}

}  // namespace

glm::dvec3 lab_from_xyz(const glm::dvec3& xyz, const glm::dvec3& white_xyz) {
    glm::dvec3 f;
    for (int c = 0; c < 3; ++c) f[c] = lab_curve(white_xyz[c] > 0.0 ? xyz[c] / white_xyz[c] : 0.0);
    return {116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z)};
}

double delta_e00(const glm::dvec3& lab_a, const glm::dvec3& lab_b) {
    const double c_mean = 0.5 * (std::hypot(lab_a.y, lab_a.z) + std::hypot(lab_b.y, lab_b.z));
    const double g = 0.5 * (1.0 - std::sqrt(blue_share(c_mean)));
    const double a1 = (1.0 + g) * lab_a.y;
    const double a2 = (1.0 + g) * lab_b.y;
    const double c1 = std::hypot(a1, lab_a.z);
    const double c2 = std::hypot(a2, lab_b.z);
    const double h1 = hue(lab_a.z, a1);
    const double h2 = hue(lab_b.z, a2);

    const double dl = lab_b.x - lab_a.x;
    const double dc = c2 - c1;
    double dh = 0.0;
    double h_mean = h1 + h2;  // one of them grey: the other's hue counts
    if (c1 * c2 != 0.0) {
        dh = h2 - h1;
        h_mean = 0.5 * (h1 + h2);
        if (std::abs(h1 - h2) > pi) {
            dh += h2 <= h1 ? 2.0 * pi : -2.0 * pi;
            h_mean += h1 + h2 < 2.0 * pi ? pi : -pi;
        }
    }
    const double dh_chord = 2.0 * std::sqrt(c1 * c2) * std::sin(0.5 * dh);

    const double l50 = 0.5 * (lab_a.x + lab_b.x) - 50.0;
    const double c_bar = 0.5 * (c1 + c2);
    const double t = 1.0 - 0.17 * std::cos(h_mean - 30.0 * rad_per_deg) +
                     0.24 * std::cos(2.0 * h_mean) +
                     0.32 * std::cos(3.0 * h_mean + 6.0 * rad_per_deg) -
                     0.20 * std::cos(4.0 * h_mean - 63.0 * rad_per_deg);
    const double s_l = 1.0 + 0.015 * l50 * l50 / std::sqrt(20.0 + l50 * l50);
    const double s_c = 1.0 + 0.045 * c_bar;
    const double s_h = 1.0 + 0.015 * c_bar * t;
    const double bump = (h_mean / rad_per_deg - 275.0) / 25.0;
    const double d_theta = 30.0 * rad_per_deg * std::exp(-bump * bump);
    const double r_t = -2.0 * std::sqrt(blue_share(c_bar)) * std::sin(2.0 * d_theta);

    const double l = dl / s_l;
    const double c = dc / s_c;
    const double h = dh_chord / s_h;
    const double sum = l * l + c * c + h * h + r_t * c * h;
    return sum < 0.0 ? 0.0 : std::sqrt(sum);  // rounding; NaN stays NaN
}

}  // namespace togishi
