// Pictures of a fit: what was measured beside what the fitted model says.
#pragma once
#include "fit/fit.hpp"
#include "plot/canvas.hpp"

namespace togishi {

/// Intensity against receive angle, one panel for each scan (at most 24), all to one scale:
/// measured solid, model dashed, residuals in units of sigma below. scale: 0.25 to 4 times the
/// normal size of 1600 pixels across. Throws InputError.
[[nodiscard]] Picture plot_scans(const Fit& fit, double scale = 1);

/// Half width along the plane of incidence against the turn of the sample, as a polar plot: each
/// scan by itself, with its standard deviation, and the fitted lobe dashed. 1000 x 1000 pixels
/// times scale. Throws InputError.
[[nodiscard]] Picture plot_mu_eff(const Fit& fit, double scale = 1);

}  // namespace togishi
