#include <algorithm>
#include <cmath>

#include "blade/katana_mesh.hpp"

namespace togishi {
namespace {

// Singular values of the map from the surface of triangle (p, q, r) to its place (a, b, c) in the
// chart.
glm::dvec2 stretch(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r,
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

// A single-precision UV places a corner to 3e-5 mm; below this height of a triangle that is no
// measure of the chart.
constexpr double least_height_mm = 0.02;

}  // namespace

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
    double worst = 0;
    const glm::dvec2 chart(mesh.frame.length_mm(), mesh.frame.chart_height_mm);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto a = static_cast<std::size_t>(mesh.face_start[f]);
        const auto b = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = a + 1; c + 1 < b; ++c) {
            const glm::dvec3& p = at(mesh.corner_vertex[a]);
            const glm::dvec3& q = at(mesh.corner_vertex[c]);
            const glm::dvec3& r = at(mesh.corner_vertex[c + 1]);
            const double twice = glm::length(glm::cross(q - p, r - p));
            volume += glm::dot(p, glm::cross(q, r)) / 6;
            area += 0.5 * twice;
            const double longest =
                std::max({glm::distance(p, q), glm::distance(q, r), glm::distance(r, p)});
            if (mesh.face_part[f] == Part::nakago || twice < least_height_mm * longest) continue;
            const glm::dvec2 values = stretch(p, q, r, glm::dvec2(mesh.corner_uv[a]) * chart,
                                              glm::dvec2(mesh.corner_uv[c]) * chart,
                                              glm::dvec2(mesh.corner_uv[c + 1]) * chart);
            worst = std::max({worst, values.y - 1, 1 - values.x});
        }
    }
    m["volume_mm3"] = volume;
    m["area_mm2"] = area;
    m["uv_stretch_percent"] = 100 * worst;
    m["vertices"] = static_cast<double>(mesh.positions_mm.size());
    m["faces"] = static_cast<double>(mesh.face_count());
    return m;
}

}  // namespace togishi
