#include "mesh/ray_tree.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "mesh/box_tree.hpp"

namespace togishi {
namespace {

constexpr std::uint32_t leaf_size = 4;
constexpr std::size_t most_triangles = std::size_t{1} << 21U;

/// A node and all below it, in the order in which they are visited.
void append(std::vector<glm::vec4>& texels, const BoxTree& tree, std::uint32_t number, float pad) {
    const BoxTree::Node& node = tree.nodes[number];
    const std::size_t at = texels.size();
    const float leaf =
        node.count > 0 ? static_cast<float>(1 + 8 * node.first + (node.count - 1)) : 0.0F;
    texels.emplace_back(node.box.low - pad, 0.0F);
    texels.emplace_back(node.box.high + pad, leaf);
    if (node.count == 0) {
        append(texels, tree, node.first, pad);
        append(texels, tree, node.first + 1, pad);
    }
    const std::size_t next = texels.size() / 2;
    texels[at].w = static_cast<float>(next);
}

void check(const TriangleMesh& mesh, std::size_t normals, std::size_t groups) {
    if (mesh.triangles.size() > most_triangles) {
        throw InputError("mesh", "triangles", std::to_string(mesh.triangles.size()),
                         std::to_string(most_triangles) + " at most");
    }
    if (normals != mesh.positions.size()) {
        throw InputError("mesh", "normals", std::to_string(normals),
                         std::to_string(mesh.positions.size()) + ", as vertices");
    }
    if (groups != mesh.triangles.size()) {
        throw InputError("mesh", "groups", std::to_string(groups),
                         std::to_string(mesh.triangles.size()) + ", as triangles");
    }
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            if (v >= mesh.positions.size()) {
                throw InputError("mesh", "triangles", std::to_string(v),
                                 "0 to " + std::to_string(mesh.positions.size()) + " - 1");
            }
        }
    }
}

}  // namespace

float pack_unit(const glm::vec3& direction) {
    const float sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
    const glm::vec3 n = sum > 0 && std::isfinite(sum) ? direction / sum : glm::vec3(0, 0, 1);
    glm::vec2 p(n.x, n.y);
    if (n.z < 0) {
        p = {(1 - std::abs(n.y)) * (n.x >= 0 ? 1.0F : -1.0F),
             (1 - std::abs(n.x)) * (n.y >= 0 ? 1.0F : -1.0F)};
    }
    const auto steps = [](float x) { return std::round((x * 0.5F + 0.5F) * 4095.0F); };
    return steps(p.x) + 4096.0F * steps(p.y);
}

RayTree ray_tree(const TriangleMesh& mesh, std::span<const glm::vec3> normals,
                 std::span<const std::uint16_t> groups) {
    check(mesh, normals.size(), groups.size());
    RayTree out;
    if (mesh.triangles.empty()) return out;
    const BoxTree tree = box_tree(mesh, leaf_size);
    const Box& all = tree.nodes[0].box;
    const glm::vec3 far = glm::max(glm::abs(all.low), glm::abs(all.high));
    // A flat surface's box needs a thickness above the rounding of what is measured against it.
    const float pad = 4e-7F * (far.x + far.y + far.z) + 1e-30F;
    out.nodes.reserve(2 * tree.nodes.size());
    append(out.nodes, tree, 0, pad);
    out.triangles.reserve(4 * tree.order.size());
    for (const std::uint32_t t : tree.order) {
        const Triangle& c = mesh.triangles[t];
        const glm::vec3& a = mesh.positions[c[0]];
        out.triangles.emplace_back(a, static_cast<float>(groups[t]));
        out.triangles.emplace_back(mesh.positions[c[1]] - a, 0.0F);
        out.triangles.emplace_back(mesh.positions[c[2]] - a, 0.0F);
        out.triangles.emplace_back(pack_unit(normals[c[0]]), pack_unit(normals[c[1]]),
                                   pack_unit(normals[c[2]]), 0.0F);
    }
    return out;
}

}  // namespace togishi
