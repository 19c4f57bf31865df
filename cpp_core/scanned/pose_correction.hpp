// What the user says of a pose that was found wrong. What is left of a pose is no question: mune
// and edge lie in the blade's plane, and the mune line is where the mune is.
#pragma once
#include <optional>

#include <glm/glm.hpp>

namespace togishi {

struct PoseCorrection {
    bool swap_ends = false;           ///< tip and tang the other way round
    bool swap_edge_and_back = false;  ///< edge and back the other way round
    /// A point beside the machi, in the scan's coordinates: lengths count from its place along the
    /// mune line. none: as found.
    std::optional<glm::dvec3> machi_mm;
    /// Straight from the yokote on the mune to the tip; 0: the blade has no yokote. none: as found.
    std::optional<double> kissaki_mm;
};

}  // namespace togishi
