// A scan's separate pieces: the blade, its stand, a scale bar, a colour target, specks.
#pragma once
#include <cstdint>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

/// Triangles that hang together by their vertices.
struct Piece {
    std::size_t first_triangle = 0, triangle_count = 0;  ///< a run of the mesh's triangles
    std::size_t first_vertex = 0, vertex_count = 0;      ///< and of its vertices
    double area = 0;                                     ///< unit squared
    glm::dvec3 low{}, high{};  ///< its box, in the file's coordinates (origin added)

    [[nodiscard]] glm::dvec3 centre() const { return 0.5 * (low + high); }
    [[nodiscard]] double diagonal() const { return glm::length(high - low); }
};

/// Puts the triangles and vertices of each piece side by side, the piece of the largest area first,
/// and keeps their order within it. A cleaned mesh: vertices in no triangle are dropped.
[[nodiscard]] std::vector<Piece> sort_into_pieces(TriangleMesh& mesh);

/// A piece as a mesh of its own, of the same origin.
[[nodiscard]] TriangleMesh take_piece(const TriangleMesh& mesh, const Piece& piece);

}  // namespace togishi
