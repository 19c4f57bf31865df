// Which triangles meet at which edges. Half-edge 3 t + k runs from corner k of triangle t to the
// next.
#pragma once
#include <cstdint>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

inline constexpr std::uint32_t no_half_edge = 0xffffffffU;

inline std::uint32_t next_half_edge(std::uint32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
inline std::uint32_t previous_half_edge(std::uint32_t h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

/// Where a half-edge starts.
inline std::uint32_t start_of(const std::vector<Triangle>& triangles, std::uint32_t h) {
    return triangles[h / 3][h % 3];
}

struct HalfEdges {
    /// 3 F: the half-edge of the other triangle where an edge has two, else no_half_edge.
    std::vector<std::uint32_t> twin;
    /// Edges of three triangles and more, and, strict, those of two that are wound against each
    /// other: their half-edges. Strict: twins among them are those that bound one body there.
    std::vector<std::vector<std::uint32_t>> crowded;
    std::size_t same_way = 0;  ///< edges whose two triangles are wound against each other
    /// F, 1: an earlier triangle has the same three vertices; empty: none.
    std::vector<std::uint8_t> duplicate;
    std::size_t duplicates = 0;
};

/// strict: triangles that are wound against each other are no twins. Linear; 52 bytes per triangle
/// while it works, 12 after it. No triangle may have two corners alike.
[[nodiscard]] HalfEdges link_half_edges(const TriangleMesh& mesh, bool strict);

}  // namespace togishi
