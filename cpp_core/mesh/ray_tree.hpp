// A surface as the GPU's rays search it: the texels that shaders/shared/trace/ray_tree.glsl reads.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

/// What lies in a texel: the head of the shader's text.
struct RayTree {
    std::vector<glm::vec4> nodes;      ///< two for each node
    std::vector<glm::vec4> triangles;  ///< four for each triangle
};

/// normals: one for each vertex of the mesh, of any length above 0. groups: one for each triangle,
/// 0 to 4095. Throws InputError for more than 2^21 triangles, whose numbers a float does not hold,
/// for other counts, and for a vertex that is not there.
[[nodiscard]] RayTree ray_tree(const TriangleMesh& mesh, std::span<const glm::vec3> normals,
                               std::span<const std::uint16_t> groups);

/// A vector's direction in 24 bits, exact in a float; unpack_unit of the shared text reads it.
[[nodiscard]] float pack_unit(const glm::vec3& direction);

}  // namespace togishi
