// Maps of photographs onto a blade: what each pixel was found to be becomes a texel of the blade's
// own chart.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "brdf/property_maps.hpp"
#include "capture/camera_surface.hpp"

namespace togishi {

/// From where a map's rho counts.
enum class MapFrame {
    surface,  ///< from the blade's own tangent, as capture diffuse has it
    image     ///< from the picture's x axis, seen on the surface
};

/// One evaluated photograph.
struct ProjectedMap {
    PropertyMaps maps;                 ///< in the picture's chart: row 0 is the lowest
    std::vector<std::uint8_t> usable;  ///< per pixel, row-major from the upper left; empty: all
    Camera camera;
    MapFrame frame = MapFrame::surface;
};

struct ProjectOptions {
    std::size_t width = 4096, height = 512;
    double feather_px = 0;    ///< over which a photograph fades towards its border; 0: all of it
    double grazing_deg = 75;  ///< views flatter than this are not used
    double hidden_mm = 0.5;   ///< a place this far behind what the camera sees is hidden
    unsigned threads = 0;
};

struct ProjectResult {
    PropertyMaps maps;            ///< in the blade's chart; holes hold the nearest value
    std::vector<float> coverage;  ///< per texel, row 0 at v = 0: weight of all photographs, 0: hole
    std::size_t on_blade = 0;     ///< texels that lie on the blade
    std::size_t holes = 0;        ///< of them without a photograph
};

/// Called with the share done; false cancels.
using ProjectProgress = std::function<bool(double)>;
struct ProjectCancelled {};

/// A texel is the mean over its own area of the pixels that it covers: each lobe by its second
/// moments weighted with its share, as mip levels are made (bake/map_mips.hpp), directions turned
/// from the photograph's frame into the blade's. Photographs are blended by how square they look at
/// a place, how far it is from where their border cuts the blade off and from masked pixels. Throws
/// InputError: no photograph, a map that does not fit its camera, a blade that no photograph shows.
/// ProjectCancelled.
[[nodiscard]] ProjectResult project_maps(const BladeMesh& mesh,
                                         const std::vector<ProjectedMap>& photographs,
                                         const ProjectOptions& options,
                                         const ProjectProgress& progress = {});

}  // namespace togishi
