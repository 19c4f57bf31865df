// From a fitted blade to its cross-sections at equal steps, which its chart is made of.
#pragma once
#include <span>

#include "scanned/blade_fit.hpp"
#include "scanned/stations.hpp"

namespace togishi {

/// Rotation and mune-machi of the blade in the coordinates of the fit's points.
[[nodiscard]] BladePose pose_of_fit(const BladeFit& fit);

/// Every step_mm or a little less, in blade coordinates. Fittings and holes are bridged
/// (Station::measured). `points`: what was fitted, for the nakago's round end.
[[nodiscard]] ScannedStations stations_of_fit(const BladeFit& fit,
                                              std::span<const ScanPoint> points,
                                              double step_mm = 1);

}  // namespace togishi
