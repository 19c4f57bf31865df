// What a lighter mesh no longer has of its scan, as maps over the blade's chart.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "scanned/chart_mesh.hpp"

namespace togishi {

enum class TexelState : std::uint8_t {
    outside,   ///< no part of the blade; near its borders filled from there
    measured,  ///< seen by the scan
    hole       ///< on the blade, but not in the scan: flat, no displacement, the nearest colour
};

/// width x height texels over the chart, row-major, row 0 at v = 0, centres at (i + 0.5)/size.
struct DetailMaps {
    std::size_t width = 0, height = 0;
    /// The scan's normal told in the lighter mesh's tangent space: x along dP/du (towards the tip),
    /// y along dP/dv (up in the picture: "OpenGL", as Blender's Normal Map node reads it), z along
    /// the mesh's normal. Unit; the chart is mirrored against the surface: y = cross(x, z).
    std::vector<glm::vec3> normal;
    std::vector<float> displacement_mm;  ///< from the mesh to the scan along the mesh's normal
    std::vector<Colour8> colour;         ///< sRGB, mean in linear light; empty: the scan has none
    std::vector<TexelState> state;

    /// The normal as three bytes or words from 0 to `most` (255, 65535), as a picture holds it:
    /// round((n + 1)/2 most).
    [[nodiscard]] static std::uint32_t code(float component, std::uint32_t most);
};

struct DetailOptions {
    std::size_t width = 8192;
    std::size_t height = 0;   ///< 0: texels as high as they are wide, rounded up to 64 of them
    double reach_mm = 0.5;    ///< what lies farther from the blade's smooth outline is not baked
    std::size_t margin = 16;  ///< texels that the maps go on beyond the blade's borders
    unsigned threads = 0;     ///< 0: as many as the machine has
};

/// Each triangle of the scan is laid into the chart by its own places there and shared out to the
/// texels that it covers (a mean by area: right for triangles smaller and larger than a texel), so
/// no ray is cast, and the time grows with the number of triangles. Throws InputError for sizes out
/// of range (16 to 32768).
[[nodiscard]] DetailMaps bake_detail(const ChartedMesh& scan, const ChartedMesh& lighter,
                                     const BladeFrame& frame, const DetailOptions& options);

}  // namespace togishi
