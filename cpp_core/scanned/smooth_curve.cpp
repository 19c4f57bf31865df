#include "scanned/smooth_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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

// Solves a symmetric positive matrix (row by row) in place.
bool solve(std::vector<double>& matrix, std::vector<double>& x) {
    const std::size_t n = x.size();
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = j; i < n; ++i) {
            double sum = matrix[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= matrix[i * n + k] * matrix[j * n + k];
            if (i == j) {
                if (!(sum > 0)) return false;
                matrix[j * n + j] = std::sqrt(sum);
            } else {
                matrix[i * n + j] = sum / matrix[j * n + j];
            }
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) x[i] -= matrix[i * n + k] * x[k];
        x[i] /= matrix[i * n + i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) x[i] -= matrix[k * n + i] * x[k];
        x[i] /= matrix[i * n + i];
    }
    return true;
}

}  // namespace

SmoothCurve SmoothCurve::fit(std::span<const CurveSample> samples, double from, double to,
                             double piece_length) {
    SmoothCurve curve;
    curve.from_ = from;
    const int pieces = std::max(1, static_cast<int>(std::lround((to - from) / piece_length)));
    curve.piece_ = std::max(1e-9, to - from) / pieces;
    const auto knots = static_cast<std::size_t>(pieces) + 3;
    curve.coefficient_.assign(knots, 0.0);
    if (samples.empty()) return curve;
    const bool stepped =
        std::any_of(samples.begin(), samples.end(), [](const auto& s) { return s.behind_step; });
    const std::size_t n = knots + (stepped ? 1 : 0);
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
            std::array<std::size_t, 5> index{piece, piece + 1, piece + 2, piece + 3, n - 1};
            std::array<double, 5> row{b[0], b[1], b[2], b[3], 1};
            const std::size_t used = sample.behind_step ? 5 : 4;
            for (std::size_t i = 0; i < used; ++i) {
                for (std::size_t j = 0; j < used; ++j)
                    matrix[index[i] * n + index[j]] += sample.weight * row[i] * row[j];
                x[index[i]] += sample.weight * row[i] * sample.value;
            }
            total += sample.weight;
        }
        // Straight where nothing was measured.
        const double stiff = 1e-7 * std::max(total, 1e-12);
        for (std::size_t i = 0; i + 2 < knots; ++i) {
            const std::array<double, 3> bend{1, -2, 1};
            for (std::size_t a = 0; a < 3; ++a) {
                for (std::size_t b = 0; b < 3; ++b)
                    matrix[(i + a) * n + i + b] += stiff * bend[a] * bend[b];
            }
        }
        for (std::size_t i = 0; i < n; ++i) matrix[i * n + i] += 1e-6 * stiff;
        if (!solve(matrix, x)) break;
        std::copy_n(x.begin(), knots, curve.coefficient_.begin());
        curve.step_ = stepped ? x.back() : 0;

        std::vector<double> off;
        off.reserve(samples.size());
        auto distance = [&](const CurveSample& s) {
            return std::abs(s.value - curve.at(s.x) - (s.behind_step ? curve.step_ : 0));
        };
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
        const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
        std::nth_element(off.begin(), middle, off.end());
        const double cut = 3.5 * 1.4826 * *middle + 1e-6;
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
