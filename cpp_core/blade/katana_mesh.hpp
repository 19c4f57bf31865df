// The mesh of a generated katana.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "blade/blade_mesh.hpp"
#include "blade/katana_parameters.hpp"

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

/// Watertight, of triangles and quads.
struct KatanaMesh : BladeMesh {
    KatanaLandmarks landmarks;
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
