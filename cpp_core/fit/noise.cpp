#include "fit/noise.hpp"

#include <algorithm>
#include <cmath>

namespace togishi {
namespace {

// Below what any instrument reaches: keeps weights finite for data without noise.
constexpr double least_relative = 1e-7;
constexpr double least_floor = 1e-7;
constexpr double cap_sigma = 5;

}  // namespace

void set_sigma(FitProblem& problem, const NoiseModel& noise, const std::vector<double>& modelled) {
    const std::size_t channels = problem.channels();
    for (std::size_t i = 0; i < problem.sigma.size(); ++i) {
        const double peak = problem.peak(i % channels);
        problem.sigma[i] =
            std::hypot(noise.relative * modelled[i], noise.floor * (peak > 0 ? peak : 1.0));
    }
}

NoiseModel estimate_noise(const FitProblem& problem, const std::vector<double>& modelled,
                          NoiseModel start, std::size_t parameters) {
    const std::size_t channels = problem.channels();
    std::size_t used = 0;
    for (const ReadingState s : problem.state) used += s == ReadingState::used ? 1 : 0;
    if (used <= parameters + 1) return start;
    const double freedom = static_cast<double>(used) / static_cast<double>(used - parameters);
    double a = start.relative * start.relative, b = start.floor * start.floor;
    // Scoring: squared residuals regressed on the two parts of the variance, each weighted by its
    // variance.
    for (int pass = 0; pass < 30; ++pass) {
        double ss = 0, sp = 0, pp = 0, sr = 0, pr = 0;
        for (std::size_t i = 0; i < modelled.size(); ++i) {
            if (problem.state[i] != ReadingState::used) continue;
            const double s = modelled[i] * modelled[i];
            const double peak = problem.peak(i % channels);
            const double p = peak > 0 ? peak * peak : 1.0;
            const double v = a * s + b * p;
            const double w = 1 / (v * v);
            const double r = problem.measured()[i] - modelled[i];
            const double r2 = r * r * freedom;
            ss += w * s * s;
            sp += w * s * p;
            pp += w * p * p;
            sr += w * s * r2;
            pr += w * p * r2;
        }
        const double det = ss * pp - sp * sp;
        double next_a = -1, next_b = -1;
        if (det > 1e-12 * ss * pp) {
            next_a = (pp * sr - sp * pr) / det;
            next_b = (ss * pr - sp * sr) / det;
        }
        // A part that comes out negative is none; the other one then explains all.
        if (next_a <= 0 || next_b <= 0) {
            const bool floor_alone = next_a <= 0 && (next_b > 0 || pr * ss > sr * pp);
            next_a = floor_alone ? 0 : sr / ss;
            next_b = floor_alone ? pr / pp : 0;
        }
        // Half-way steps where it would jump: the weights follow.
        next_a = std::clamp(next_a, 0.1 * a, 10 * a);
        next_b = std::clamp(next_b, 0.1 * b, 10 * b);
        next_a = std::max(next_a, least_relative * least_relative);
        next_b = std::max(next_b, least_floor * least_floor);
        const bool settled = std::abs(next_a - a) <= 1e-4 * a && std::abs(next_b - b) <= 1e-4 * b;
        a = next_a;
        b = next_b;
        if (settled) break;
    }
    return {std::sqrt(a), std::sqrt(b)};
}

std::size_t mark_outliers(FitProblem& problem, const std::vector<double>& modelled, double limit) {
    const auto judged = [](ReadingState s) { return s != ReadingState::gap; };
    const auto wrong = [&](std::size_t i) {
        const double off = problem.measured()[i] - modelled[i];
        return limit > 0 &&
               (problem.at_saturation(i) ? off : std::abs(off)) > limit * problem.sigma[i];
    };
    std::size_t all = 0, out = 0;
    for (std::size_t i = 0; i < modelled.size(); ++i) {
        if (!judged(problem.state[i])) continue;
        ++all;
        out += wrong(i) ? 1 : 0;
    }
    const bool too_many = 20 * out > all;
    for (std::size_t i = 0; i < modelled.size(); ++i) {
        if (!judged(problem.state[i])) continue;
        problem.state[i] = !too_many && wrong(i)      ? ReadingState::outlier
                           : problem.at_saturation(i) ? ReadingState::clipped
                                                      : ReadingState::used;
    }
    return too_many ? 0 : out;
}

double deviance(const FitProblem& problem, const std::vector<double>& modelled) {
    double sum = 0;
    for (std::size_t i = 0; i < modelled.size(); ++i) {
        if (problem.state[i] != ReadingState::used && problem.state[i] != ReadingState::outlier)
            continue;
        if (problem.at_saturation(i)) continue;
        const double z = (problem.measured()[i] - modelled[i]) / problem.sigma[i];
        sum += std::min(z * z, cap_sigma * cap_sigma) + 2 * std::log(problem.sigma[i]);
    }
    return sum;
}

}  // namespace togishi
