#include "capture/camera_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace togishi {
namespace {

SurfaceView empty_view(const Camera& camera) {
    check_camera(camera, "camera");
    SurfaceView view;
    view.camera = camera;
    const std::size_t n =
        static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
    view.seen.assign(n, 0);
    view.position_mm.assign(n, glm::dvec3(0));
    view.normal.assign(n, glm::vec3(0));
    view.tangent.assign(n, glm::vec3(0));
    view.uv.assign(n, glm::vec2(0));
    return view;
}

glm::dvec2 pixel_centre(const Camera& camera, std::size_t i) {
    const auto w = static_cast<std::size_t>(camera.width_px);
    const std::size_t row = i / w;
    return {static_cast<double>(i - row * w) + 0.5, static_cast<double>(row) + 0.5};
}

struct Triangle {
    std::size_t corner[3];
    Part part;
};

}  // namespace

SurfaceView view_of_plate(const Plate& plate, const Camera& camera) {
    if (!(plate.size_mm.x > 0 && plate.size_mm.y > 0 && plate.size_mm.x < 1e6 &&
          plate.size_mm.y < 1e6)) {
        throw InputError("surface", "size_mm",
                         std::to_string(plate.size_mm.x) + ", " + std::to_string(plate.size_mm.y),
                         "two lengths above 0");
    }
    glm::dvec2 curvature(0);
    for (int k = 0; k < 2; ++k) {
        const double radius = plate.bend_radius_mm[k];
        if (radius == 0) continue;
        if (!(std::abs(radius) >= 5 * plate.size_mm[k])) {
            throw InputError("surface", "bend_radius_mm", std::to_string(radius),
                             "0 (flat), or 5 times the plate's size and more");
        }
        curvature[k] = 1 / radius;
    }
    SurfaceView view = empty_view(camera);
    const auto height = [&](double x, double z) {
        return -0.5 * (curvature.x * x * x + curvature.y * z * z);
    };
    for (std::size_t i = 0; i < view.pixels(); ++i) {
        const Camera::Ray ray = camera.ray(pixel_centre(camera, i));
        if (!(ray.direction.y < -1e-6)) continue;
        double y = 0;
        glm::dvec3 p(0);
        // The plate is nearly flat: each step leaves a hundredth of the error.
        for (int step = 0; step < 12; ++step) {
            p = ray.origin_mm + ((y - ray.origin_mm.y) / ray.direction.y) * ray.direction;
            y = height(p.x, p.z);
        }
        if (std::abs(p.x) > plate.size_mm.x / 2 || std::abs(p.z) > plate.size_mm.y / 2) continue;
        const glm::dvec3 n = glm::normalize(glm::dvec3(curvature.x * p.x, 1, curvature.y * p.z));
        view.seen[i] = 1;
        view.position_mm[i] = p;
        view.normal[i] = glm::vec3(n);
        view.tangent[i] = glm::vec3(glm::normalize(glm::dvec3(1, 0, 0) - n * n.x));
        view.uv[i] = glm::vec2(p.x / plate.size_mm.x + 0.5, p.z / plate.size_mm.y + 0.5);
    }
    return view;
}

SurfaceView view_of_plane(const glm::dvec3& point_mm, const glm::dvec3& normal,
                          const glm::dvec3& tangent, const Camera& camera) {
    SurfaceView view = empty_view(camera);
    const double length = glm::length(normal);
    const glm::dvec3 n = normal / length;
    const glm::dvec3 t = tangent - n * glm::dot(n, tangent);
    if (!(length > 1e-9 && glm::length(t) > 1e-6 * glm::length(tangent)))
        throw InputError("surface", "normal, tangent", "zero or parallel",
                         "two directions at an angle");
    const glm::dvec3 unit_t = glm::normalize(t);
    for (std::size_t i = 0; i < view.pixels(); ++i) {
        const Camera::Ray ray = camera.ray(pixel_centre(camera, i));
        const double along = glm::dot(ray.direction, n);
        if (!(along < -1e-6)) continue;
        view.seen[i] = 1;
        view.position_mm[i] =
            ray.origin_mm + (glm::dot(point_mm - ray.origin_mm, n) / along) * ray.direction;
        view.normal[i] = glm::vec3(n);
        view.tangent[i] = glm::vec3(unit_t);
        const glm::dvec2 at = pixel_centre(camera, i);
        view.uv[i] = glm::vec2(at.x / camera.width_px, 1 - at.y / camera.height_px);
    }
    return view;
}

