#include "scanned/label_parts.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace togishi {

std::vector<Part> label_parts(const TriangleMesh& mesh, const MeshPieces& pieces,
                              const ScanAnalysis& analysis, const ScannedChart& chart) {
    // A fitting stands out over the blade by more than a blade is uneven.
    constexpr double stands_out_mm = 0.5;
    std::vector<Part> part(mesh.triangles.size(), Part::other);
    const glm::dvec3 shift = mesh.origin - analysis.pose.origin_mm;
    parallel_for(part.size(), 4096, [&](std::size_t from, std::size_t to) {
        for (std::size_t f = from; f < to; ++f) {
            if (analysis.body[pieces.of[f]] == 0) continue;
            const Triangle& t = mesh.triangles[f];
            glm::dvec3 middle(0);
            for (const std::uint32_t v : t) middle += glm::dvec3(mesh.positions[v]) / 3.0;
            const ChartPlace place = chart.place(analysis.pose.rotation * (middle + shift));
            const bool covered = std::any_of(
                analysis.fittings_mm.begin(), analysis.fittings_mm.end(), [&](const auto& fitting) {
                    return place.arc_mm > fitting.first - 1 && place.arc_mm < fitting.second + 1;
                });
            // Its lips lead down to the blade: one corner that stands out is enough.
            const auto stands_out = [&](std::uint32_t v) {
                const glm::dvec3 p = glm::dvec3(mesh.positions[v]) + shift;
                return chart.place(analysis.pose.rotation * p).off_mm > stands_out_mm;
            };
            if (covered && std::any_of(t.begin(), t.end(), stands_out)) continue;
            // Noise lifts points of the edge over it.
            const BladeFrame& frame = chart.frame();
            const double edge = frame.at(frame.edge_mm, place.s_mm);
            part[f] = frame.part_at(place.s_mm, std::min(place.t_mm, edge));
        }
    });
    return part;
}

}  // namespace togishi
