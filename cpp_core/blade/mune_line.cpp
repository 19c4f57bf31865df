#include "blade/mune_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace togishi {
namespace {

// Gauss-Legendre, 8 points on [-1, 1]: the turn of one piece is below 0.1 rad, so the error is
// below 1e-15.
constexpr std::array<double, 4> gauss_x{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                        0.9602898564975363};
constexpr std::array<double, 4> gauss_w{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                        0.1012285362903763};
constexpr int pieces_per_blade = 24;

}  // namespace

MuneLine::MuneLine(double nagasa_mm, double sori_mm, SoriType type, double nakago_mm) {
    switch (type) {
        case SoriType::even:
            break;
        case SoriType::torii:
            c2_ = -4.0;
            break;
        case SoriType::koshi:
            c1_ = -1.8;
            break;
        case SoriType::saki:
            c1_ = 1.8;
            break;
    }
    blade_arc_mm_ = 1;
    // Depth over chord grows with the turn: bisection, on a curve of arc length one.
    auto depth = [&](double turn) {
        turn_rad_ = turn;
        const glm::dvec2 end = integrate(0, 1);
        const double chord = glm::length(end);
        const glm::dvec2 across(-end.y / chord, end.x / chord);
        // The deepest point is where the tangent is parallel to the chord.
        const double chord_rad = std::atan2(end.y, end.x);
        double lo = 0;
        double hi = 1;
        for (int i = 0; i < 60; ++i) {
            const double mid = 0.5 * (lo + hi);
            (angle(mid) < chord_rad ? lo : hi) = mid;
        }
        return -glm::dot(integrate(0, lo), across) / chord;
    };
    const double wanted = sori_mm / nagasa_mm;
    double lo = 0;
    double hi = 2.5;
    for (int i = 0; i < 60; ++i) {
        const double mid = 0.5 * (lo + hi);
        (depth(mid) < wanted ? lo : hi) = mid;
    }
    turn_rad_ = wanted > 0 ? 0.5 * (lo + hi) : 0;
    const glm::dvec2 end = integrate(0, 1);
    start_rad_ = -std::atan2(end.y, end.x);
    blade_arc_mm_ = nagasa_mm / glm::length(end);

    nakago_arc_mm_ = nakago_mm;
    for (int i = 0; i < 20; ++i) {
        nakago_arc_mm_ *= nakago_mm / glm::length(integrate(0, -nakago_arc_mm_));
    }
}

double MuneLine::curvature(double arc_mm) const {
    const double scale = turn_rad_ / blade_arc_mm_;
    const double x = arc_mm / blade_arc_mm_ - 0.5;
    if (arc_mm >= 0) return scale * (1 + c1_ * x + c2_ * (x * x - 1.0 / 12));
    // The nakago carries the curve on and straightens towards its end.
    const double at_machi = scale * (1 - 0.5 * c1_ + c2_ / 6);
    return at_machi * (1 + arc_mm / std::max(nakago_arc_mm_, 1e-9));
}

double MuneLine::angle(double arc_mm) const {
    const double half = 0.5;
    if (arc_mm >= 0) {
        const double x = arc_mm / blade_arc_mm_;
        const double y = x - half;
        const double linear = 0.5 * (y * y - half * half);
        const double square = (y * y * y + half * half * half) / 3 - x / 12;
        return start_rad_ + turn_rad_ * (x + c1_ * linear + c2_ * square);
    }
    const double at_machi = turn_rad_ / blade_arc_mm_ * (1 - 0.5 * c1_ + c2_ / 6);
    return start_rad_ +
           at_machi * (arc_mm + 0.5 * arc_mm * arc_mm / std::max(nakago_arc_mm_, 1e-9));
}

glm::dvec2 MuneLine::integrate(double from_mm, double to_mm) const {
    const double span = (to_mm - from_mm) / pieces_per_blade;
    glm::dvec2 sum(0);
    for (int piece = 0; piece < pieces_per_blade; ++piece) {
        const double mid = from_mm + (piece + 0.5) * span;
        for (std::size_t k = 0; k < gauss_x.size(); ++k) {
            for (const double side : {-0.5, 0.5}) {
                const double a = angle(mid + side * span * gauss_x[k]);
                sum += 0.5 * span * gauss_w[k] * glm::dvec2(std::cos(a), std::sin(a));
            }
        }
    }
    return sum;
}

MuneLine::Point MuneLine::at(double arc_mm) const {
    const double a = angle(arc_mm);
    return {integrate(0, arc_mm), {std::cos(a), std::sin(a)}, curvature(arc_mm)};
}

}  // namespace togishi
