// Boxes within boxes around a mesh's triangles.
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

struct Box {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};
    void add(const glm::vec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
};

struct BoxTree {
    /// Leaves hold `order` from first on; inner nodes have their children at first and first + 1.
    struct Node {
        Box box;
        std::uint32_t first = 0;
        std::uint32_t count = 0;  ///< 0: an inner node
    };
    std::vector<std::uint32_t> order;  ///< triangles
    std::vector<Node> nodes;           ///< the first holds all
};

/// Triangles in halves along a curve that fills space; depth is log2 of their number. A mesh
/// without triangles: one empty leaf. leaf_size: triangles of a leaf at most, 1 or more.
[[nodiscard]] BoxTree box_tree(const TriangleMesh& mesh, std::uint32_t leaf_size);

}  // namespace togishi
