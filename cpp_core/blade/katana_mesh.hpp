// The mesh of a generated katana.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "blade/frame.hpp"
#include "blade/katana_parameters.hpp"
#include "blade/part.hpp"

namespace togishi {

/// Vertices that the dimensions are measured between. Pairs: omote, ura.
struct KatanaLandmarks {
    std::int32_t tip = 0;
    std::int32_t nakago_end = 0;  ///< on the end's middle line, or omote's corner of it
    std::int32_t machi_ridge = 0, machi_edge = 0;  ///< mune-machi and ha-machi
    std::int32_t yokote_ridge = 0,
                 yokote_edge = 0;  ///< where the kissaki (without yokote: the fukura) starts
    std::array<std::int32_t, 2> machi_corner{}, yokote_corner{};
    std::array<std::int32_t, 2> machi_shinogi{},
        yokote_shinogi{};  ///< the corner where there is no shinogi
};

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
    KatanaLandmarks landmarks;

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