SurfaceView view_of_mesh(const BladeMesh& mesh, const Camera& camera) {
    SurfaceView view = empty_view(camera);
    view.part.assign(view.pixels(), Part::other);
    std::vector<std::optional<glm::dvec2>> projected(mesh.positions_mm.size());
    for (std::size_t v = 0; v < projected.size(); ++v)
        projected[v] = camera.project(mesh.positions_mm[v]);
    std::vector<Triangle> triangles;
    triangles.reserve(2 * mesh.face_count());
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto first = static_cast<std::size_t>(mesh.face_start[f]);
        const auto end = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = first + 1; c + 1 < end; ++c)
            triangles.push_back({{first, c, c + 1}, mesh.face_part[f]});
    }
    std::vector<double> depth(view.pixels(), std::numeric_limits<double>::infinity());
    const auto vertex = [&](std::size_t corner) {
        return static_cast<std::size_t>(mesh.corner_vertex[corner]);
    };
    for (const Triangle& triangle : triangles) {
        glm::dvec3 p[3];
        glm::dvec2 low(1e30), high(-1e30);
        bool ahead = true;
        for (int k = 0; k < 3; ++k) {
            const std::size_t v = vertex(triangle.corner[k]);
            p[k] = mesh.positions_mm[v];
            if (!projected[v]) {
                ahead = false;
                break;
            }
            low = glm::min(low, *projected[v]);
            high = glm::max(high, *projected[v]);
        }
        if (!ahead) continue;
        const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0], area = glm::cross(e1, e2);
        if (!(glm::dot(area, camera.view(p[0])) > 0)) continue;
        const auto bound = [](double v, int most) {
            return static_cast<int>(std::clamp(v, -1.0, static_cast<double>(most)));
        };
        const int x0 = std::max(bound(std::floor(low.x - 0.5), camera.width_px), 0),
                  x1 = std::min(bound(std::ceil(high.x), camera.width_px), camera.width_px - 1),
                  y0 = std::max(bound(std::floor(low.y - 0.5), camera.height_px), 0),
                  y1 = std::min(bound(std::ceil(high.y), camera.height_px), camera.height_px - 1);
        const double area2 = glm::dot(area, area);
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                const Camera::Ray ray = camera.ray({x + 0.5, y + 0.5});
                const double along = glm::dot(ray.direction, area);
                const double t = glm::dot(p[0] - ray.origin_mm, area) / along;
                const glm::dvec3 hit = ray.origin_mm + t * ray.direction;
                const glm::dvec3 d = hit - p[0];
                const double b1 = glm::dot(glm::cross(d, e2), area) / area2,
                             b2 = glm::dot(glm::cross(e1, d), area) / area2, b0 = 1 - b1 - b2;
                constexpr double slack = -1e-9;
                if (!(b0 >= slack && b1 >= slack && b2 >= slack)) continue;
                const auto i =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width_px) +
                    static_cast<std::size_t>(x);
                const double at = camera.depth_mm(hit);
                if (!(at < depth[i])) continue;
                const auto blend = [&](const auto& values) {
                    return values[triangle.corner[0]] * static_cast<float>(b0) +
                           values[triangle.corner[1]] * static_cast<float>(b1) +
                           values[triangle.corner[2]] * static_cast<float>(b2);
                };
                const glm::vec3 n = glm::normalize(blend(mesh.corner_normal));
                if (!(glm::dot(glm::dvec3(n), camera.view(hit)) > 0)) continue;
                const glm::vec3 along_t = blend(mesh.corner_tangent);
                depth[i] = at;
                view.seen[i] = 1;
                view.part[i] = triangle.part;
                view.position_mm[i] = hit;
                view.normal[i] = n;
                view.tangent[i] = glm::normalize(along_t - n * glm::dot(n, along_t));
                view.uv[i] = blend(mesh.corner_uv);
            }
        }
    }
    return view;
}

}  // namespace togishi
