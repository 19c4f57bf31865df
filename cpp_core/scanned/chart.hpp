// The chart of a scanned blade: the same u, v and millimetres as a generated katana's (frame.hpp).
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "blade/development.hpp"
#include "blade/frame.hpp"
#include "scanned/stations.hpp"

namespace togishi {

struct ChartOptions {
    /// Width of the nominal suguha at the machi, which divides ji and ha on the chart; the real
    /// hamon is no matter of shape. It keeps its share of the ji's width, which it never passes.
    double ha_haba_mm = 8.5;
};

/// Where a point of the scan belongs.
struct ChartPlace {
    double arc_mm = 0;     ///< arc length of the mune line
    double s_mm = 0;       ///< developed length from the mune-machi, negative in the nakago
    double t_mm = 0;       ///< developed distance from the mune ridge, 0 to the edge line
    double middle_mm = 0;  ///< from the blade's middle plane, positive on omote
    double off_mm = 0;     ///< from the blade's smooth outline, positive outside
    double beyond_mm = 0;  ///< past the tip or the nakago's end along the blade, else 0
    [[nodiscard]] bool omote() const { return middle_mm >= 0; }
};

class ScannedChart {
  public:
    /// Throws InputError for stations that are no blade: fewer than 8, not rising, not finite,
    /// without width, or none from the machi to the tip.
    explicit ScannedChart(const ScannedStations& stations, const ChartOptions& options = {});

    [[nodiscard]] const BladeFrame& frame() const { return frame_; }
    /// Of a point in blade coordinates: square to the mune line, then the nearest of the outline.
    [[nodiscard]] ChartPlace place(const glm::dvec3& blade_mm) const;
    /// The other way: the place of the blade's smooth surface that is (s, t), in blade coordinates.
    [[nodiscard]] glm::dvec3 point(double s_mm, double t_mm, bool omote) const;
    [[nodiscard]] glm::dvec2 uv(double s_mm, double t_mm, bool omote) const;
    /// Unit tangent of the mune line, towards the tip.
    [[nodiscard]] glm::dvec3 along(double arc_mm) const;
    [[nodiscard]] double s_mm(double arc_mm) const;
    [[nodiscard]] double arc_mm(double s_mm) const;

  private:
    // Half a cross-section by a fixed number of points, which divide each of mune, shinogi-ji and
    // ji into equal lengths: those of neighbouring sections belong together. The mune's own ridge,
    // where it has one, lies at one of them.
    static constexpr std::size_t mune_cells = 6, shinogi_cells = 8, ji_cells = 24;
    static constexpr std::size_t mune_bend_point = mune_cells / 2;
    static constexpr std::size_t mune_point = mune_cells;
    static constexpr std::size_t shinogi_point = mune_point + shinogi_cells;
    static constexpr std::size_t edge_point = shinogi_point + ji_cells;
    static constexpr std::size_t points = edge_point + 1;
    struct Outline {
        std::array<float, points> across{}, out{}, t{};
        void develop();
        /// (across, out) at t, going on straight beyond the ends.
        [[nodiscard]] glm::dvec2 at(double t_mm) const;
    };
    struct Row {
        double arc_mm = 0;
        glm::dvec3 ridge{}, along{}, across{}, out{};  // out of omote
        std::array<Outline, 2> side;
        /// Developed distance of a point of both outlines, their mean.
        [[nodiscard]] double mean_t(std::size_t point) const {
            return 0.5 * (double(side[0].t[point]) + double(side[1].t[point]));
        }
    };
    /// Where an arc length lies between two rows.
    struct Between {
        std::size_t row;
        double share;
    };

    /// Rows at equal steps on one side of the machi.
    struct Segment {
        std::size_t first_row = 0, rows = 0;
        double begin_mm = 0, step_mm = 1;
    };

    void make_rows(const ScannedStations& stations);
    [[nodiscard]] std::vector<SurfaceMetric> metric_of_rows() const;
    void make_frame(const ScannedStations& stations, const ChartOptions& options);
    [[nodiscard]] Between between(double arc_mm) const;
    [[nodiscard]] double curve(std::size_t point, double arc_mm) const;

    std::vector<Row> rows_;
    Segment nakago_, blade_;  // nakago_: no rows where there is no tang
    BladeFrame frame_;
    std::vector<double> sample_arc_mm_;
    std::vector<double> sample_s_mm_;
};

}  // namespace togishi
