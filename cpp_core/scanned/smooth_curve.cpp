#include "scanned/smooth_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/order_statistics.hpp"
#include "scanned/least_squares.hpp"

namespace togishi {
namespace {

// Weights of the four B-splines over a piece, at x in [0, 1], and their derivatives.
std::array<double, 4> spline(double x, int derivative) {
    if (derivative == 0) {
        const double r = 1 - x;
        return {r * r * r / 6, (4 - 6 * x * x + 3 * x * x * x) / 6,
                (1 + 3 * x + 3 * x * x - 3 * x * x * x) / 6, x * x * x / 6};
    }
    if (derivative == 1) {
        return {-(1 - x) * (1 - x) / 2, (-4 * x + 3 * x * x) / 2, (1 + 2 * x - 3 * x * x) / 2,
                x * x / 2};
    }
    return {1 - x, -2 + 3 * x, 1 - 3 * x, x};
}

}  // namespace

SmoothCurve SmoothCurve::fit(std::span<const CurveSample> samples, double from, double to,
                             double piece_length) {
    SmoothCurve curve;
    curve.from_ = from;
    const int pieces = std::max(1, static_cast<int>(std::lround((to - from) / piece_length)));
    curve.piece_ = std::max(1e-9, to - from) / pieces;
    const auto n = static_cast<std::size_t>(pieces) + 3;
    curve.coefficient_.assign(n, 0.0);
    if (samples.empty()) return curve;
    std::vector<char> kept(samples.size(), 1);
    for (int pass = 0; pass < 4; ++pass) {
        std::vector<double> matrix(n * n, 0.0);
        std::vector<double> x(n, 0.0);
        double total = 0;
        for (std::size_t k = 0; k < samples.size(); ++k) {
            if (kept[k] == 0) continue;
            const CurveSample& sample = samples[k];
            const double place =
                std::clamp((sample.x - from) / curve.piece_, 0.0, static_cast<double>(pieces));
            const auto piece =
                std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(pieces) - 1);
            const auto b = spline(place - static_cast<double>(piece), 0);
            for (std::size_t i = 0; i < 4; ++i) {
                for (std::size_t j = 0; j < 4; ++j)
                    matrix[(piece + i) * n + piece + j] += sample.weight * b[i] * b[j];
                x[piece + i] += sample.weight * b[i] * sample.value;
            }
            total += sample.weight;
        }
        // Straight where nothing was measured.
        const double stiff = 1e-7 * std::max(total, 1e-12);
        for (std::size_t i = 0; i + 2 < n; ++i) {
            const std::array<double, 3> bend{1, -2, 1};
            for (std::size_t a = 0; a < 3; ++a) {
                for (std::size_t b = 0; b < 3; ++b)
                    matrix[(i + a) * n + i + b] += stiff * bend[a] * bend[b];
            }
        }
        for (std::size_t i = 0; i < n; ++i) matrix[i * n + i] += 1e-6 * stiff;
        if (!solve_positive(matrix.data(), x.data(), n, 0)) break;
        curve.coefficient_ = x;

        std::vector<double> off;
        off.reserve(samples.size());
        auto distance = [&](const CurveSample& s) { return std::abs(s.value - curve.at(s.x)); };
        double squares = 0;
        std::size_t count = 0;
        for (std::size_t k = 0; k < samples.size(); ++k) {
            const double d = distance(samples[k]);
            if (samples[k].weight > 0) off.push_back(d);
            if (kept[k] == 0) continue;
            squares += d * d;
            ++count;
        }
        if (off.empty() || count == 0) break;
        curve.residual_ = std::sqrt(squares / static_cast<double>(count));
        const double cut = 3.5 * 1.4826 * median(off) + 1e-6;
        for (std::size_t k = 0; k < samples.size(); ++k)
            kept[k] = distance(samples[k]) <= cut ? 1 : 0;
    }
    return curve;
}

double SmoothCurve::at(double x) const {
    const auto pieces = static_cast<double>(coefficient_.size() - 3);
    const double place = (x - from_) / piece_;
    const double inside = std::clamp(place, 0.0, pieces);
    const auto piece = static_cast<std::size_t>(std::min(inside, pieces - 1));
    const auto b = spline(inside - static_cast<double>(piece), 0);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += b[k] * coefficient_[piece + k];
    return place == inside ? sum : sum + (place - inside) * piece_ * slope(x);
}

double SmoothCurve::slope(double x) const {
    const auto pieces = static_cast<double>(coefficient_.size() - 3);
    const double inside = std::clamp((x - from_) / piece_, 0.0, pieces);
    const auto piece = static_cast<std::size_t>(std::min(inside, pieces - 1));
    const auto b = spline(inside - static_cast<double>(piece), 1);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += b[k] * coefficient_[piece + k];
    return sum / piece_;
}

double SmoothCurve::bend(double x) const {
    const auto pieces = static_cast<double>(coefficient_.size() - 3);
    const double place = (x - from_) / piece_;
    if (place < 0 || place > pieces) return 0;
    const auto piece = static_cast<std::size_t>(std::min(place, pieces - 1));
    const auto b = spline(place - static_cast<double>(piece), 2);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += b[k] * coefficient_[piece + k];
    return sum / (piece_ * piece_);
}

}  // namespace togishi
