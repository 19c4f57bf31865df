// What a fit found, in the terms of people: values with their 1-sigma, what the data cannot tell
// and why.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "fit/fit.hpp"
#include "fit/problem.hpp"
#include "fit/solution.hpp"

namespace togishi {

/// Fills fit.record, fit.fitted, fit.lobe and fit.state from a solution that `problem` holds in all
/// its readings.
void write_report(Fit& fit, FitProblem& problem, const Solution& solution,
                  const FitOptions& options,
                  const std::vector<std::pair<std::string, double>>& metals, bool stated_sigma,
                  const std::function<void()>& after_step);

}  // namespace togishi
