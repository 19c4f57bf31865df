#include <algorithm>
#include <cmath>

#include "blade/katana_mesh.hpp"

namespace togishi {

std::map<std::string, double> measure_katana(const KatanaMesh& mesh,
                                             const KatanaParameters& parameters) {
    (void)parameters;
    std::map<std::string, double> m;
    double volume = 0;
    double area = 0;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto a = static_cast<std::size_t>(mesh.face_start[f]);
        const auto b = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = a + 1; c + 1 < b; ++c) {
            const glm::dvec3& p =
                mesh.positions_mm[static_cast<std::size_t>(mesh.corner_vertex[a])];
            const glm::dvec3& q =
                mesh.positions_mm[static_cast<std::size_t>(mesh.corner_vertex[c])];
            const glm::dvec3& r =
                mesh.positions_mm[static_cast<std::size_t>(mesh.corner_vertex[c + 1])];
            volume += glm::dot(p, glm::cross(q, r)) / 6;
            area += 0.5 * glm::length(glm::cross(q - p, r - p));
        }
    }
    m["volume_mm3"] = volume;
    m["area_mm2"] = area;
    m["vertices"] = static_cast<double>(mesh.positions_mm.size());
    m["faces"] = static_cast<double>(mesh.face_count());
    return m;
}

}  // namespace togishi
