// The mune line of a scan as a smooth curve, and coordinates along and around it.
#pragma once
#include <vector>

#include <glm/glm.hpp>

#include "scanned/smooth_curve.hpp"

namespace togishi {

/// s along the mune line from `from`, y out of omote from the blade's middle, d below the line. mm.
struct BladePoint {
    double s_mm = 0, y_mm = 0, d_mm = 0;
    bool omote = true;  ///< by the way the surface faces: at the edge noise is larger than y
};

/// z(x) of the mune and y(x) of the blade's middle, x roughly along the blade.
class BladeCurve {
  public:
    BladeCurve() = default;
    /// Behind `machi_x`, where the mune is the nakago's, the line goes on with an even bend.
    BladeCurve(SmoothCurve mune, SmoothCurve middle, double from, double to, double machi_x);

    [[nodiscard]] BladePoint locate(const glm::dvec3& p) const;
    /// The mune line at s.
    [[nodiscard]] glm::dvec3 at(double s_mm) const;
    [[nodiscard]] glm::dvec3 along(double s_mm) const;
    /// Unit, in the blade's plane, from the mune towards the edge.
    [[nodiscard]] glm::dvec3 across(double s_mm) const;
    [[nodiscard]] double s_mm(double x) const;
    [[nodiscard]] double x_at(double s_mm) const;

    [[nodiscard]] double middle_y(double x) const { return middle_.at(x); }
    [[nodiscard]] double mune_z(double x) const;
    /// rms of what the line was fitted to.
    [[nodiscard]] double mune_residual() const { return mune_.residual(); }

  private:
    [[nodiscard]] double slope(double x) const;
    [[nodiscard]] double bend(double x) const;

    SmoothCurve mune_, middle_;
    double machi_x_ = 0, machi_z_ = 0, machi_slope_ = 0, machi_bend_ = 0;
    double from_ = 0;
    double step_ = 1;
    std::vector<double> arc_{0, 1};
};

}  // namespace togishi
