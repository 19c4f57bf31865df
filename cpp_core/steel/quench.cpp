#include "steel/quench.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "steel/line_distance.hpp"
#include "steel/noise.hpp"

namespace togishi {
namespace {

// Heat spreads as a Gaussian of sigma = sqrt(2 a t): with steel's diffusivity a = 6 mm^2/s at 700
// degrees and the tens of milliseconds in which a thin edge passes the critical temperatures, about
// half a millimetre; less across, where the water takes it away.
constexpr double spread_along_mm = 0.38;
constexpr double spread_across_mm = 0.32;
// Steel over the edge is thicker and cools more slowly: loss of ln(rate) per mm of height over the
// calm line.
constexpr double thicker_per_mm = 0.03;

}  // namespace

QuenchedSide quench(const SteelOutline& outline, const SteelParameters& p, FieldGrid rate,
                    unsigned threads) {
    // Conductance of the clay, then of the clay with the steel's own spreading, then
    // ln(rate/critical).
    rate.diffuse(spread_along_mm, spread_across_mm, threads);
    const float critical = 0.5F * (1.0F + thick_clay_conductance);
    const float most = std::log(1.0F / critical);
    // ln(rate)'s slope across a straight, sharp clay border: the step of the conductance, spread.
    const auto sharp =
        static_cast<float>((1.0 - thick_clay_conductance) / critical /
                           std::sqrt(6.2832 * (spread_across_mm * spread_across_mm + 0.018)));

    const std::size_t columns = rate.columns();
    const std::size_t rows = rate.rows();
    parallel_for(
        columns, 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                float* line = rate.column(i);
                const double s = rate.s_of(i);
                const double calm = calm_height(outline, p, s);
                const double body = 1.0 - smooth_step(-8.0, 0.0, s - outline.kissaki_s());
                for (std::size_t j = 0; j < rows; ++j) {
                    const double over = std::clamp(rate.q_of(j) - calm, -6.0, 6.0);
                    line[j] = std::log(line[j] / critical) -
                              static_cast<float>(thicker_per_mm * over * body);
                }
            }
        },
        threads);

    QuenchedSide side;
    side.depth_mm = distance_to_zero(rate, 4.0F);
    side.softness = side.depth_mm;
    side.crest_q.assign(columns, 0.0);
    const auto per_mm = static_cast<float>(0.5 / rate.step());
    parallel_for(
        columns, 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const float* line = rate.column(i);
                const float* before = rate.column(i > 0 ? i - 1 : i);
                const float* after = rate.column(std::min(i + 1, columns - 1));
                float* depth = side.depth_mm.column(i);
                float* soft = side.softness.column(i);
                for (std::size_t j = 0; j < rows; ++j) {
                    const float up = line[std::min(j + 1, rows - 1)] - line[j > 0 ? j - 1 : 0];
                    const float along = after[j] - before[j];
                    const float slope = per_mm * std::sqrt(up * up + along * along);
                    const float gentle = std::max(slope, 0.4F * sharp);
                    // Within the ha the rate tells how nearly it failed to harden (ashi, yo); where
                    // it is far above the critical one, and in the ji, the distance to the line
                    // holds.
                    if (line[j] > 0.0F) {
                        const float near = line[j] / gentle;
                        const float away = smooth_step(0.55F, 0.95F, line[j] / most);
                        depth[j] = std::lerp(std::min(near, depth[j] + 0.2F),
                                             std::max(near, depth[j]), away);
                    }
                    soft[j] = std::clamp(sharp / std::max(slope, 1e-4F), 0.7F, 2.4F);
                }
                const double s = rate.s_of(i);
                if (s < outline.kissaki_s()) {
                    for (std::size_t j = rows; j-- > 0;) {
                        if (depth[j] > 0.0F) {
                            side.crest_q[i] = std::max(rate.q_of(j), 0.0);
                            break;
                        }
                    }
                } else {
                    const double edge = outline.straight_edge(s) - outline.edge(s);
                    auto j = static_cast<std::size_t>(
                        std::clamp((edge + 0.3 - rate.q_of(0)) / rate.step(), 0.0,
                                   static_cast<double>(rows - 1)));
                    while (j + 1 < rows && depth[j] > 0.0F) ++j;
                    side.crest_q[i] = std::max(rate.q_of(j), 0.0);
                }
            }
        },
        threads);
    side.depth_mm.diffuse(0.07, 0.07, threads);
    side.softness.diffuse(0.5, 0.3, threads);
    return side;
}

double QuenchedSide::crest_at(double s) const {
    const double last = static_cast<double>(crest_q.size() - 1);
    const double x = std::clamp((s - depth_mm.s_of(0)) / depth_mm.step(), 0.0, last);
    const auto i = std::min(static_cast<std::size_t>(x), crest_q.size() - 2);
    return std::lerp(crest_q[i], crest_q[i + 1], x - static_cast<double>(i));
}

}  // namespace togishi
