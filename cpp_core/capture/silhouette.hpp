// A camera's pose refined on the outline of the blade in a photograph.
//
// Where the outline of the generated blade falls is looked for in the picture, along its normal:
// the first step of brightness that is met on the way in from the ground. The pose then makes those
// distances smallest, again and again over shorter distances. Landmarks keep what an outline does
// not tell: an outline that leaves the picture on both sides hardly holds the place along the
// blade.
#pragma once
#include <cstddef>
#include <vector>

#include "blade/blade_mesh.hpp"
#include "capture/camera.hpp"
#include "capture/camera_pose.hpp"

namespace togishi {

struct SilhouetteOptions {
    double search_mm = 4;            ///< how far the outline may lie from where the camera puts it
    double landmark_sigma_mm = 0.5;  ///< of a mark
    double max_residual_mm = 2;      ///< rms above which the fit is refused
};

struct SilhouetteFit {
    Camera camera;
    double rms_mm = 0, p90_mm = 0;  ///< from the picture's outline to the blade's, at right angles
    double before_rms_mm = 0;       ///< the same for the camera that it began with
    std::size_t points = 0;         ///< of the outline that were found in the picture
    std::size_t outline = 0;        ///< of the outline within the picture
};

/// picture: one value a pixel, row-major from the upper left; the ground is plain and brighter or
/// darker than the blade (a photograph against the light serves best). `landmarks` may be empty:
/// the start is then trusted to search_mm and half a degree. Throws InputError: a picture of
/// another size than the camera's, an outline that lies outside the picture or is found on less
/// than half of it, residuals above max_residual_mm.
[[nodiscard]] SilhouetteFit refine_on_silhouette(const BladeMesh& mesh, const Camera& start,
                                                 const std::vector<float>& picture,
                                                 const std::vector<Landmark>& landmarks,
                                                 const SilhouetteOptions& options);

}  // namespace togishi
