#include "scanned/blade_curve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace togishi {

BladeCurve::BladeCurve(SmoothCurve mune, SmoothCurve middle, double from, double to, double machi_x)
    : mune_(std::move(mune)), middle_(std::move(middle)), machi_x_(machi_x), from_(from) {
    machi_z_ = mune_.at(machi_x);
    machi_slope_ = mune_.slope(machi_x);
    const double reach = 0.25 * (to - machi_x);
    machi_bend_ = (mune_.slope(machi_x + reach) - machi_slope_) / std::max(reach, 1e-9);
    const int steps = std::max(1, static_cast<int>(std::ceil(to - from)));
    step_ = (to - from) / steps;
    arc_.assign(1, 0.0);
    arc_.reserve(static_cast<std::size_t>(steps) + 1);
    for (int i = 0; i < steps; ++i) {
        // Simpson's rule.
        auto speed = [&](double x) { return std::hypot(1.0, slope(x)); };
        const double x = from + i * step_;
        arc_.push_back(arc_.back() +
                       step_ / 6 * (speed(x) + 4 * speed(x + 0.5 * step_) + speed(x + step_)));
    }
}

double BladeCurve::mune_z(double x) const {
    const double back = x - machi_x_;
    return back >= 0 ? mune_.at(x) : machi_z_ + back * (machi_slope_ + 0.5 * back * machi_bend_);
}

double BladeCurve::slope(double x) const {
    const double back = x - machi_x_;
    return back >= 0 ? mune_.slope(x) : machi_slope_ + back * machi_bend_;
}

double BladeCurve::bend(double x) const {
    return x >= machi_x_ ? mune_.bend(x) : machi_bend_;
}

double BladeCurve::s_mm(double x) const {
    const double place = (x - from_) / step_;
    const auto last = static_cast<double>(arc_.size() - 2);
    const auto i = static_cast<std::size_t>(std::clamp(place, 0.0, last));
    return arc_[i] + (place - static_cast<double>(i)) * (arc_[i + 1] - arc_[i]);
}

double BladeCurve::x_at(double s) const {
    auto after = std::upper_bound(arc_.begin(), arc_.end(), s) - arc_.begin();
    after = std::clamp<std::ptrdiff_t>(after, 1, static_cast<std::ptrdiff_t>(arc_.size()) - 1);
    const auto i = static_cast<std::size_t>(after) - 1;
    return from_ + step_ * (static_cast<double>(i) + (s - arc_[i]) / (arc_[i + 1] - arc_[i]));
}

BladePoint BladeCurve::locate(const glm::dvec3& p) const {
    double x = p.x;
    for (int i = 0; i < 3; ++i) {
        const double m = slope(x);
        const double away = p.z - mune_z(x);
        const double g = p.x - x + away * m;
        const double turn = 1 + m * m - away * bend(x);
        const double move = g / std::max(turn, 0.2);
        x += move;
        if (std::abs(move) < 1e-7) break;
    }
    const double m = slope(x);
    const double norm = std::hypot(1.0, m);
    const double up = ((p.z - mune_z(x)) - m * (p.x - x)) / norm;
    const double y = p.y - middle_.at(x);
    return {s_mm(x), y, -up, y > 0};
}

glm::dvec3 BladeCurve::at(double s) const {
    const double x = x_at(s);
    return {x, middle_.at(x), mune_z(x)};
}

glm::dvec3 BladeCurve::along(double s) const {
    return glm::normalize(glm::dvec3(1, 0, slope(x_at(s))));
}

glm::dvec3 BladeCurve::across(double s) const {
    return glm::normalize(glm::dvec3(slope(x_at(s)), 0, -1));
}

}  // namespace togishi
