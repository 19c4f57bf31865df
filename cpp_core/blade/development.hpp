// How the nearly developable surface of a blade is laid flat: the s of each arc length, the skew of
// sides and mune and the opening of the ridge that frame.hpp describes.
#pragma once
#include <vector>

namespace togishi {

/// What the surface's metric is at one arc length, against (arc length, t).
struct SurfaceMetric {
    struct Point {
        double beyond;  ///< t beyond the mune's corner, negative on the mune
        double length;  ///< |P_arc| less its part along P_t
        double shear;   ///< P_arc . P_t
    };
    std::vector<Point> points;
    double shear = 0;       ///< mean over the side of P_arc . P_t: what turns a line of constant t
                            ///< against the surface
    double mune_slope = 0;  ///< change of the mune's developed half width along the arc
    double half_width = 0;  ///< half of the whole developed width
    double mune_half_width = 0;
};

/// One way to lay the surface out.
struct Development {
    std::vector<double> skew;       ///< between samples
    std::vector<double> mune_skew;  ///< between samples
    std::vector<double> lift_mm;    ///< at samples
    std::vector<double> s_mm;       ///< at samples, from 0
    double worst = 1e9;             ///< largest |singular value - 1| from machi to tip
};

/// The step of the arc length that develop_blade expects: it evens curves out over a fixed number
/// of samples.
inline constexpr double development_step_mm = 0.25;

/// Of several ways to share the misfit of mune and sides out, the one that stretches the chart
/// least at its worst place from the machi (arc length 0) on. `metric` stands between the samples
/// of `arc_mm` (one fewer). The ridge may open from `lift_from_mm` on.
[[nodiscard]] Development develop_blade(const std::vector<SurfaceMetric>& metric,
                                        const std::vector<double>& arc_mm, double lift_from_mm);

/// Value at x of a curve through (xs, ys), straight between them, xs rising; beyond the ends the
/// end pieces' ends.
[[nodiscard]] double interpolated(const std::vector<double>& xs, const std::vector<double>& ys,
                                  double x);

}  // namespace togishi
