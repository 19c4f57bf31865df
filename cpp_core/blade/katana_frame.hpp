// The chart of a generated katana.
#pragma once
#include "blade/frame.hpp"
#include "blade/katana_shape.hpp"

namespace togishi {

/// One line across the chart: the developed distances from the mune ridge to each strip's far
/// border.
struct ChartRow {
    std::array<double, 6> strip_end_mm{};  ///< indexed by Strip
    double mune_mm = 0;
    double shinogi_mm = 0;
    double suguha_mm = 0;
    double edge_mm = 0;  ///< the edge line; in the nakago the middle of its foot
};

/// Chart and surface of a katana: s for each arc length of the mune line, and the frame built on
/// it.
class KatanaChart {
  public:
    explicit KatanaChart(const KatanaShape& shape);

    [[nodiscard]] const BladeFrame& frame() const { return frame_; }
    /// Developed length s at an arc length of the mune line (both 0 at the machi).
    [[nodiscard]] double s_mm(double arc_mm) const;
    [[nodiscard]] double arc_mm(double s_mm) const;

    static ChartRow row(const KatanaShape& shape, Stretch stretch, double q);

  private:
    BladeFrame frame_;
    std::vector<double> sample_arc_mm_;
    std::vector<double> sample_s_mm_;
};

/// What steel patterns and operators need: the frame of a blade of these dimensions. Throws
/// InputError as check_katana.
BladeFrame make_blade_frame(const KatanaParameters& parameters);

}  // namespace togishi
