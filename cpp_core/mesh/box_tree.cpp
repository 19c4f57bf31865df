#include "mesh/box_tree.hpp"

#include <algorithm>

namespace togishi {
namespace {

/// 21 bits, two places apart.
std::uint64_t spread(float value) {
    auto x = static_cast<std::uint64_t>(std::clamp(value, 0.0F, 2'097'151.0F));
    x = (x | x << 32U) & 0x001f00000000ffffULL;
    x = (x | x << 16U) & 0x001f0000ff0000ffULL;
    x = (x | x << 8U) & 0x100f00f00f00f00fULL;
    x = (x | x << 4U) & 0x10c30c30c30c30c3ULL;
    return (x | x << 2U) & 0x1249249249249249ULL;
}

/// The triangles along a curve that fills space (Morton), so that halves of the row are halves of
/// the place.
std::vector<std::uint32_t> along_curve(const TriangleMesh& mesh) {
    const auto middle = [&](const Triangle& c) {
        return (mesh.positions[c[0]] + mesh.positions[c[1]] + mesh.positions[c[2]]) / 3.0F;
    };
    Box box;
    for (const Triangle& c : mesh.triangles) box.add(middle(c));
    const glm::vec3 size = box.high - box.low;
    const float scale = 2'097'151.0F / std::max({size.x, size.y, size.z, 1e-30F});
    struct Place {
        std::uint64_t code;
        std::uint32_t triangle;
    };
    std::vector<Place> places(mesh.triangles.size());
    for (std::uint32_t t = 0; t < places.size(); ++t) {
        const glm::vec3 at = (middle(mesh.triangles[t]) - box.low) * scale;
        places[t] = {spread(at.x) | spread(at.y) << 1U | spread(at.z) << 2U, t};
    }
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return a.code != b.code ? a.code < b.code : a.triangle < b.triangle;
    });
    std::vector<std::uint32_t> order(places.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = places[i].triangle;
    return order;
}

/// Halves by count.
void split(BoxTree& tree, std::uint32_t leaf_size, std::uint32_t node, std::uint32_t begin,
           std::uint32_t end) {
    if (end - begin <= leaf_size) {
        tree.nodes[node].first = begin;
        tree.nodes[node].count = end - begin;
        return;
    }
    const std::uint32_t half = begin + (end - begin) / 2;
    const auto children = static_cast<std::uint32_t>(tree.nodes.size());
    tree.nodes[node].first = children;
    tree.nodes.emplace_back();
    tree.nodes.emplace_back();
    split(tree, leaf_size, children, begin, half);
    split(tree, leaf_size, children + 1, half, end);
}

/// Children come behind their node, so backwards each box is there before it is asked for.
void fit(BoxTree& tree, const TriangleMesh& mesh) {
    for (std::size_t i = tree.nodes.size(); i-- > 0;) {
        BoxTree::Node& node = tree.nodes[i];
        if (node.count > 0) {
            for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
                for (const std::uint32_t v : mesh.triangles[tree.order[k]]) {
                    node.box.add(mesh.positions[v]);
                }
            }
        } else if (node.first > i) {
            for (std::uint32_t k = 0; k < 2; ++k) {
                node.box.add(tree.nodes[node.first + k].box.low);
                node.box.add(tree.nodes[node.first + k].box.high);
            }
        }
    }
}

}  // namespace

BoxTree box_tree(const TriangleMesh& mesh, std::uint32_t leaf_size) {
    BoxTree tree;
    tree.order = along_curve(mesh);
    tree.nodes.reserve(tree.order.size() / 2 + 1);
    tree.nodes.emplace_back();
    split(tree, leaf_size, 0, 0, static_cast<std::uint32_t>(tree.order.size()));
    fit(tree, mesh);
    return tree;
}

}  // namespace togishi
