// Least squares over a camera's pose and scale: shared by the fits to landmarks and to outlines.
#pragma once
#include <functional>

#include <Eigen/Dense>

#include "capture/camera.hpp"

namespace togishi {

/// 6: a small rotation vector in rad, the shift of centre_px in pixels (orthographic) or 3 of
/// position_mm (pinhole: 7 in all), and the change of ln scale.
[[nodiscard]] int camera_unknowns(const Camera& camera);
[[nodiscard]] Camera camera_stepped(const Camera& camera, const Eigen::VectorXd& step);

/// Makes the sum of squared errors smallest near `camera`, by Levenberg and differences. The number
/// of errors stays the same.
void fit_camera(Camera& camera, const std::function<Eigen::VectorXd(const Camera&)>& errors);

}  // namespace togishi
