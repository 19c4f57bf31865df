// The mesh of a generated katana.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "blade/frame.hpp"
#include "blade/katana_parameters.hpp"
#include "blade/part.hpp"

namespace togishi {

/// A watertight polygon mesh of triangles and quads. mm; +X to the tip, +Z to the back, +Y out of
/// omote. V vertices, F faces, C corners; faces turn counter-clockwise seen from outside.
struct KatanaMesh {
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

/// detail: 1 gives some 50,000 vertices, other values in proportion. Throws InputError as
/// check_katana, and for a detail outside 0.002 to 64.
KatanaMesh make_katana(const KatanaParameters& parameters, double detail = 1);

/// The dimensions as the mesh has them (keys as the parameters), with area_mm2, volume_mm3, faces,
/// vertices and uv_stretch_percent: the largest stretch of the chart over the blade from machi to
/// tip.
std::map<std::string, double> measure_katana(const KatanaMesh& mesh,
                                             const KatanaParameters& parameters);

}  // namespace togishi
