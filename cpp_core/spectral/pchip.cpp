#include "spectral/pchip.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace togishi {

namespace {

// Slope at an end point from the two intervals next to it, h and d the nearer one's width and
// slope.
double end_slope(double h0, double h1, double d0, double d1) {
    const double slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if (slope * d0 <= 0.0) return 0.0;
    if (d0 * d1 <= 0.0 && std::abs(slope) > 3.0 * std::abs(d0)) return 3.0 * d0;
    return slope;
}

}  // namespace

Pchip::Pchip(std::vector<double> x, std::vector<double> y)
    : x_(std::move(x)), y_(std::move(y)), slope_(x_.size()) {
    const std::size_t n = x_.size();
    auto width = [&](std::size_t i) { return x_[i + 1] - x_[i]; };
    auto secant = [&](std::size_t i) { return (y_[i + 1] - y_[i]) / width(i); };
    if (n == 2) {
        slope_[0] = slope_[1] = secant(0);
        return;
    }
    slope_[0] = end_slope(width(0), width(1), secant(0), secant(1));
    slope_[n - 1] = end_slope(width(n - 2), width(n - 3), secant(n - 2), secant(n - 3));
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double left = secant(i - 1);
        const double right = secant(i);
        if (left * right <= 0.0) continue;  // an extremum of the data stays one
        const double w_left = 2.0 * width(i) + width(i - 1);
        const double w_right = width(i) + 2.0 * width(i - 1);
        slope_[i] = (w_left + w_right) / (w_left / left + w_right / right);
    }
}

double Pchip::operator()(double x) const {
    const auto above = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
    const auto i = static_cast<std::size_t>(above - x_.begin()) - 1;
    const double h = x_[i + 1] - x_[i];
    const double t = (x - x_[i]) / h;
    const double u = 1.0 - t;
    return u * u * (1.0 + 2.0 * t) * y_[i] + t * t * (1.0 + 2.0 * u) * y_[i + 1] +
           h * t * u * (u * slope_[i] - t * slope_[i + 1]);
}

}  // namespace togishi
