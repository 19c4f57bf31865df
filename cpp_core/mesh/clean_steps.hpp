// The steps of clean(), one per file.
#pragma once
#include "mesh/clean.hpp"
#include "mesh/half_edges.hpp"

namespace togishi {

/// Vertices at one place become the first of them; triangles with two corners alike go.
void weld(TriangleMesh& mesh, double distance, CleanReport& report);

/// Triangles without area: their longest edge's neighbour is split at the corner that lies on it,
/// so that no gap opens.
void remove_flat_triangles(TriangleMesh& mesh, CleanReport& report);

/// Triangles marked in `drop` go; the others keep their order.
void remove_marked(TriangleMesh& mesh, const std::vector<std::uint8_t>& drop);

/// Turns triangles until neighbours agree, the smaller part of each connected surface. `edges`: not
/// strict; its twins are unlinked where no winding agrees.
void agree_windings(TriangleMesh& mesh, HalfEdges& edges, CleanReport& report);

/// Parts surfaces that meet in an edge of three triangles and more, or in a point. `edges`: strict.
void part_surfaces(TriangleMesh& mesh, HalfEdges edges, CleanReport& report);

/// Parts a closed surface where it is pinched together along an edge, as collapses leave it, into
/// surfaces that are closed each. Triangles keep their order, new vertices lie where others do.
void part_pinches(TriangleMesh& mesh);

/// Turns pieces inside out that have negative volume.
void turn_outward(TriangleMesh& mesh, CleanReport& report);

/// Vertices in no triangle go; the others keep their order.
void remove_unused_vertices(TriangleMesh& mesh, CleanReport& report);

}  // namespace togishi
