// What a camera sees of a surface, pixel by pixel: the geometry that a photograph is read with.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "blade/blade_mesh.hpp"
#include "capture/camera.hpp"

namespace togishi {

/// Per pixel, row-major from the upper left. Where nothing is seen, `seen` is 0 and the rest is 0.
/// Unit vectors in the camera's space; tangent at right angles to the normal: the direction that a
/// lobe's rho counts from.
struct SurfaceView {
    Camera camera;
    std::vector<std::uint8_t> seen;
    std::vector<glm::dvec3> position_mm;
    std::vector<glm::vec3> normal;
    std::vector<glm::vec3> tangent;
    std::vector<glm::vec2> uv;  ///< the chart of the surface's maps
    std::vector<Part> part;     ///< of a blade; empty: not told

    [[nodiscard]] std::size_t pixels() const { return seen.size(); }
};

/// A plate in the x-z plane that faces +y, u along x and v along z, its middle at the origin, bent
/// to the given radii along both (0: flat; above 0: its middle stands out). T is +x.
struct Plate {
    glm::dvec2 size_mm{40, 20};
    glm::dvec2 bend_radius_mm{0, 0};
};

/// Throws InputError for a plate of no size, or bent by more than a tenth of its radius.
[[nodiscard]] SurfaceView view_of_plate(const Plate& plate, const Camera& camera);

/// By a depth buffer, at the pixels' centres; faces turned away are not seen.
[[nodiscard]] SurfaceView view_of_mesh(const BladeMesh& mesh, const Camera& camera);

/// An evenly flat surface that fills the picture: for photographs of which no more is known.
[[nodiscard]] SurfaceView view_of_plane(const glm::dvec3& point_mm, const glm::dvec3& normal,
                                        const glm::dvec3& tangent, const Camera& camera);

}  // namespace togishi
