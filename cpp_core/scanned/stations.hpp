// A scanned blade as a row of cross-sections along its mune line: what its dimensions, its parts
// and its chart are all taken from.
#pragma once
#include <array>
#include <vector>

#include <glm/glm.hpp>

namespace togishi {

/// Where the blade lies in the scan. Blade coordinates are those of the generated katana
/// (katana_mesh.hpp): mm, mune-machi in the origin, +X to the tip along the line from the
/// mune-machi to the tip, +Z to the back, +Y out of omote.
struct BladePose {
    glm::dmat3 rotation{1};         ///< blade = rotation (scan - origin_mm); a proper rotation
    glm::dvec3 origin_mm{0, 0, 0};  ///< the mune-machi in the scan
};

/// One face of a cross-section, from the mune ridge to the edge. Developed lengths (along the
/// outline) from the ridge.
struct SectionSide {
    std::vector<glm::dvec2>
        outline_mm;           ///< (across from the ridge towards the edge, out of the side)
    double mune_t_mm = 0;     ///< the mune's corner; 0 where the mune is a ridge only
    double shinogi_t_mm = 0;  ///< the shinogi; mune_t_mm where there is none
    double edge_t_mm = 0;     ///< the edge line, the outline's end
};

/// A cross-section in the plane at right angles to the mune line.
struct Station {
    double s_mm = 0;  ///< arc length of the mune line from the mune-machi; negative in the nakago
    glm::dvec3 ridge_mm{};  ///< where the plane meets the mune line, blade coordinates
    glm::dvec3 along{};     ///< unit, tangent of the mune line, towards the tip
    glm::dvec3 across{};    ///< unit, in the section's plane, from the ridge towards the edge
    std::array<SectionSide, 2>
        side;              ///< omote, ura; "out" is +-(across x along), away from the middle plane
    bool measured = true;  ///< false: interpolated over a hole of the scan
};

/// The whole blade. Stations at equal steps from the nakago's end to the tip.
struct ScannedStations {
    std::vector<Station> stations;
    double step_mm = 0;
    double nakago_mm =
        0;  ///< arc length of the mune line behind the mune-machi; 0: the scan has no tang
    double nagasa_arc_mm = 0;  ///< arc length of the mune line from the machi to the tip
    double yokote_s_mm =
        0;  ///< where the yokote meets the mune; nagasa_arc_mm where the blade has none
};

}  // namespace togishi
