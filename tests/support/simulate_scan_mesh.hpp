// "Scans" of generated blades, whose true dimensions and parts are known: for tests and benches.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "blade/katana_mesh.hpp"
#include "mesh/triangle_mesh.hpp"

namespace togishi {

struct ScanMeshOptions {
    double triangles = 60000;   ///< about so many on the blade
    double noise_mm = 0.02;     ///< standard deviation of each coordinate of each vertex
    double correlated = 0;      ///< share of the noise's variance that neighbours have in common
    double correlation_mm = 4;  ///< ... over about this distance
    std::uint64_t seed = 1;
    bool random_pose = true;
    double offset_mm = 0;    ///< the blade's distance from the file's zero
    double mm_per_unit = 1;  /// of the file: 1, 10, 1000, 25.4
    bool tang = true;
    bool habaki = false;   ///< a collar from 2 mm before the machi on, 26 mm long
    bool stand = false;    ///< two posts and a scale bar beside the blade, as pieces of their own
    int edge_holes = 0;    ///< pieces of the edge that the scanner did not see
    double keep_from = 0;  ///< share of nagasa (from the machi) that is kept: half a blade
    double keep_to = 1;
};

struct ScanMesh {
    TriangleMesh mesh;                    ///< in units of the file
    std::vector<Part> part;               ///< per triangle; other: fittings and stand
    glm::dmat3 rotation{1};               ///< scan = origin + rotation blade / mm_per_unit
    glm::dvec3 origin{0};                 ///< the mune-machi in the scan, in its units
    std::map<std::string, double> truth;  ///< measure_katana's, with nakago_mm
    KatanaParameters parameters;
};

/// katana, long_katana, o_kissaki, wakizashi, shobu, tanto.
inline constexpr std::array<std::string_view, 6> scan_shapes{
    "katana", "long_katana", "o_kissaki", "wakizashi", "shobu", "tanto"};
KatanaParameters scan_shape(std::string_view name);

ScanMesh simulate_scan_mesh(const KatanaParameters& parameters, const ScanMeshOptions& options);

}  // namespace togishi
