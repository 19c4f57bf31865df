// A blade fitted to points of a scan: its mune line, its cross-sections, and the places where they
// change: machi, yokote, tip and the nakago's end.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scanned/blade_curve.hpp"
#include "scanned/coarse_pose.hpp"
#include "scanned/section_fit.hpp"

namespace togishi {

/// Guesses of the cross-section by arc length, straight between them.
class SectionGuesses {
  public:
    void clear() { s_.clear(), guess_.clear(); }
    void add(double s_mm, const SectionGuess& guess);
    [[nodiscard]] bool empty() const { return s_.empty(); }
    [[nodiscard]] SectionGuess at(double s_mm) const;

  private:
    std::vector<double> s_;
    std::vector<SectionGuess> guess_;
};

/// A line in which two surfaces meet. Where they meet at a flat angle, the mean of many noisy
/// crossings is not the crossing of the means: kept are the gap and its slope at a depth near by.
struct MeetingLine {
    SmoothCurve near_d, gap, gap_by_d;
    [[nodiscard]] double at(double s_mm) const;
};

/// Lines along the blade from the machi to the yokote (without one, to where the point begins) by
/// arc length, mm below the mune line or half thickness.
struct BladeLines {
    double from_s_mm = 0, to_s_mm = 0;
    SmoothCurve top_d, corner_y, corner_d, shinogi_y;
    MeetingLine shinogi_d, edge_d;
};

/// All arc lengths count from the curve's beginning.
struct BladeFit {
    BladeCurve curve;
    bool tang = false;
    bool ridge = false;          ///< there is a shinogi
    bool yokote = false;         ///< the shinogi breaks before the point
    bool yokote_unsure = false;  ///< the shinogi scatters too much to tell whether it breaks
    bool machi = false;  ///< the mune's notch was found; otherwise machi_s_mm is the rough pose's
    MuneKind mune;
    double begin_s_mm = 0;  ///< the nakago's end, or where the scan begins
    double machi_s_mm = 0, yokote_s_mm = 0, tip_s_mm = 0;
    std::vector<SectionFit> nakago, blade;  ///< by s
    SectionGuesses nakago_guess, blade_guess;
    BladeLines lines;
    /// Depth of the point's edge to arc length, from the tip: s = [0] + [1] d + [2] d^2.
    std::array<double, 3> point_edge{};
    double point_edge_to_d_mm = 0;  ///< up to which depth
    double nakago_mm = 0;           ///< from the mune-machi to the farthest point behind it
    double residual_mm = 0;         ///< rms of the points about the fitted surfaces
    std::vector<std::pair<double, double>> fittings_s;  ///< stretches that fittings cover
    bool point = false;
    /// What the user says, in the points' coordinates: beside the machi; yokote to tip, 0 none.
    std::optional<glm::dvec3> given_machi;
    std::optional<double> given_kissaki_mm;
    bool settled = false;   ///< fittings are known by arc length
    double turned_rad = 0;  ///< points are to be turned by this about x before the next fit
};

/// A point of the scan's surface in the rough pose's coordinates.
struct ScanPoint {
    glm::dvec3 position_mm;
    bool omote;  ///< the surface faces +y
};

/// Points in the rough pose's coordinates. False where no cross-sections can be fitted.
[[nodiscard]] bool begin_fit(std::span<const ScanPoint> points, const CoarsePose& pose,
                             BladeFit& fit);
/// The next, better fit. False where it is lost.
[[nodiscard]] bool improve_fit(std::span<const ScanPoint> points, BladeFit& fit);

}  // namespace togishi
