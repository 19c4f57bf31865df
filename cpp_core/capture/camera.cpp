#include "capture/camera.hpp"

#include <cmath>

#include "base/error.hpp"

namespace togishi {
namespace {

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::string text(const glm::dvec3& v) {
    return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z);
}

}  // namespace

double Camera::depth_mm(const glm::dvec3& point_mm) const {
    return glm::dot(point_mm - position_mm, forward());
}

std::optional<glm::dvec2> Camera::project(const glm::dvec3& point_mm) const {
    const glm::dvec3 d = point_mm - position_mm;
    double factor = scale;
    if (pinhole) {
        const double depth = glm::dot(d, forward());
        if (!(depth > 1e-9)) return std::nullopt;
        factor = scale / depth;
    }
    return centre_px + factor * glm::dvec2(glm::dot(d, right), glm::dot(d, down));
}

glm::dvec3 Camera::view(const glm::dvec3& point_mm) const {
    return pinhole ? glm::normalize(position_mm - point_mm) : -forward();
}

Camera::Ray Camera::ray(const glm::dvec2& pixel) const {
    const glm::dvec2 offset = (pixel - centre_px) / scale;
    if (pinhole)
        return {position_mm, glm::normalize(forward() + offset.x * right + offset.y * down)};
    return {position_mm + offset.x * right + offset.y * down, forward()};
}

Camera Camera::cropped(int x, int y, int width, int height) const {
    Camera part = *this;
    part.width_px = width;
    part.height_px = height;
    part.centre_px -= glm::dvec2(x, y);
    return part;
}

void check_camera(const Camera& camera, std::string_view where) {
    const auto size = [&](std::string_view field, int value) {
        if (value < 1 || value > 100000)
            throw InputError(where, field, std::to_string(value), "1 to 100000 pixels");
    };
    size("camera.width_px", camera.width_px);
    size("camera.height_px", camera.height_px);
    if (!(camera.scale > 0 && camera.scale < 1e9)) {
        throw InputError(where, camera.pinhole ? "camera.focal_px" : "camera.scale_px_per_mm",
                         std::to_string(camera.scale), "above 0");
    }
    if (!std::isfinite(camera.centre_px.x) || !std::isfinite(camera.centre_px.y))
        throw InputError(where, "camera.centre_px", "not finite", "a place in pixels");
    if (!finite(camera.position_mm))
        throw InputError(where, "camera.position_mm", text(camera.position_mm), "finite numbers");
    const auto unit = [&](std::string_view field, const glm::dvec3& axis) {
        if (!(std::abs(glm::length(axis) - 1) < 1e-6))
            throw InputError(where, field, text(axis), "a vector of length 1");
    };
    unit("camera.right", camera.right);
    unit("camera.down", camera.down);
    if (!(std::abs(glm::dot(camera.right, camera.down)) < 1e-6))
        throw InputError(where, "camera.down", text(camera.down), "at right angles to right");
}

Camera camera_looking_at(const glm::dvec3& eye_mm, const glm::dvec3& target_mm,
                         const glm::dvec3& up, bool pinhole, double scale, int width_px,
                         int height_px) {
    const glm::dvec3 d = target_mm - eye_mm;
    const glm::dvec3 side = glm::cross(d, up);
    if (!(glm::length(side) > 1e-9 * glm::length(d) * glm::length(up)) || !finite(side))
        throw InputError("camera", "up", text(up), "a direction that is not that of the view");
    Camera camera;
    camera.pinhole = pinhole;
    camera.width_px = width_px;
    camera.height_px = height_px;
    camera.scale = scale;
    camera.centre_px = glm::dvec2(width_px, height_px) * 0.5;
    camera.position_mm = pinhole ? eye_mm : target_mm;
    camera.right = glm::normalize(side);
    camera.down = glm::cross(glm::normalize(d), camera.right);
    check_camera(camera, "camera");
    return camera;
}

}  // namespace togishi
