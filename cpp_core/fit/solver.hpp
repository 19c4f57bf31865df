// Levenberg-Marquardt on a FitProblem. Written for it instead of a general solver: the gains are
// eliminated scan by scan, the Jacobian is never stored (10^6 readings), convergence is relative,
// and a run can be cancelled.
#pragma once
#include <functional>

#include <Eigen/Dense>

#include "fit/problem.hpp"

namespace togishi {

struct SolverOptions {
    int max_iterations = 60;
    double cost_tolerance = 1e-7;  ///< relative decrease that ends it
};

struct SolverResult {
    FitParameters parameters;
    double cost = 0;
    int iterations = 0;
    bool converged = false;
};

/// From a start to the nearest minimum. Parameters stay in the range that the model evaluates.
/// after_step is called after each evaluation and may throw.
[[nodiscard]] SolverResult solve(const FitProblem& problem, FitParameters start,
                                 const FitActive& active, const SolverOptions& options,
                                 const std::function<void()>& after_step);

/// Inverse of the normal equations: covariance of the active shared parameters, and variances of
/// the gains.
struct Covariance {
    Eigen::MatrixXd shared;
    Eigen::VectorXd gain;
};
[[nodiscard]] Covariance covariance(const FitProblem& problem, const FitParameters& at,
                                    const FitActive& active);

}  // namespace togishi
