// Where a point of the blade's chart (u, v) lies on the blade.
//
// The chart is the developed surface: u runs from the nakago's end to the tip, v across. The mune
// ridge is v = 0.5; omote lies below it (v -> 0 towards its edge line), ura above (v -> 1 towards
// its edge). Both axes keep millimetres (stretch <= 2 %): u = (x + nakago)/length, |v - 0.5| =
// y/chart height. So one texel has the same size everywhere on the blade.
//
// x = s - skew(s) (t - mune(s)), y = t + lift(s), t being the developed distance from the mune
// ridge. Where the mune narrows towards the tip, its two sides and it do not fit together flat: the
// ridge, which is a seam of the chart, opens there by `lift` on each side, and the mune and the
// sides are turned against it, each by its own skew.
#pragma once
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "blade/part.hpp"

namespace togishi {

/// A point of the chart in the blade's own measures.
struct ChartPoint {
    double s_mm = 0;  ///< developed length from the mune-machi, negative in the nakago
    double from_edge_mm =
        0;  ///< shortest developed distance to the edge line (fukura included), >= 0 on the blade
    double from_ridge_mm = 0;  ///< developed distance across from the mune ridge, >= 0
    Part part = Part::other;   ///< Part::other outside the blade's outline
    bool omote = true;
};

/// The blade's outline in its chart. Built by make_blade_frame (katana_frame.hpp) or from a
/// scan (scanned/chart.hpp). Outline curves are sampled at equal steps of s from -nakago_mm to
/// nagasa_mm.
class BladeFrame {
  public:
    double nakago_mm = 0;         ///< chart length of the nakago; 0: a scan without a tang
    double nagasa_mm = 0;         ///< chart length machi to tip, > 0
    double chart_height_mm = 0;   ///< developed width that v in [0, 1] spans
    double yokote_s_mm = 0;       ///< where the yokote lies; nagasa where the blade has none
    std::vector<double> edge_mm;  ///< from the mune ridge to the edge line, per sample
    std::vector<double>
        shinogi_mm;  ///< from the mune ridge to the shinogi; equals mune_mm where there is none
    std::vector<double> mune_mm;  ///< from the mune ridge to the mune's corner
    std::vector<double>
        suguha_mm;  ///< from the mune ridge to the nominal suguha, the border of ji and ha
    std::vector<double> skew;       ///< of the sides, see above, radians
    std::vector<double> mune_skew;  ///< of the mune, radians
    std::vector<double> lift_mm;    ///< of the ridge from v = 0.5; 0 up to the kissaki

    [[nodiscard]] double length_mm() const { return nakago_mm + nagasa_mm; }
    /// u, v in [0, 1]; outside, the nearest point of the chart's border is taken.
    [[nodiscard]] ChartPoint locate(double u, double v) const;

    /// Part of the point at s, t; Part::other beyond the edge line.
    [[nodiscard]] Part part_at(double s_mm, double from_ridge_mm) const;

    /// Chart abscissa (u = (x + nakago)/length) of the point at s, t.
    [[nodiscard]] double chart_x_mm(double s_mm, double from_ridge_mm) const;
    /// Chart ordinate (|v - 0.5| = y/chart_height) of the point at s, t.
    [[nodiscard]] double chart_y_mm(double s_mm, double from_ridge_mm) const;
    /// Value of one of the outline curves at s (linear between samples, clamped).
    [[nodiscard]] double at(const std::vector<double>& curve, double s_mm) const;

  private:
    [[nodiscard]] double distance_to_edge_mm(double x_mm, double t_mm, double s_mm) const;
};

/// The outline curves by name, for keeping a frame in a file.
inline constexpr std::array<std::pair<std::string_view, std::vector<double> BladeFrame::*>, 7>
    frame_curves{{{"edge_mm", &BladeFrame::edge_mm},
                  {"shinogi_mm", &BladeFrame::shinogi_mm},
                  {"mune_mm", &BladeFrame::mune_mm},
                  {"suguha_mm", &BladeFrame::suguha_mm},
                  {"skew", &BladeFrame::skew},
                  {"mune_skew", &BladeFrame::mune_skew},
                  {"lift_mm", &BladeFrame::lift_mm}}};

/// The lengths by name.
inline constexpr std::array<std::pair<std::string_view, double BladeFrame::*>, 4> frame_lengths{
    {{"nakago_mm", &BladeFrame::nakago_mm},
     {"nagasa_mm", &BladeFrame::nagasa_mm},
     {"chart_height_mm", &BladeFrame::chart_height_mm},
     {"yokote_s_mm", &BladeFrame::yokote_s_mm}}};

/// Throws InputError naming the first length or curve that no blade's chart has: curves of other
/// lengths than the others' or of less than 2 or more than a million samples, numbers that are not
/// finite or beyond 1e5 mm, a blade of no length.
void check_frame(const BladeFrame& frame, std::string_view where);

}  // namespace togishi
