// A tabulated spectrum as the polyline through its points, zero outside them.
#pragma once
#include <span>
#include <vector>

#include "spectral/grid.hpp"

namespace togishi {

/// Values of the polyline at increasing `wavelengths_nm`.
/// x strictly increasing, y of the same size, at least one point.
[[nodiscard]] std::vector<double> linear_at(std::span<const double> x, std::span<const double> y,
                                            std::span<const double> wavelengths_nm);

/// The polyline shared out among the samples of a grid: each sample takes 1/step times the integral
/// under its hat, the triangle that reaches to its neighbours. Nothing between the samples is
/// missed, and sum * step is the integral from the first to the last sample exactly.
[[nodiscard]] std::vector<double> linear_shared_out(std::span<const double> x,
                                                    std::span<const double> y, const Grid& grid);

}  // namespace togishi
