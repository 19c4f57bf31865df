#include "capture/camera_step.hpp"

#include <algorithm>
#include <cmath>

namespace togishi {
namespace {

// A rotation by a small vector, applied to the camera's axes.
void turn(Camera& camera, const glm::dvec3& by) {
    const double angle = glm::length(by);
    if (angle < 1e-15) return;
    const glm::dvec3 axis = by / angle;
    const auto rotated = [&](const glm::dvec3& v) {
        return std::cos(angle) * v + std::sin(angle) * glm::cross(axis, v) +
               (1 - std::cos(angle)) * glm::dot(axis, v) * axis;
    };
    camera.right = glm::normalize(rotated(camera.right));
    const glm::dvec3 down = rotated(camera.down);
    camera.down = glm::normalize(down - camera.right * glm::dot(down, camera.right));
}

}  // namespace

int camera_unknowns(const Camera& camera) {
    return camera.pinhole ? 7 : 6;
}

Camera camera_stepped(const Camera& camera, const Eigen::VectorXd& step) {
    Camera next = camera;
    turn(next, {step[0], step[1], step[2]});
    if (camera.pinhole) {
        next.position_mm += glm::dvec3(step[3], step[4], step[5]);
        next.scale *= std::exp(step[6]);
    } else {
        next.centre_px += glm::dvec2(step[3], step[4]);
        next.scale *= std::exp(step[5]);
    }
    return next;
}

void fit_camera(Camera& camera, const std::function<Eigen::VectorXd(const Camera&)>& errors) {
    const int unknowns = camera_unknowns(camera);
    double lambda = 1e-3;
    Eigen::VectorXd r = errors(camera);
    for (int pass = 0; pass < 200; ++pass) {
        Eigen::MatrixXd j(r.size(), unknowns);
        for (int k = 0; k < unknowns; ++k) {
            Eigen::VectorXd step = Eigen::VectorXd::Zero(unknowns);
            const bool length = camera.pinhole && k >= 3 && k < 6;
            const double h = length ? 1e-2 : !camera.pinhole && k >= 3 && k < 5 ? 1e-2 : 1e-6;
            step[k] = h;
            const Eigen::VectorXd forward = errors(camera_stepped(camera, step));
            step[k] = -h;
            j.col(k) = (forward - errors(camera_stepped(camera, step))) / (2 * h);
        }
        Eigen::MatrixXd normal = j.transpose() * j;
        const Eigen::VectorXd gradient = j.transpose() * r;
        normal.diagonal() *= 1 + lambda;
        normal.diagonal().array() += 1e-12;
        const Camera next = camera_stepped(camera, -normal.ldlt().solve(gradient));
        const Eigen::VectorXd found = errors(next);
        if (found.squaredNorm() < r.squaredNorm()) {
            const double gain = r.squaredNorm() - found.squaredNorm();
            camera = next;
            r = found;
            lambda = std::max(lambda * 0.2, 1e-12);
            if (gain < 1e-14 * (1 + r.squaredNorm())) break;
        } else {
            lambda *= 10;
            if (lambda > 1e12) break;
        }
    }
}

}  // namespace togishi
