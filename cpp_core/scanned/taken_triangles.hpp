// Some triangles of a scan as a mesh of their own.
#pragma once
#include <cstdint>
#include <unordered_map>

#include "mesh/triangle_mesh.hpp"
#include "scanned/stations.hpp"

namespace togishi {

[[nodiscard]] inline glm::vec3 on_blade(const TriangleMesh& mesh, std::uint32_t v,
                                        const BladePose& pose) {
    return {pose.rotation * (mesh.origin + glm::dvec3(mesh.positions[v]) - pose.origin_mm)};
}

/// With their vertices and colours, in the coordinates of a pose. Keeps both.
class TakenTriangles {
  public:
    TakenTriangles(const TriangleMesh& from, const BladePose& pose) : from_(from), pose_(pose) {}
    void add(const Triangle& t) {
        Triangle own{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [found, fresh] =
                place_.try_emplace(t[k], static_cast<std::uint32_t>(mesh.positions.size()));
            own[k] = found->second;
            if (!fresh) continue;
            mesh.positions.push_back(on_blade(from_, t[k], pose_));
            if (!from_.colours.empty()) mesh.colours.push_back(from_.colours[t[k]]);
        }
        mesh.triangles.push_back(own);
    }
    TriangleMesh mesh;

  private:
    const TriangleMesh& from_;
    const BladePose& pose_;
    std::unordered_map<std::uint32_t, std::uint32_t> place_;
};

}  // namespace togishi
