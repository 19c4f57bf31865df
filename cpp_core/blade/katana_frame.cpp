#include "blade/katana_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/parallel.hpp"
#include "blade/development.hpp"

namespace togishi {
namespace {

// The stretch that an arc length of the mune line falls in, and its q there.
std::pair<Stretch, double> find(const KatanaShape& shape, double arc) {
    const MuneLine& line = shape.mune_line();
    if (arc >= shape.range(Stretch::kissaki)[0])
        return {Stretch::kissaki, std::min(arc, line.blade_arc_mm())};
    if (arc >= 0) return {Stretch::blade, arc};
    if (arc > shape.range(Stretch::machi)[0]) return {Stretch::machi, arc};
    const double jiri_start = shape.range(Stretch::nakago)[0];
    if (arc >= jiri_start) return {Stretch::nakago, arc};
    const double share = (arc + line.nakago_arc_mm()) / (jiri_start + line.nakago_arc_mm());
    return {Stretch::jiri, std::acos(std::clamp(1 - share, 0.0, 1.0))};
}

SurfaceMetric metric_at(const KatanaShape& shape, double arc) {
    constexpr double h = 1e-3;
    constexpr std::array<double, 3> fs{0.02, 0.5, 0.98};
    const auto [stretch, q] = find(shape, arc);
    const auto [first, last] = shape.range(stretch);
    const double q0 = std::max(first, q - h);
    const double q1 = std::min(last, q + h);
    const KatanaShape::Row row = shape.row(stretch, q);
    const Section s0 = shape.section(stretch, Dual(q0));
    const Section s1 = shape.section(stretch, Dual(q1));
    SurfaceMetric m;
    double t_start = 0;
    double mune_width = 0;
    for (const Strip strip : {Strip::mune_top, Strip::mune_side}) {
        if (shape.has(strip, stretch))
            mune_width += KatanaShape::developed_mm(row.section, strip, row.mune, 1);
    }
    double before0 = 0;
    double before1 = 0;
    double shear_sum = 0;
    double weight = 0;
    for (const Strip strip : strips) {
        if (!shape.has(strip, stretch)) continue;
        const MuneType mune = row.mune;
        const double width = KatanaShape::developed_mm(row.section, strip, mune, 1);
        for (const double f : fs) {
            const SurfacePoint p = row.at(strip, f);
            const glm::dvec3 pt = p.across / glm::length(p.across);
            const double dt_dq = (before1 + KatanaShape::developed_mm(s1, strip, mune, f) -
                                  before0 - KatanaShape::developed_mm(s0, strip, mune, f)) /
                                 (q1 - q0);
            const glm::dvec3 p_arc = p.along - pt * dt_dq;
            const double shear = glm::dot(p_arc, pt);
            const double beyond =
                t_start + KatanaShape::developed_mm(row.section, strip, mune, f) - mune_width;
            m.points.push_back({beyond, glm::length(p_arc - pt * shear), shear});
            if (strip != Strip::mune_top && strip != Strip::mune_side && strip != Strip::foot) {
                shear_sum += shear * width;
                weight += width;
            }
        }
        if (strip == Strip::mune_side) {
            m.mune_slope = (before1 + KatanaShape::developed_mm(s1, strip, mune, 1) - before0 -
                            KatanaShape::developed_mm(s0, strip, mune, 1)) /
                           (q1 - q0);
        }
        t_start += width;
        before0 += KatanaShape::developed_mm(s0, strip, mune, 1);
        before1 += KatanaShape::developed_mm(s1, strip, mune, 1);
    }
    m.shear = shear_sum / weight;
    m.half_width = 0.5 * t_start;
    m.mune_half_width = 0.5 * mune_width;
    return m;
}

}  // namespace

ChartRow KatanaChart::row(const KatanaShape& shape, Stretch stretch, double q) {
    const Section section = shape.section(stretch, Dual(q));
    ChartRow row;
    double t = 0;
    for (const Strip strip : strips) {
        if (shape.has(strip, stretch))
            t += KatanaShape::developed_mm(section, strip, shape.parameters().mune, 1);
        row.strip_end_mm[static_cast<std::size_t>(strip)] = t;
    }
    row.mune_mm = row.strip_end_mm[static_cast<std::size_t>(Strip::mune_side)];
    row.shinogi_mm = row.strip_end_mm[static_cast<std::size_t>(Strip::shinogi_ji)];
    row.suguha_mm = row.strip_end_mm[static_cast<std::size_t>(Strip::ji)];
    row.edge_mm = t;
    return row;
}

KatanaChart::KatanaChart(const KatanaShape& shape) {
    const MuneLine& line = shape.mune_line();
    // Samples at equal steps in each of nakago and blade, so that one lies on the machi.
    const auto before = static_cast<std::size_t>(line.nakago_arc_mm() / development_step_mm) + 1;
    const auto after = static_cast<std::size_t>(line.blade_arc_mm() / development_step_mm) + 1;
    for (std::size_t i = 0; i < before; ++i) {
        sample_arc_mm_.push_back(line.nakago_arc_mm() *
                                 (static_cast<double>(i) / static_cast<double>(before) - 1));
    }
    for (std::size_t i = 0; i <= after; ++i) {
        sample_arc_mm_.push_back(line.blade_arc_mm() * static_cast<double>(i) /
                                 static_cast<double>(after));
    }
    const std::size_t n = sample_arc_mm_.size();

    // Metric halfway between samples. The walls at the machi and the nakago's end lie across the
    // chart: left out.
    const double nakago_first = shape.range(Stretch::nakago)[0] + 1e-6;
    const double nakago_last = shape.range(Stretch::nakago)[1] - 1e-6;
    std::vector<SurfaceMetric> metric(n - 1);
    parallel_for(n - 1, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            double arc = 0.5 * (sample_arc_mm_[i] + sample_arc_mm_[i + 1]);
            if (arc < 0) arc = std::clamp(arc, nakago_first, nakago_last);
            metric[i] = metric_at(shape, arc);
            if (arc < 0) metric[i].shear = 0;
        }
    });
    Development best = develop_blade(metric, sample_arc_mm_, shape.range(Stretch::kissaki)[0]);
    std::vector<double>& s = best.s_mm;
    const double machi = s[before];
    for (double& value : s) value -= machi;
    sample_s_mm_ = s;
    frame_.nakago_mm = -s.front();
    frame_.nagasa_mm = s.back();
    frame_.yokote_s_mm =
        shape.has_yokote() ? s_mm(shape.range(Stretch::kissaki)[0]) : frame_.nagasa_mm;

    const auto samples = static_cast<std::size_t>(frame_.length_mm() / development_step_mm) + 2;
    std::vector<double> middles(best.skew.size());
    for (std::size_t i = 0; i < middles.size(); ++i) {
        middles[i] = 0.5 * (sample_arc_mm_[i] + sample_arc_mm_[i + 1]);
    }
    double highest = 0;
    for (std::size_t i = 0; i < samples; ++i) {
        const double here = -frame_.nakago_mm + frame_.length_mm() * static_cast<double>(i) /
                                                    static_cast<double>(samples - 1);
        const double arc = arc_mm(here);
        const auto [stretch, q] = find(shape, arc);
        const ChartRow r = row(shape, stretch, q);
        frame_.edge_mm.push_back(r.edge_mm);
        frame_.shinogi_mm.push_back(r.shinogi_mm);
        frame_.mune_mm.push_back(r.mune_mm);
        frame_.suguha_mm.push_back(r.suguha_mm);
        // The skews were found for the middles of the steps.
        frame_.skew.push_back(interpolated(middles, best.skew, arc));
        frame_.mune_skew.push_back(interpolated(middles, best.mune_skew, arc));
        frame_.lift_mm.push_back(interpolated(sample_arc_mm_, best.lift_mm, arc));
        highest = std::max(highest, frame_.edge_mm.back() + frame_.lift_mm.back());
    }
    // Some room beyond the edge lines, so that a map can be padded there.
    frame_.chart_height_mm = 2 * highest * 1.03;
}

double KatanaChart::s_mm(double arc) const {
    return interpolated(sample_arc_mm_, sample_s_mm_, arc);
}

double KatanaChart::arc_mm(double s) const {
    return interpolated(sample_s_mm_, sample_arc_mm_, s);
}

BladeFrame make_blade_frame(const KatanaParameters& parameters) {
    return KatanaChart(KatanaShape(parameters)).frame();
}

}  // namespace togishi
