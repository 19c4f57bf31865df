// The mesh of a blade, generated or scanned, with its chart.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "blade/frame.hpp"
#include "blade/part.hpp"

namespace togishi {

/// A polygon mesh. mm; mune-machi in the origin, +X to the tip, +Z to the back, +Y out of omote. V
/// vertices, F faces, C corners; faces turn counter-clockwise seen from outside.
struct BladeMesh {
    std::vector<glm::dvec3> positions_mm;     ///< V
    std::vector<float> s_mm;                  ///< V, developed length from the machi
    std::vector<float> t_mm;                  ///< V, developed distance from the mune ridge
    std::vector<std::int32_t> corner_vertex;  ///< C
    std::vector<std::int32_t> face_start;     ///< F + 1, first corner of each face
    std::vector<Part> face_part;              ///< F
    std::vector<glm::vec3> corner_normal;  ///< C, unit, of the smooth surface, broken at its ridges
    std::vector<glm::vec3>
        corner_tangent;                ///< C, unit, at right angles to the normal, towards the tip
    std::vector<glm::vec2> corner_uv;  ///< C, the chart of frame.hpp
    BladeFrame frame;

    [[nodiscard]] std::size_t face_count() const { return face_part.size(); }
};

/// Least and largest share of its true length that a length in triangle (p, q, r) has in the chart,
/// where its corners lie at a, b, c: the singular values of the map. p and q not at one place.
[[nodiscard]] glm::dvec2 chart_stretch(const glm::dvec3& p, const glm::dvec3& q,
                                       const glm::dvec3& r, const glm::dvec2& a,
                                       const glm::dvec2& b, const glm::dvec2& c);

/// A single-precision UV places a corner to 3e-5 mm: lower triangles are no measure of the chart.
inline constexpr double least_chart_height_mm = 0.02;

/// The largest stretch of the chart over the blade from machi to tip, in the triangles that are not
/// lower than this: by how many percent a length in it differs from the surface's. The nakago (its
/// walls lie across the chart) and what is no part of the blade are left out.
[[nodiscard]] double uv_stretch_percent(const BladeMesh& mesh,
                                        double least_height_mm = least_chart_height_mm);

/// Where the stretch of a scan's chart is measured: its own triangles lie as they were seen, across
/// a ridge or on a grain of noise, and it rounds off the walls of the machi.
struct StretchShare {
    double of_area = 0.99;
    double least_height_mm = 0.5;
    double from_s_mm = 2;  ///< triangles that begin before it are left out
};

/// What the stretch does not pass over that share of the area; no maximum.
[[nodiscard]] double uv_stretch_of_area_percent(const BladeMesh& mesh,
                                                const StretchShare& share = {});

}  // namespace togishi
