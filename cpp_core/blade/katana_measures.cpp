#include <algorithm>
#include <cmath>

#include "blade/katana_mesh.hpp"

namespace togishi {

std::map<std::string, double> measure_katana(const KatanaMesh& mesh,
                                             const KatanaParameters& parameters) {
    auto at = [&](std::int32_t v) -> const glm::dvec3& {
        return mesh.positions_mm[static_cast<std::size_t>(v)];
    };
    const KatanaLandmarks& k = mesh.landmarks;
    auto middle = [&](const std::array<std::int32_t, 2>& pair) {
        return 0.5 * (at(pair[0]) + at(pair[1]));
    };
    std::map<std::string, double> m;

    const glm::dvec3 machi = at(k.machi_ridge);
    const glm::dvec3 chord = at(k.tip) - machi;
    m["nagasa_mm"] = glm::length(chord);
    // The mune's ridge against the chord; both lie in the plane y = 0.
    const glm::dvec3 across = glm::normalize(glm::dvec3(-chord.z, 0, chord.x));
    double sori = 0;
    double deepest = 0;
    for (std::size_t v = 0; v < mesh.positions_mm.size(); ++v) {
        if (mesh.t_mm[v] > 0 || mesh.s_mm[v] < 0) continue;
        const glm::dvec3 from = mesh.positions_mm[v] - machi;
        const double depth = -glm::dot(from, across);
        if (depth > sori) {
            sori = depth;
            deepest = glm::dot(from, chord) / glm::length(chord);
        }
    }
    m["sori_mm"] = sori;
    m["sori_at_mm"] = deepest;
    m["motohaba_mm"] = glm::distance(machi, at(k.machi_edge));
    m["sakihaba_mm"] = glm::distance(at(k.yokote_ridge), at(k.yokote_edge));
    m["motokasane_mm"] = glm::distance(at(k.machi_corner[0]), at(k.machi_corner[1]));
    m["sakikasane_mm"] = glm::distance(at(k.yokote_corner[0]), at(k.yokote_corner[1]));
    m["kissaki_mm"] = glm::distance(at(k.yokote_ridge), at(k.tip));
    m["mune_height_mm"] = glm::distance(machi, middle(k.machi_corner));
    if (parameters.zukuri != Zukuri::hira) {
        m["moto_shinogi_haba_mm"] = glm::distance(machi, middle(k.machi_shinogi));
        m["saki_shinogi_haba_mm"] = glm::distance(at(k.yokote_ridge), middle(k.yokote_shinogi));
        m["moto_shinogi_kasane_mm"] = glm::distance(at(k.machi_shinogi[0]), at(k.machi_shinogi[1]));
        m["saki_shinogi_kasane_mm"] =
            glm::distance(at(k.yokote_shinogi[0]), at(k.yokote_shinogi[1]));
    }

    double volume = 0;
    double area = 0;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto a = static_cast<std::size_t>(mesh.face_start[f]);
        const auto b = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = a + 1; c + 1 < b; ++c) {
            const glm::dvec3& p = at(mesh.corner_vertex[a]);
            const glm::dvec3& q = at(mesh.corner_vertex[c]);
            const glm::dvec3& r = at(mesh.corner_vertex[c + 1]);
            volume += glm::dot(p, glm::cross(q, r)) / 6;
            area += 0.5 * glm::length(glm::cross(q - p, r - p));
        }
    }
    m["volume_mm3"] = volume;
    m["area_mm2"] = area;
    m["uv_stretch_percent"] = uv_stretch_percent(mesh);
    m["vertices"] = static_cast<double>(mesh.positions_mm.size());
    m["faces"] = static_cast<double>(mesh.face_count());
    return m;
}

}  // namespace togishi
