// The quench: heat leaves through the clay, spreads within the steel while it does, and where the
// steel cools faster than the critical rate it becomes martensite.
#pragma once
#include <vector>

#include "steel/clay_map.hpp"

namespace togishi {

/// One side after the quench; s and q as in SteelOutline.
struct QuenchedSide {
    /// Distance (mm) from the line where the cooling rate is critical, positive in the hardened
    /// steel. Told from the rate and its slope, so that it is short wherever the rate is near the
    /// critical one (ashi).
    FieldGrid depth_mm;
    /// Width of the nioiguchi relative to that at a sharp clay border: >= 1 where the rate's slope
    /// is gentle.
    FieldGrid softness;
    /// Highest hardened q per column of depth_mm, 0 where there is none. Within the kissaki: the
    /// first line over the edge.
    std::vector<double> crest_q;

    [[nodiscard]] double crest_at(double s) const;
};

[[nodiscard]] QuenchedSide quench(const SteelOutline& outline, const SteelParameters& p,
                                  FieldGrid conductance, unsigned threads);

}  // namespace togishi
