// Collects what a reader finds and holds it to the limits.
#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/point_index.hpp"
#include "mesh/triangle_mesh.hpp"
#include "mesh_file/read_mesh.hpp"

namespace togishi {

class MeshBuilder {
  public:
    MeshBuilder(std::string where, const MeshLimits& limits)
        : where_(std::move(where)), limits_(limits) {}

    /// What the file promises, already held against its size. Throws InputError beyond the limits.
    void expect(std::uint64_t vertices, std::uint64_t faces);

    /// Throws InputError where the coordinates are not finite or too far off.
    void vertex(const glm::dvec3& at) {
        if (!usable(at)) refuse_vertex(at);
        if (points_.size() >= limits_.max_vertices) refuse_count("vertices", limits_.max_vertices);
        points_.push_back(at);
    }
    /// Of the vertex added last; vertices without are white.
    void colour(const Colour8& c) { colour_of(points_.size() - 1, c); }
    /// vertex: counted from 0, added before.
    void colour_of(std::size_t vertex, const Colour8& c) {
        colours_.resize(points_.size(), Colour8{255, 255, 255, 255});
        colours_[vertex] = c;
    }
    [[nodiscard]] std::uint64_t vertices() const { return points_.size(); }

    /// For formats without indices: vertices at one place are one.
    [[nodiscard]] std::uint32_t welded_vertex(const glm::dvec3& at);

    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (triangles_.size() >= limits_.max_triangles)
            refuse_count("triangles", limits_.max_triangles);
        triangles_.push_back({a, b, c});
    }
    /// Three corners and more; cut when all vertices are known. face: its number, from 1.
    void polygon(std::span<const std::uint32_t> corners, std::uint64_t face);
    [[nodiscard]] std::uint64_t polygons() const { return polygons_; }

    /// Throws InputError where no triangle was found or one has a vertex that is not there.
    [[nodiscard]] TriangleMesh finish();

    static constexpr std::size_t most_corners = 256;

  private:
    static bool usable(const glm::dvec3& at) {
        // A NaN fails the comparison.
        return std::abs(at.x) < 1e9 && std::abs(at.y) < 1e9 && std::abs(at.z) < 1e9;
    }
    [[noreturn]] void refuse_vertex(const glm::dvec3& at) const;
    [[noreturn]] void refuse_count(std::string_view what, std::uint64_t most) const;
    void check_indices(std::uint64_t vertices) const;
    void cut(std::span<const std::uint32_t> corners);
    void cut_by_ears(std::span<const std::uint32_t> corners);

    std::string where_;
    MeshLimits limits_;
    std::vector<glm::dvec3> points_;
    std::vector<Colour8> colours_;
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> later_;  ///< count and corners of each polygon
    std::uint64_t polygons_ = 0;
    PointIndex index_;
    std::vector<glm::vec3> welded_;
    glm::dvec3 welded_origin_{0, 0, 0};
};

}  // namespace togishi
