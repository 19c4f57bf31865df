// Where a blade roughly lies in a scan: which pieces of the mesh are it, its long axis, its back
// and its tip.
#pragma once
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "scanned/pose_correction.hpp"
#include "scanned/surface_samples.hpp"

namespace togishi {

/// One bin of the blade's length.
struct LengthBin {
    double x = 0;                                   ///< its middle
    double back_z = 0, edge_z = 0;                  ///< outermost points
    double thickness = 0;                           ///< widest distance across
    double back_thickness = 0, edge_thickness = 0;  ///< in the outer eighth of the width
    std::size_t samples = 0;
    bool fitting = false;  ///< habaki or another fitting around the blade
    [[nodiscard]] double width() const { return back_z - edge_z; }
};

/// Bins along x of points of a blade whose back is above (z) and whose thickness lies along y.
[[nodiscard]] std::vector<LengthBin> find_length_bins(const std::vector<glm::dvec3>& points);

struct CoarsePose {
    glm::dmat3 rotation{1};  ///< rough blade coordinates = rotation (scan - origin): x to the tip,
                             ///< z to the back, y out of omote
    glm::dvec3 origin{0};
    std::vector<char> body;       ///< per piece of the mesh: belongs to the blade
    std::vector<LengthBin> bins;  ///< of 1 mm, from the tang's end to the tip
    double length_mm = 0;
    double machi_x = 0;         ///< where tang and blade meet; first bin's x where there is no tang
    bool tang = false;          ///< a machi was found
    bool point = false;         ///< the blade runs out to a point
    double edge_over_back = 1;  ///< thickness near the edge over that near the back: 1 no edge
    double end_certainty = 0;   ///< 0: tip and tang may as well be the other way round
};

/// Throws InputError where the machi that is given lies beyond the blade.
[[nodiscard]] CoarsePose find_coarse_pose(const TriangleMesh& mesh_mm, const MeshPieces& pieces,
                                          const PoseCorrection& correction = {});

}  // namespace togishi
