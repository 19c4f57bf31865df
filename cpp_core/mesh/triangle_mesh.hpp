// A triangle mesh as a scanner delivers it. Knows nothing of blades, units or files.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace togishi {

using Triangle = std::array<std::uint32_t, 3>;
using Colour8 = std::array<std::uint8_t, 4>;  ///< sRGB and alpha

/// V vertices, F triangles, counter-clockwise seen from outside. Scans lie far from their
/// coordinates' zero (1e5 mm), where a float has steps of .01 mm: positions are told from `origin`,
/// which lies near the middle.
struct TriangleMesh {
    glm::dvec3 origin{0, 0, 0};        ///< vertex i lies at origin + positions[i]
    std::vector<glm::vec3> positions;  ///< V, finite; unit: the file's until it is decided, then mm
    std::vector<Triangle> triangles;   ///< F, each index < V
    std::vector<Colour8> colours;      ///< V, or empty where the scan has none

    [[nodiscard]] std::size_t bytes() const {
        return positions.size() * sizeof(glm::vec3) + triangles.size() * sizeof(Triangle) +
               colours.size() * sizeof(Colour8);
    }
};

/// In double: scans' triangles are small against their places.
[[nodiscard]] inline double triangle_area(const TriangleMesh& mesh, const Triangle& t) {
    const glm::dvec3 a(mesh.positions[t[0]]);
    return 0.5 * glm::length(glm::cross(glm::dvec3(mesh.positions[t[1]]) - a,
                                        glm::dvec3(mesh.positions[t[2]]) - a));
}

/// Each vertex's triangles, in their order.
[[nodiscard]] inline std::vector<std::vector<std::uint32_t>> triangles_around(
    const TriangleMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> around(mesh.positions.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        for (const std::uint32_t v : mesh.triangles[f])
            around[v].push_back(static_cast<std::uint32_t>(f));
    }
    return around;
}

}  // namespace togishi
