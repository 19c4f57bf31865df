// Where a point of space falls in a photograph, and which way a pixel looks.
//
// Pixels: x to the right, y down, (0, 0) the upper left corner of the picture, so the first pixel's
// centre lies at (0.5, 0.5). Space: right-handed, mm; for a blade its own frame
// (blade/katana_mesh.hpp). right, down and forward are unit vectors at right angles to each other,
// forward = right x down. No lens distortion: photographs are undistorted before.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

namespace togishi {

struct Camera {
    bool pinhole = false;  ///< else orthographic: all pixels look along forward
    int width_px = 0, height_px = 0;
    double scale = 1;           ///< orthographic: pixels per mm; pinhole: focal length in pixels
    glm::dvec2 centre_px{0};    ///< where position_mm (orthographic) or the axis (pinhole) falls
    glm::dvec3 position_mm{0};  ///< pinhole: the eye; orthographic: the point seen at centre_px
    glm::dvec3 right{1, 0, 0};
    glm::dvec3 down{0, -1, 0};

    [[nodiscard]] glm::dvec3 forward() const { return glm::cross(right, down); }
    /// Nothing for a point behind the eye of a pinhole.
    [[nodiscard]] std::optional<glm::dvec2> project(const glm::dvec3& point_mm) const;
    /// Distance along forward, from the eye or from position_mm's plane.
    [[nodiscard]] double depth_mm(const glm::dvec3& point_mm) const;
    /// Unit, from a point of the surface to the eye.
    [[nodiscard]] glm::dvec3 view(const glm::dvec3& point_mm) const;
    struct Ray {
        glm::dvec3 origin_mm, direction;  ///< direction of unit length, away from the camera
    };
    [[nodiscard]] Ray ray(const glm::dvec2& pixel) const;
    /// The part of the picture that begins at (x, y), as a camera of its own.
    [[nodiscard]] Camera cropped(int x, int y, int width, int height) const;
};

/// Throws InputError naming the field: sizes of 1 to 100000, a scale above 0, axes that are unit
/// vectors at right angles (to 1e-6), everything finite.
void check_camera(const Camera& camera, std::string_view where);

/// Looks from `eye_mm` at `target_mm`, `up` upwards in the picture, the target in its middle.
/// Orthographic cameras have their position at the target. Throws InputError where eye, target and
/// up lie on a line.
[[nodiscard]] Camera camera_looking_at(const glm::dvec3& eye_mm, const glm::dvec3& target_mm,
                                       const glm::dvec3& up, bool pinhole, double scale,
                                       int width_px, int height_px);

}  // namespace togishi
