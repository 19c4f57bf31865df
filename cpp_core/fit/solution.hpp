// A fitted set of parameters on its way from the search to the report.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "fit/noise.hpp"
#include "fit/problem.hpp"
#include "fit/solver.hpp"

namespace togishi {

/// How the lobe may be shaped, as far as the scans can tell.
enum class LobeFreedom {
    round,    ///< one half width
    aligned,  ///< two, their axes along the two directions that were scanned
    full      ///< two, and the azimuth of the wide one
};

struct Solution {
    FitParameters parameters;
    FitActive active;
    LobeFreedom lobe = LobeFreedom::round;
    bool haze = false;
    std::string metal;
    NoiseModel noise;
    std::vector<ReadingState> state;
    std::vector<double> sigma;
    double bic = 0;
    bool converged = false;
};

}  // namespace togishi
