// Where a fit starts: read off the curves as a person would.
#pragma once
#include <vector>

#include "fit/problem.hpp"

namespace togishi {

/// How many directions of the lobe the scans cut: 1, 2, or 3 and more (also where they lead out of
/// the plane).
[[nodiscard]] int lobe_directions(const ScanSet& scans);

/// Whether the sample's tilt can be told from the zero of the receive angle: turned by 180 degrees
/// or so.
[[nodiscard]] bool turned(const ScanSet& scans);

/// Whether both tilts show: scans in planes that lie well across each other, or out of the plane.
[[nodiscard]] bool shows_both_tilts(const ScanSet& scans);

/// Up to `count` starts, the likeliest first: half widths and peak positions of the single curves,
/// then the same with wider and narrower, round and turned lobes.
[[nodiscard]] std::vector<FitParameters> starting_points(const ScanSet& scans,
                                                         const FitProblem& problem, int count);

/// Weight and pedestals that suit the rest of the parameters best.
void set_height(const FitProblem& problem, FitParameters& p);

}  // namespace togishi
