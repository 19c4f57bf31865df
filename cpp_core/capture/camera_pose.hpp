// The camera of a photograph from points that are known on the blade and marked in the picture.
#pragma once
#include <array>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "blade/katana_mesh.hpp"
#include "capture/camera.hpp"

namespace togishi {

/// A place on the blade and where it lies in the picture.
struct Landmark {
    std::string name;
    glm::dvec3 point_mm{0};
    glm::dvec2 pixel{0};
};

struct CameraFit {
    Camera camera;
    std::vector<double> residual_px;  ///< one a landmark
    std::vector<double> residual_mm;  ///< the same on the blade, at the landmark's distance
    double rms_mm = 0;
};

/// Orthographic camera by 4 landmarks or more that do not lie on a line; those that lie in a plane
/// (as points of one side nearly do) do, where the camera looks at that side within 60 degrees of
/// `facing`, a direction from the blade to the camera: it decides between a plane's two solutions.
/// Throws InputError: too few, on a line, not finite, the same place twice, and a residual above
/// `max_residual_mm`, naming the worst landmark.
[[nodiscard]] CameraFit fit_orthographic_camera(const std::vector<Landmark>& landmarks,
                                                int width_px, int height_px,
                                                const glm::dvec3& facing,
                                                double max_residual_mm = 2);

/// Pinhole camera, its focal length and pose, the principal point in the picture's middle: by a
/// direct linear transformation, then least squares of the pixels. 6 landmarks or more, not in one
/// plane. Throws as above.
[[nodiscard]] CameraFit fit_pinhole_camera(const std::vector<Landmark>& landmarks, int width_px,
                                           int height_px, double max_residual_mm = 2);

/// Landmarks that every generated blade has, by name: tip, ha_machi, mune_machi, yokote_ridge,
/// yokote_edge, and (omote_, ura_) machi_shinogi, yokote_shinogi, machi_corner, yokote_corner.
/// Throws InputError for another name.
[[nodiscard]] glm::dvec3 blade_landmark(const KatanaMesh& mesh, const std::string& name);
[[nodiscard]] std::vector<std::string> blade_landmark_names();

}  // namespace togishi
