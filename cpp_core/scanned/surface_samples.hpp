// Points spread evenly over a mesh's surface, whatever its triangles' sizes, and the pieces that
// the mesh falls into.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

struct SurfaceSample {
    std::uint32_t triangle = 0;
    std::array<float, 2> weight{};  ///< of the triangle's second and third corner
};

/// A connected part of a mesh.
struct MeshPiece {
    double area_mm2 = 0;
    glm::dvec3 low{}, high{};  ///< bounding box, as TriangleMesh::positions
    std::size_t triangles = 0;

    /// From corner to corner of its box: a blade's length in any pose.
    [[nodiscard]] double extent() const { return glm::distance(low, high); }
    /// Its width if it is a blade, whose two sides make up most of the area.
    [[nodiscard]] double rough_width() const { return 0.5 * area_mm2 / extent(); }
};
struct MeshPieces {
    std::vector<MeshPiece> pieces;  ///< largest area first
    std::vector<std::uint32_t> of;  ///< per triangle, its piece
};

/// Triangles that share a vertex are of one piece.
[[nodiscard]] MeshPieces find_pieces(const TriangleMesh& mesh);

/// About `count` points over the triangles whose piece is `wanted`; small triangles give a point in
/// their middle or none, large ones several. The same each time.
[[nodiscard]] std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh,
                                                        const MeshPieces& pieces,
                                                        std::span<const char> wanted, double count);

/// The same with `per_mm2` points per mm2 about a place (of TriangleMesh::positions).
[[nodiscard]] std::vector<SurfaceSample> sample_surface(
    const TriangleMesh& mesh, const MeshPieces& pieces, std::span<const char> wanted,
    const std::function<double(const glm::dvec3& middle)>& per_mm2);

[[nodiscard]] inline glm::dvec3 sample_position(const TriangleMesh& mesh, const SurfaceSample& s) {
    const Triangle& t = mesh.triangles[s.triangle];
    const double b = s.weight[0];
    const double c = s.weight[1];
    return (1 - b - c) * glm::dvec3(mesh.positions[t[0]]) + b * glm::dvec3(mesh.positions[t[1]]) +
           c * glm::dvec3(mesh.positions[t[2]]);
}

}  // namespace togishi
