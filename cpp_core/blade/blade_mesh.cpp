#include "blade/blade_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace togishi {

glm::dvec2 chart_stretch(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r,
                         const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    const double length = glm::length(q - p);
    const glm::dvec3 x = (q - p) / length;
    const double rx = glm::dot(r - p, x);
    const double ry = glm::length(r - p - rx * x);
    const glm::dvec2 jx = (b - a) / length;
    const glm::dvec2 jy = (c - a - jx * rx) / ry;
    const double sum = glm::dot(jx, jx) + glm::dot(jy, jy);
    const double determinant = jx.x * jy.y - jx.y * jy.x;
    const double root = std::sqrt(std::max(0.0, sum * sum - 4 * determinant * determinant));
    return {std::sqrt(std::max(0.0, 0.5 * (sum - root))), std::sqrt(0.5 * (sum + root))};
}

namespace {

// Each triangle of the blade from machi to tip that is no lower than this and begins no earlier:
// visit(stretch, area).
template <class Visit>
void each_stretch(const BladeMesh& mesh, double least_height_mm, double from_s_mm, Visit&& visit) {
    const glm::dvec2 chart(mesh.frame.length_mm(), mesh.frame.chart_height_mm);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        if (mesh.face_part[f] == Part::nakago || mesh.face_part[f] == Part::other) continue;
        const auto a = static_cast<std::size_t>(mesh.face_start[f]);
        const auto b = static_cast<std::size_t>(mesh.face_start[f + 1]);
        auto at = [&](std::size_t corner) -> const glm::dvec3& {
            return mesh.positions_mm[static_cast<std::size_t>(mesh.corner_vertex[corner])];
        };
        auto early = [&](std::int32_t v) {
            return double(mesh.s_mm[static_cast<std::size_t>(v)]) < from_s_mm;
        };
        if (from_s_mm > 0 &&
            std::any_of(mesh.corner_vertex.begin() + mesh.face_start[f],
                        mesh.corner_vertex.begin() + mesh.face_start[f + 1], early)) {
            continue;
        }
        for (std::size_t c = a + 1; c + 1 < b; ++c) {
            const glm::dvec3& p = at(a);
            const glm::dvec3& q = at(c);
            const glm::dvec3& r = at(c + 1);
            const double twice = glm::length(glm::cross(q - p, r - p));
            const double longest =
                std::max({glm::distance(p, q), glm::distance(q, r), glm::distance(r, p)});
            if (twice < least_height_mm * longest) continue;
            const glm::dvec2 values = chart_stretch(p, q, r, glm::dvec2(mesh.corner_uv[a]) * chart,
                                                    glm::dvec2(mesh.corner_uv[c]) * chart,
                                                    glm::dvec2(mesh.corner_uv[c + 1]) * chart);
            visit(std::max(values.y - 1, 1 - values.x), 0.5 * twice);
        }
    }
}

}  // namespace

double uv_stretch_percent(const BladeMesh& mesh, double least_height_mm) {
    double worst = 0;
    each_stretch(mesh, least_height_mm, 0,
                 [&](double stretch, double) { worst = std::max(worst, stretch); });
    return 100 * worst;
}

double uv_stretch_of_area_percent(const BladeMesh& mesh, const StretchShare& share) {
    struct Triangle {
        double stretch, area;
    };
    std::vector<Triangle> found;
    double total = 0;
    each_stretch(mesh, share.least_height_mm, share.from_s_mm, [&](double stretch, double area) {
        found.push_back({stretch, area});
        total += area;
    });
    std::sort(found.begin(), found.end(),
              [](const Triangle& a, const Triangle& b) { return a.stretch > b.stretch; });
    double above = 0;
    for (const Triangle& f : found) {
        above += f.area;
        if (above >= (1 - share.of_area) * total) return 100 * f.stretch;
    }
    return 0;
}

}  // namespace togishi
