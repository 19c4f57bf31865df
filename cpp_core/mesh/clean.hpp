// What stands in a scan's mesh that no surface has, taken out or mended. Nothing is thrown away
// that was scanned: pieces (pieces.hpp) and holes (holes.hpp) are listed and left to the user.
#pragma once
#include <cstdint>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

struct CleanOptions {
    /// Vertices at most this far apart (the mesh's unit) become one; 0: only those at the same
    /// place. More than a tenth of the scan's point spacing eats detail.
    double weld_distance = 0;
};

/// Counts of what was changed.
struct CleanReport {
    std::size_t vertices_before = 0, triangles_before = 0;
    std::size_t vertices_after = 0, triangles_after = 0;
    std::size_t welded_vertices = 0;       ///< became one with another at their place
    std::size_t unused_vertices = 0;       ///< in no triangle
    std::size_t degenerate_triangles = 0;  ///< without area: two corners alike, or all in a line
    std::size_t split_at_degenerate =
        0;  ///< neighbours of a line-like triangle, split at its middle corner
    std::size_t duplicate_triangles = 0;    ///< the same three vertices, in either winding
    std::size_t non_manifold_edges = 0;     ///< edges of three triangles and more
    std::size_t non_manifold_vertices = 0;  ///< where surfaces touch in a point
    std::size_t vertices_split_off = 0;     ///< copies made to part the surfaces there
    std::size_t flipped_triangles = 0;      ///< turned to agree with their neighbours
    std::size_t reversed_pieces = 0;        ///< whole pieces that were inside out
    std::size_t undecided_pieces = 0;       ///< sheets without inside: left as most of them were
    std::size_t one_sided_edges = 0;        ///< cut where no winding agrees (a Moebius strip)
};

/// Cleans in place; then every edge has one or two triangles, wound alike, every vertex one fan,
/// closed pieces have positive volume, vertices and triangles are in their former order. Twice does
/// no more than once. Time n log n at most, memory 0.1 GiB per million triangles beside the mesh's.
/// Throws InputError where weld_distance is not a finite number of at least 0.
[[nodiscard]] CleanReport clean(TriangleMesh& mesh, const CleanOptions& options = {});

}  // namespace togishi
