// Piecewise cubic Hermite interpolation that keeps the data's monotonic runs (PCHIP).
#pragma once
#include <vector>

namespace togishi {

/// Passes through every (x, y), has a continuous first derivative, never overshoots between two
/// neighbouring points. Slopes: Fritsch & Butland's weighted harmonic mean inside, the one-sided
/// three-point formula limited to keep shape at the ends (F. N. Fritsch and R. E. Carlson, SIAM J.
/// Numer. Anal. 17 (1980) 238; F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984)
/// 300).
class Pchip {
  public:
    Pchip() = default;
    /// x strictly increasing, at least two points, y of the same size; the caller has checked it.
    Pchip(std::vector<double> x, std::vector<double> y);
    /// x inside [front, back] of the data; outside, the end cubic goes on.
    [[nodiscard]] double operator()(double x) const;

  private:
    std::vector<double> x_;
    std::vector<double> y_;
    std::vector<double> slope_;
};

}  // namespace togishi
