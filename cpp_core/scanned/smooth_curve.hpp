// A smooth function of one variable through noisy samples: a cubic B-spline by least squares.
#pragma once
#include <span>
#include <vector>

namespace togishi {

struct CurveSample {
    double x = 0;
    double value = 0;
    double weight = 1;
};

class SmoothCurve {
  public:
    SmoothCurve() = default;
    /// Between `from` and `to` in pieces of about piece_length; beyond them it goes on along its
    /// tangent. Samples that lie far off (3.5 times the rest's deviation) are left out. Where
    /// samples are wanting it is as straight as possible. `values` may be empty: the curve is 0.
    static SmoothCurve fit(std::span<const CurveSample> samples, double from, double to,
                           double piece_length);

    [[nodiscard]] double at(double x) const;
    [[nodiscard]] double slope(double x) const;
    [[nodiscard]] double bend(double x) const;                   ///< second derivative
    [[nodiscard]] double residual() const { return residual_; }  ///< rms over the kept samples

  private:
    double from_ = 0;
    double piece_ = 1;
    std::vector<double> coefficient_{0, 0, 0, 0};
    double residual_ = 0;
};

}  // namespace togishi
