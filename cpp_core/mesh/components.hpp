// Which vertices hang together by triangles.
#pragma once
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

struct Components {
    std::vector<std::uint32_t> of_vertex;  ///< V: 0, 1, ... in the order of their first vertices
    std::size_t count = 0;                 ///< vertices in no triangle are one each
};

inline Components find_components(const TriangleMesh& mesh) {
    Components out;
    std::vector<std::uint32_t>& parent = out.of_vertex;
    parent.resize(mesh.positions.size());
    std::iota(parent.begin(), parent.end(), 0U);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) {
            parent[v] = parent[parent[v]];
            v = parent[v];
        }
        return v;
    };
    // The lowest vertex is the root, so that the numbering below meets it first.
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        if (a != b) parent[std::max(a, b)] = std::min(a, b);
    };
    for (const Triangle& t : mesh.triangles) {
        join(t[0], t[1]);
        join(t[1], t[2]);
    }
    for (std::uint32_t v = 0; v < parent.size(); ++v) {
        parent[v] = parent[v] == v ? static_cast<std::uint32_t>(out.count++) : parent[parent[v]];
    }
    return out;
}

}  // namespace togishi
