// What the readings' noise is, from the readings themselves, and which of them are wrong.
#pragma once
#include <vector>

#include "fit/problem.hpp"

namespace togishi {

/// Variance of a reading = (relative times the signal)^2 + (floor times the channel's peak)^2.
struct NoiseModel {
    double relative = 0.02;
    double floor = 0.002;
};

/// Writes the sigma of every reading. Signal: the modelled readings.
void set_sigma(FitProblem& problem, const NoiseModel& noise, const std::vector<double>& modelled);

/// Maximum likelihood over used readings, corrected for the parameters that were fitted to them.
[[nodiscard]] NoiseModel estimate_noise(const FitProblem& problem,
                                        const std::vector<double>& modelled, NoiseModel start,
                                        std::size_t parameters);

/// Marks readings beyond `limit` sigma as outliers and the others as used, or clipped; gaps stay. A
/// clipped reading is wrong only where the model lies below it. Where more than a twentieth would
/// go, the model is wrong and not the readings: then none goes. limit 0: none. Returns how many are
/// marked.
std::size_t mark_outliers(FitProblem& problem, const std::vector<double>& modelled, double limit);

/// -2 ln likelihood of all readings that are neither gaps nor clipped, each counting at most as 5
/// sigma.
[[nodiscard]] double deviance(const FitProblem& problem, const std::vector<double>& modelled);

}  // namespace togishi
