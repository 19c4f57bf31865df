// A scan's mesh on its chart: cut along the chart's seams and the borders of its parts, with what
// every corner needs.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "blade/blade_mesh.hpp"
#include "mesh/triangle_mesh.hpp"
#include "scanned/chart.hpp"

namespace togishi {

/// What a triangle belongs to: side of the blade, part, and in the nakago the strip across. Borders
/// between two of these are kept as lines when the mesh is made lighter.
class Region {
  public:
    Region() = default;
    /// strip: 0 mune, 1 shinogi-ji, 2 ji; told apart in the nakago only.
    Region(Part part, bool omote, int strip);
    explicit Region(std::uint8_t id) : id_(id) {}

    [[nodiscard]] std::uint8_t id() const { return id_; }
    [[nodiscard]] bool omote() const { return id_ % 2 == 0; }
    [[nodiscard]] Part part() const;
    /// Equal for two regions of one side that are one surface without a ridge between them.
    [[nodiscard]] std::uint8_t smooth_surface() const;

  private:
    std::uint8_t id_ = 0;
};

/// V vertices, F triangles, in blade coordinates, mm.
struct ChartedMesh {
    TriangleMesh mesh;           ///< origin 0
    std::vector<float> s_mm;     ///< V
    std::vector<float> t_mm;     ///< V
    std::vector<float> off_mm;   ///< V, from the blade's smooth outline
    std::vector<Region> region;  ///< F
    std::size_t cut = 0;         ///< triangles of the scan that were cut
};

/// Triangles that cross the mune ridge, the edge line (the blade's middle plane) or a border of
/// parts are cut there; where a cut would pass within a twentieth of an edge from its end, it goes
/// through that vertex instead. labels: the part of each triangle, empty: the chart's own. Labels
/// count but for 0.7 mm beside a border of the chart, where the border is drawn sharp. Throws
/// InputError for labels that are not one a triangle.
[[nodiscard]] ChartedMesh chart_mesh(TriangleMesh scan, const BladePose& pose,
                                     const ScannedChart& chart, std::span<const Part> labels = {},
                                     unsigned threads = 0);

/// Some vertices and all triangles of a charted mesh, with new vertices where the normal or the
/// chart breaks.
struct CornerMesh {
    std::vector<std::uint32_t> source;  ///< the charted mesh's vertex
    std::vector<glm::vec3> positions;   ///< mm
    std::vector<glm::vec3> normals;     ///< unit; area-weighted over the smooth surface
    std::vector<glm::vec2> uv;
    std::vector<Triangle> triangles;
};
[[nodiscard]] CornerMesh split_corners(const ChartedMesh& mesh, const BladeFrame& frame,
                                       unsigned threads = 0);

/// As the generated katana's: corner tangents along the mune line, watertight vertices.
[[nodiscard]] BladeMesh blade_mesh(const ChartedMesh& mesh, const ScannedChart& chart,
                                   unsigned threads = 0);

}  // namespace togishi
