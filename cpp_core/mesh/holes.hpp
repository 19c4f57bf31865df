// Where a scan's surface ends: listed with length and place, closed only where asked.
#pragma once
#include <cstdint>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

/// A closed row of border edges.
struct Hole {
    std::vector<std::uint32_t>
        vertices;         ///< in order, the surface on their left (seen from outside)
    double length = 0;    ///< of its border, the mesh's unit
    double size = 0;      ///< diagonal of its box
    glm::dvec3 centre{};  ///< of its box, in the file's coordinates (origin added)
};

/// All holes of a cleaned mesh, the longest first. An open piece's outer border is one too.
[[nodiscard]] std::vector<Hole> find_holes(const TriangleMesh& mesh);

struct HoleClosing {
    std::size_t closed = 0;
    std::size_t left_open =
        0;  ///< too many edges, or no patch without an edge that is there already
    std::size_t triangles_made = 0;  ///< appended to the mesh's triangles: what is inferred
};

/// More edges than this are not closed: without points inside, a large patch lies far from any
/// blade.
inline constexpr std::size_t most_hole_edges = 400;

/// Closes the given holes of `mesh` by the triangles of least area over their border (Barequet and
/// Sharir 1995, Liepa 2003), which are appended; no vertices are made.
[[nodiscard]] HoleClosing close_holes(TriangleMesh& mesh, const std::vector<Hole>& holes);

}  // namespace togishi
