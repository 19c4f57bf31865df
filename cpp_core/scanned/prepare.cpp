#include "scanned/prepare.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "base/error.hpp"

namespace togishi {
namespace {

ChartedMesh lighter(const ChartedMesh& scan, SimplifiedMesh simplified) {
    ChartedMesh level;
    level.mesh = std::move(simplified.mesh);
    const std::size_t n = simplified.source_vertex.size();
    level.s_mm.reserve(n);
    level.t_mm.reserve(n);
    level.off_mm.reserve(n);
    for (const std::uint32_t v : simplified.source_vertex) {
        level.s_mm.push_back(scan.s_mm[v]);
        level.t_mm.push_back(scan.t_mm[v]);
        level.off_mm.push_back(scan.off_mm[v]);
    }
    level.region.reserve(simplified.part.size());
    for (const std::uint8_t id : simplified.part) level.region.emplace_back(id);
    return level;
}

}  // namespace

PreparedBlade prepare_blade(TriangleMesh scan, const BladePose& pose,
                            const ScannedStations& stations, std::span<const Part> labels,
                            const PrepareOptions& options, const PrepareProgress& progress) {
    if (options.levels < 1 || options.levels > 6)
        throw InputError("scanned blade", "levels", std::to_string(options.levels), "1 to 6");
    if (!(options.level_factor > 1 && options.level_factor <= 100)) {
        throw InputError("scanned blade", "level_factor", std::to_string(options.level_factor),
                         "above 1, up to 100");
    }
    auto report = [&](double share) {
        if (progress && !progress(share)) throw PrepareCancelled{};
    };
    PreparedBlade result;
    StepClock clock(result.time);
    result.scan_triangles = scan.triangles.size();
    const ScannedChart chart(stations, options.chart);
    clock.end("chart");
    report(0.05);
    const ChartedMesh charted =
        chart_mesh(std::move(scan), pose, chart, labels, options.detail.threads);
    result.cut_triangles = charted.cut;
    clock.end("cut");
    report(0.25);

    std::vector<double> errors_mm;
    std::vector<std::uint8_t> regions;
    for (std::size_t i = 0; i < options.levels; ++i)
        errors_mm.push_back(options.error_mm * std::pow(options.level_factor, i));
    regions.reserve(charted.region.size());
    for (const Region& region : charted.region) regions.push_back(region.id());
    // The chart too: a texture slides by no more than the surface may. Told from the place itself,
    // which changes nothing on a flat triangle and keeps the numbers small: they are squared in
    // single precision.
    std::vector<float> places;
    places.reserve(2 * charted.s_mm.size());
    for (std::size_t v = 0; v < charted.s_mm.size(); ++v) {
        const double s = double(charted.s_mm[v]);
        const double t = double(charted.t_mm[v]);
        const glm::dvec3 p(charted.mesh.positions[v]);
        places.push_back(static_cast<float>(chart.frame().chart_x_mm(s, t) - p.x));
        places.push_back(static_cast<float>(chart.frame().chart_y_mm(s, t) + p.z));
    }
    constexpr std::array<float, 2> weights{1, 1};
    SimplifyOptions simplification;
    simplification.part = regions;
    simplification.attributes = places;
    simplification.attribute_count = weights.size();
    simplification.attribute_weights = weights;
    simplification.samples = options.samples;
    std::vector<SimplifiedMesh> simplified =
        levels_of_detail(charted.mesh, errors_mm, simplification);
    clock.end("simplify");
    report(0.7);

    std::vector<ChartedMesh> levels;
    levels.reserve(simplified.size());
    for (std::size_t i = 0; i < simplified.size(); ++i) {
        result.levels.emplace_back();
        result.levels.back().error_mm = errors_mm[i];
        result.levels.back().distance = simplified[i].distance;
        levels.push_back(lighter(charted, std::move(simplified[i])));
    }
    settle_within(levels.front(), chart, charted.mesh, options.error_mm, options.samples,
                  result.settled, result.levels.front().distance);
    clock.end("settle");
    if (options.maps) {
        result.detail = bake_detail(charted, levels.front(), chart.frame(), options.detail);
        clock.end("detail");
    }
    report(0.95);
    for (std::size_t i = 0; i < levels.size(); ++i)
        result.levels[i].mesh = blade_mesh(levels[i], chart, options.detail.threads);
    result.stretch_99_percent = uv_stretch_of_area_percent(result.levels.front().mesh);
    result.stretch_most_percent = uv_stretch_percent(result.levels.front().mesh);
    clock.end("corners");
    report(1);
    return result;
}

}  // namespace togishi
