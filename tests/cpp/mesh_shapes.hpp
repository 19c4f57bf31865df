// Closed surfaces of known size for the tests of meshes.
#pragma once
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "mesh/triangle_mesh.hpp"

namespace togishi::shapes {

/// A cube's surface of n x n squares a side, from low to low + size.
inline TriangleMesh cube(double size, const glm::dvec3& low = {0, 0, 0}, int n = 1) {
    TriangleMesh mesh;
    std::map<std::array<int, 3>, std::uint32_t> known;
    const auto vertex = [&](const glm::ivec3& at) {
        const auto [found, made] =
            known.try_emplace({at.x, at.y, at.z}, static_cast<std::uint32_t>(known.size()));
        if (made) mesh.positions.emplace_back(low + size / n * glm::dvec3(at));
        return found->second;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {0, n}) {
            for (int i = 0; i < n; ++i) {
                for (int k = 0; k < n; ++k) {
                    const auto at = [&](int a, int b) {
                        glm::ivec3 p;
                        p[axis] = side;
                        p[(axis + 1) % 3] = a;
                        p[(axis + 2) % 3] = b;
                        return vertex(p);
                    };
                    std::uint32_t q[4] = {at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)};
                    if (side == 0) std::swap(q[1], q[3]);
                    mesh.triangles.push_back({q[0], q[1], q[2]});
                    mesh.triangles.push_back({q[0], q[2], q[3]});
                }
            }
        }
    }
    return mesh;
}

inline double volume(const TriangleMesh& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles) {
        sum += glm::dot(
                   glm::dvec3(mesh.positions[t[0]]),
                   glm::cross(glm::dvec3(mesh.positions[t[1]]), glm::dvec3(mesh.positions[t[2]]))) /
               6;
    }
    return sum;
}

/// A ball: the cube's points on the sphere.
inline TriangleMesh ball(double radius, int n) {
    TriangleMesh mesh = cube(2, {-1, -1, -1}, n);
    for (glm::vec3& p : mesh.positions) p = static_cast<float>(radius) * glm::normalize(p);
    return mesh;
}

inline void append(TriangleMesh& to, const TriangleMesh& more) {
    const auto shift = static_cast<std::uint32_t>(to.positions.size());
    to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
    for (Triangle t : more.triangles) {
        for (std::uint32_t& v : t) v += shift;
        to.triangles.push_back(t);
    }
}

}  // namespace togishi::shapes
