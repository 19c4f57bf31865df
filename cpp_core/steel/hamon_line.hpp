// What the smith draws with clay on one side of a blade: the line that parts thick clay (ji) from
// thin clay (ha), the crests that rise from it, and the thin strips laid across the ha.
#pragma once
#include <vector>

#include "steel/steel_outline.hpp"
#include "steel/steel_parameters.hpp"

namespace togishi {

/// A crest of thin clay that rises from the base line. Lengths in mm, q over the edge line.
struct HamonCrest {
    enum class Kind {
        arch,   ///< gunome: half an ellipse on the base line
        clove,  ///< choji: a round head on a narrower neck
        point,  ///< togariba: a neck that narrows to its tip
        island  ///< tobiyaki: a head that stands free of the line
    };
    Kind kind = Kind::arch;
    double s = 0;  ///< middle of the foot
    double foot_q = 0;
    double lean = 0;       ///< how far the head's middle lies towards the tip
    double head_q = 0;     ///< middle of the head (arch: its top is head_q + head_high)
    double head_half = 1;  ///< half width of the head
    double head_high = 1;  ///< half height of the head
    double neck_half = 1;  ///< half width of the foot
};

/// A strip of thick clay within the ha: a leg (ashi) or, where short, a leaf (yo).
struct ClayStrip {
    double s0 = 0, q0 = 0, s1 = 0, q1 = 0;
    double half_width = 0.2;
    double strength = 1;  ///< share of the thick clay's insulation, [0, 1]
};

/// One side's drawing. crests and strips are sorted by s.
struct HamonLine {
    static constexpr double base_step_mm = 0.5;
    std::vector<double> base;  ///< height of the base line at s = i base_step_mm
    std::vector<HamonCrest> crests;
    std::vector<ClayStrip> strips;

    [[nodiscard]] double base_at(double s) const;
};

/// How far the waves have grown at s: 0 at the machi, calm in the yakidashi, calmer again before
/// the kissaki.
[[nodiscard]] double wave_share(const SteelOutline& outline, const SteelParameters& p, double s);

/// Height of the line without waves at s, over the edge: it rises from the edge at the ha-machi and
/// follows the blade's width towards the tip.
[[nodiscard]] double calm_height(const SteelOutline& outline, const SteelParameters& p, double s);

[[nodiscard]] HamonLine draw_hamon(const SteelOutline& outline, const SteelParameters& p,
                                   bool omote);

}  // namespace togishi
