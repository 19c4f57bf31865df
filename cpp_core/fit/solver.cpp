#include "fit/solver.hpp"

#include <algorithm>
#include <cmath>

namespace togishi {
namespace {

// What the model evaluates (shaders/shared/lobe.glsl) and an instrument can be.
void keep_in_range(FitParameters& p) {
    const auto clamp = [&](int k, double low, double high) {
        p.shared[k] = std::clamp(p.shared[k], low, high);
    };
    constexpr double steepest = 0.3;  // rad
    clamp(index_ln_weight, -60, 60);
    clamp(index_ln_mu_deg, std::log(0.002), std::log(75.0));
    const double r = std::hypot(p.shared[index_e_along], p.shared[index_e_across]);
    constexpr double longest = 2.3;
    if (r > longest) {
        p.shared[index_e_along] *= longest / r;
        p.shared[index_e_across] *= longest / r;
    }
    for (const int k : {index_tilt_along, index_tilt_across, index_receive, index_out_of_plane})
        clamp(k, -steepest, steepest);
    clamp(index_ln_haze_share, std::log(1e-5), std::log(0.7));
    clamp(index_ln_haze_width, std::log(1.3), std::log(30.0));
    for (Eigen::Index k = index_pedestal; k < p.shared.size(); ++k)
        p.shared[k] = std::clamp(p.shared[k], -10.0, 10.0);
    for (double& g : p.ln_gain) g = std::clamp(g, -30.0, 30.0);
}

struct Step {
    Eigen::VectorXd shared, gain;
};

// Solves (H + lambda diag H) step = gradient, the gains eliminated first.
Step damped_step(const NormalEquations& e, double lambda) {
    Eigen::MatrixXd h = e.shared;
    // A parameter that no reading feels has a zero row: it then stays.
    for (Eigen::Index i = 0; i < h.rows(); ++i) h(i, i) += lambda * h(i, i) + 1e-30;
    Eigen::VectorXd g = e.shared_gradient;
    Step step;
    if (e.gain.size() > 0) {
        const Eigen::VectorXd inverse = ((1 + lambda) * e.gain.array() + 1e-30).inverse();
        const Eigen::MatrixXd scaled = e.mixed * inverse.asDiagonal();
        h.noalias() -= scaled * e.mixed.transpose();
        g.noalias() -= scaled * e.gain_gradient;
        step.shared = h.ldlt().solve(g);
        step.gain = inverse.asDiagonal() * (e.gain_gradient - e.mixed.transpose() * step.shared);
    } else {
        step.shared = h.ldlt().solve(g);
    }
    return step;
}

FitParameters moved(const FitParameters& from, const FitActive& active, const Step& step) {
    FitParameters to = from;
    for (std::size_t a = 0; a < active.shared.size(); ++a)
        to.shared[active.shared[a]] += step.shared[static_cast<Eigen::Index>(a)];
    if (active.gain) to.ln_gain += step.gain;
    keep_in_range(to);
    return to;
}

}  // namespace

SolverResult solve(const FitProblem& problem, FitParameters start, const FitActive& active,
                   const SolverOptions& options, const std::function<void()>& after_step) {
    keep_in_range(start);
    SolverResult result;
    result.parameters = std::move(start);
    double lambda = 1e-3, growth = 2;
    NormalEquations e = problem.linearised(result.parameters, active);
    after_step();
    result.cost = e.cost;
    for (; result.iterations < options.max_iterations; ++result.iterations) {
        const Step step = damped_step(e, lambda);
        if (!step.shared.allFinite() || !step.gain.allFinite()) {
            lambda *= 10;
            if (lambda > 1e16) break;
            continue;
        }
        const FitParameters next = moved(result.parameters, active, step);
        const double predicted = step.shared.dot(e.shared_gradient) +
                                 (step.gain.size() > 0 ? step.gain.dot(e.gain_gradient) : 0.0);
        // What the undamped quadratic would still gain is at most twice this.
        if (predicted <= options.cost_tolerance * (1 + result.cost) && lambda <= 1e-2) {
            result.converged = true;
            break;
        }
        NormalEquations at_next = problem.linearised(next, active);
        after_step();
        const double gained = result.cost - at_next.cost;
        if (std::isfinite(at_next.cost) && gained > 0) {
            const double ratio = std::clamp(gained / std::max(predicted, 1e-300), 0.0, 2.0);
            lambda = std::max(1e-12, lambda * std::max(0.1, 1 - std::pow(2 * ratio - 1, 3)));
            growth = 2;
            result.parameters = next;
            e = std::move(at_next);
            result.cost = e.cost;
            if (gained <= options.cost_tolerance * (1 + result.cost) && ratio > 0.25) {
                result.converged = true;
                break;
            }
        } else {
            lambda *= growth;
            growth *= 2;
            if (lambda > 1e16) {
                result.converged = true;  // no step of any length leads down: rounding decides here
                break;
            }
        }
    }
    return result;
}

Covariance covariance(const FitProblem& problem, const FitParameters& at, const FitActive& active) {
    const NormalEquations e = problem.linearised(at, active);
    Eigen::MatrixXd h = e.shared;
    // Scaled to a unit diagonal: parameters differ by many orders.
    Eigen::MatrixXd scaled_mixed = e.mixed;
    Eigen::VectorXd inverse;
    if (e.gain.size() > 0) {
        inverse = (e.gain.array() + 1e-30).inverse();
        scaled_mixed = e.mixed * inverse.asDiagonal();
        h.noalias() -= scaled_mixed * e.mixed.transpose();
    }
    const Eigen::VectorXd d =
        h.diagonal().unaryExpr([](double v) { return v > 1e-30 ? 1 / std::sqrt(v) : 0.0; });
    Eigen::MatrixXd unit = d.asDiagonal() * h * d.asDiagonal();
    // A direction without information gets a large variance instead of a division by zero.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit);
    const Eigen::VectorXd values =
        eigen.eigenvalues().unaryExpr([](double v) { return 1 / std::max(v, 1e-12); });
    Covariance result;
    result.shared = d.asDiagonal() * eigen.eigenvectors() * values.asDiagonal() *
                    eigen.eigenvectors().transpose() * d.asDiagonal();
    for (Eigen::Index i = 0; i < d.size(); ++i) {
        if (d[i] == 0) result.shared(i, i) = 1e30;
    }
    if (e.gain.size() > 0) {
        result.gain = inverse;
        for (Eigen::Index s = 0; s < inverse.size(); ++s) {
            const Eigen::VectorXd column = scaled_mixed.col(s);
            result.gain[s] += column.dot(result.shared * column);
        }
    }
    return result;
}

}  // namespace togishi
