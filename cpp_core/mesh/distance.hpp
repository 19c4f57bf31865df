// How far two surfaces lie apart.
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

/// The mesh's unit. Sampled: the largest distance between is not below `largest`, and as near to it
/// as the samples are dense.
struct MeshDistance {
    double largest = 0;                          ///< of both ways: the sampled Hausdorff distance
    double largest_there = 0, largest_back = 0;  ///< from a to b, from b to a
    double rms = 0;  ///< over both ways' samples, which are even over the area
    double p99 = 0;  ///< 99 % of them are nearer
    std::size_t samples = 0;
};

/// The nearest point of a surface, in a tree of boxes over its triangles.
class SurfaceTree {
  public:
    /// Keeps references into `mesh`, which must outlive it; one triangle at least.
    explicit SurfaceTree(const TriangleMesh& mesh);
    ~SurfaceTree();
    SurfaceTree(const SurfaceTree&) = delete;
    SurfaceTree& operator=(const SurfaceTree&) = delete;

    struct Nearest {
        std::uint32_t triangle = 0;
        glm::vec3 point{};    ///< told from the mesh's origin
        glm::vec3 weights{};  ///< of the triangle's corners
        float distance = 0;   ///< `within` where nothing is that near
    };
    /// What is asked of a search.
    struct Search {
        float within = std::numeric_limits<float>::max();  ///< nothing farther is looked for
        float enough = 0;                                  ///< the first that is this near will do
        std::uint32_t near = 0;  ///< a triangle that is likely near: looked at first
    };
    /// point: told from the mesh's origin.
    [[nodiscard]] Nearest nearest(const glm::vec3& point, const Search& search) const;
    [[nodiscard]] Nearest nearest(const glm::vec3& point, float within) const {
        return nearest(point, Search{.within = within});
    }

  private:
    struct Nodes;
    std::unique_ptr<Nodes> nodes_;
};

/// Points: all vertices up to `samples` per side, the rest even over the area; the same for the
/// same meshes. Throws InputError where one has no triangles.
[[nodiscard]] MeshDistance mesh_distance(const TriangleMesh& a, const TriangleMesh& b,
                                         std::size_t samples = 200'000);
/// The same where the tree of `a` is there already.
[[nodiscard]] MeshDistance mesh_distance(const TriangleMesh& a, const SurfaceTree& tree_of_a,
                                         const TriangleMesh& b, std::size_t samples = 200'000);

/// Those of so many points of `from`, taken as mesh_distance takes them, that lie farther than
/// `bound` from a surface with that origin; told from it.
[[nodiscard]] std::vector<glm::vec3> points_beyond(const TriangleMesh& from,
                                                   const glm::dvec3& origin,
                                                   const SurfaceTree& surface, float bound,
                                                   std::size_t samples);

}  // namespace togishi
