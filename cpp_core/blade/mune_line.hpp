// The line of the mune: a plane curve of given chord (nagasa) and depth (sori).
#pragma once
#include <glm/glm.hpp>

#include "blade/katana_parameters.hpp"

namespace togishi {

/// Positions in mm in the plane (x to the tip, z to the back), the mune-machi at the origin, the
/// tip on +x. The parameter is the arc length from the mune-machi: -nakago_arc_mm() to
/// blade_arc_mm().
class MuneLine {
  public:
    struct Point {
        glm::dvec2 position_mm;   ///< x, z
        glm::dvec2 tangent;       ///< unit, towards the tip
        double curvature_per_mm;  ///< > 0: the tip bends towards the back
    };
    MuneLine(double nagasa_mm, double sori_mm, SoriType type, double nakago_mm);

    [[nodiscard]] double blade_arc_mm() const { return blade_arc_mm_; }
    [[nodiscard]] double nakago_arc_mm() const { return nakago_arc_mm_; }
    [[nodiscard]] Point at(double arc_mm) const;

  private:
    [[nodiscard]] double angle(double arc_mm) const;
    [[nodiscard]] double curvature(double arc_mm) const;
    [[nodiscard]] glm::dvec2 integrate(double from_mm, double to_mm) const;

    double turn_rad_ = 0;     // between the tangents at machi and tip
    double start_rad_ = 0;    // tangent at the machi
    double c1_ = 0, c2_ = 0;  // curvature over its mean: 1 + c1 (x - 1/2) + c2 ((x - 1/2)^2 - 1/12)
    double blade_arc_mm_ = 0;
    double nakago_arc_mm_ = 0;
};

}  // namespace togishi
