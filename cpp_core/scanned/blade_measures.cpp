#include "scanned/blade_measures.hpp"

#include <cmath>

namespace togishi {

std::vector<FitMeasure> measure_fit(const BladeFit& fit) {
    std::vector<FitMeasure> m;
    const glm::dvec3 machi = fit.curve.at(fit.machi_s_mm);
    const glm::dvec3 tip = fit.curve.at(fit.tip_s_mm);
    const glm::dvec3 chord = tip - machi;
    const double nagasa = glm::length(chord);
    if (fit.point) {
        m.push_back({"nagasa_mm", nagasa, 0});
        // Depth of the mune below the line from machi to tip, in the blade's plane.
        const glm::dvec3 up = glm::normalize(glm::dvec3(-chord.z, 0, chord.x));
        double sori = 0;
        double at = 0;
        constexpr int steps = 4000;
        for (int i = 1; i < steps; ++i) {
            const double s = fit.machi_s_mm + (fit.tip_s_mm - fit.machi_s_mm) * i / steps;
            const glm::dvec3 from = fit.curve.at(s) - machi;
            const double depth = -glm::dot(from, up);
            if (std::abs(depth) > std::abs(sori)) {
                sori = depth;
                at = glm::dot(from, chord) / nagasa;
            }
        }
        m.push_back({"sori_mm", sori, fit.curve.mune_residual()});
        m.push_back({"sori_at_mm", at, fit.curve.mune_residual()});
    }
    const BladeLines& lines = fit.lines;
    auto at = [&](double s, const char* prefix) {
        const std::string name(prefix);
        m.push_back({name + "haba_mm", lines.edge_d.at(s), lines.edge_d.near_d.residual()});
        m.push_back({name + "kasane_mm", 2 * lines.corner_y.at(s), lines.corner_y.residual()});
        if (!fit.ridge) return;
        m.push_back(
            {name + "_shinogi_haba_mm", lines.shinogi_d.at(s), lines.shinogi_d.near_d.residual()});
        m.push_back(
            {name + "_shinogi_kasane_mm", 2 * lines.shinogi_y.at(s), lines.shinogi_y.residual()});
    };
    at(fit.machi_s_mm, "moto");
    m.push_back({"mune_height_mm",
                 lines.corner_d.at(fit.machi_s_mm) - lines.top_d.at(fit.machi_s_mm),
                 lines.corner_d.residual()});
    if (fit.yokote) {
        at(fit.yokote_s_mm, "saki");
        m.push_back({"kissaki_mm", glm::length(tip - fit.curve.at(fit.yokote_s_mm)), 0});
    }
    if (fit.tang) m.push_back({"nakago_mm", fit.nakago_mm, 0});
    return m;
}

}  // namespace togishi
