#include "blade/katana_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/parallel.hpp"

namespace togishi {
namespace {

constexpr double sample_step_mm = 0.2;
// Stretch spent on turning the sides in the chart, at the edge and at the ridge.
constexpr double skew_stretch = 0.009;

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

// What the surface's metric is at one arc length, against (arc length, t).
struct Metric {
    double shear = 0;  // mean over the side of P_arc . P_t: what turns a line of constant t against
                       // the surface
    /// At several points: t beyond the mune (-1 on it), |P_arc| less its part along P_t.
    std::vector<std::pair<double, double>> beyond_and_length;
    double mune_slope = 0;  // change of the mune's developed half width along the arc
    double half_width = 0;
};

Metric metric_at(const KatanaShape& shape, double arc) {
    constexpr double h = 1e-3;
    constexpr std::array<double, 3> fs{0.02, 0.5, 0.98};
    const auto [stretch, q] = find(shape, arc);
    const auto [first, last] = shape.range(stretch);
    const double q0 = std::max(first, q - h);
    const double q1 = std::min(last, q + h);
    const KatanaShape::Row row = shape.row(stretch, q);
    const Section s0 = shape.section(stretch, Dual(q0));
    const Section s1 = shape.section(stretch, Dual(q1));
    Metric m;
    double t_start = 0;
    double mune_width = 0;
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
            const bool side = strip != Strip::mune_top && strip != Strip::mune_side;
            const double beyond =
                side ? t_start + KatanaShape::developed_mm(row.section, strip, mune, f) - mune_width
                     : -1;
            m.beyond_and_length.emplace_back(beyond, glm::length(p_arc - pt * shear));
            if (strip != Strip::mune_top && strip != Strip::mune_side && strip != Strip::foot) {
                shear_sum += shear * width;
                weight += width;
            }
        }
        if (strip == Strip::mune_side) {
            mune_width = t_start + width;
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
    return m;
}

// The curve nearest to `target` (in its largest difference) that changes by no more than limit[i]
// from i to i + 1.
std::vector<double> limit_slope(const std::vector<double>& target,
                                const std::vector<double>& limit) {
    std::vector<double> upper = target;
    std::vector<double> lower = target;
    const std::size_t n = target.size();
    for (std::size_t i = 1; i < n; ++i) {
        upper[i] = std::max(upper[i], upper[i - 1] - limit[i - 1]);
        lower[i] = std::min(lower[i], lower[i - 1] + limit[i - 1]);
    }
    for (std::size_t i = n - 1; i-- > 0;) {
        upper[i] = std::max(upper[i], upper[i + 1] - limit[i]);
        lower[i] = std::min(lower[i], lower[i + 1] + limit[i]);
    }
    for (std::size_t i = 0; i < n; ++i) upper[i] = 0.5 * (upper[i] + lower[i]);
    return upper;
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
    const auto before = static_cast<std::size_t>(line.nakago_arc_mm() / sample_step_mm) + 1;
    const auto after = static_cast<std::size_t>(line.blade_arc_mm() / sample_step_mm) + 1;
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
    std::vector<Metric> metric(n - 1);
    std::vector<double> target(n - 1);
    std::vector<double> limit(n - 1);
    parallel_for(n - 1, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            double arc = 0.5 * (sample_arc_mm_[i] + sample_arc_mm_[i + 1]);
            if (arc < 0) arc = std::clamp(arc, nakago_first, nakago_last);
            metric[i] = metric_at(shape, arc);
            target[i] = arc < 0 ? 0 : -metric[i].shear;
            limit[i] = skew_stretch * sample_step_mm / std::max(metric[i].half_width, 0.5);
        }
    });
    const std::vector<double> skew = limit_slope(target, limit);

    std::vector<double> s(n);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double step = sample_arc_mm_[i + 1] - sample_arc_mm_[i];
        const double before_skew = i > 0 ? 0.5 * (skew[i - 1] + skew[i]) : skew[i];
        const double after_skew = i + 2 < n ? 0.5 * (skew[i] + skew[i + 1]) : skew[i];
        const double slope = (after_skew - before_skew) / step;
        double least = 1e9;
        double most = 0;
        for (const auto& [beyond, length] : metric[i].beyond_and_length) {
            const double fits = beyond < 0 ? length
                                           : length + slope * beyond -
                                                 skew[i] * (metric[i].shear + metric[i].mune_slope);
            least = std::min(least, fits);
            most = std::max(most, fits);
        }
        s[i + 1] = s[i] + step * 0.5 * (least + most);
    }
    const double machi = s[before];
    for (double& value : s) value -= machi;
    sample_s_mm_ = s;
    frame_.nakago_mm = -s.front();
    frame_.nagasa_mm = s.back();
    frame_.yokote_s_mm =
        shape.has_yokote() ? s_mm(shape.range(Stretch::kissaki)[0]) : frame_.nagasa_mm;

    const auto samples = static_cast<std::size_t>(frame_.length_mm() / sample_step_mm) + 2;
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
        const auto k = std::clamp<std::ptrdiff_t>(
            std::upper_bound(sample_arc_mm_.begin(), sample_arc_mm_.end(), arc) -
                sample_arc_mm_.begin() - 1,
            0, static_cast<std::ptrdiff_t>(skew.size()) - 1);
        frame_.skew.push_back(skew[static_cast<std::size_t>(k)]);
        highest = std::max(highest, r.edge_mm);
    }
    // Some room beyond the edge lines, so that a map can be padded there.
    frame_.chart_height_mm = 2 * highest * 1.03;
}

double KatanaChart::s_mm(double arc) const {
    const auto next = std::clamp<std::ptrdiff_t>(
        std::upper_bound(sample_arc_mm_.begin(), sample_arc_mm_.end(), arc) -
            sample_arc_mm_.begin(),
        1, static_cast<std::ptrdiff_t>(sample_arc_mm_.size()) - 1);
    const auto i = static_cast<std::size_t>(next) - 1;
    return sample_s_mm_[i] + (arc - sample_arc_mm_[i]) * (sample_s_mm_[i + 1] - sample_s_mm_[i]) /
                                 (sample_arc_mm_[i + 1] - sample_arc_mm_[i]);
}

double KatanaChart::arc_mm(double s) const {
    const auto next = std::clamp<std::ptrdiff_t>(
        std::upper_bound(sample_s_mm_.begin(), sample_s_mm_.end(), s) - sample_s_mm_.begin(), 1,
        static_cast<std::ptrdiff_t>(sample_s_mm_.size()) - 1);
    const auto i = static_cast<std::size_t>(next) - 1;
    return sample_arc_mm_[i] + (s - sample_s_mm_[i]) * (sample_arc_mm_[i + 1] - sample_arc_mm_[i]) /
                                   (sample_s_mm_[i + 1] - sample_s_mm_[i]);
}

BladeFrame make_blade_frame(const KatanaParameters& parameters) {
    return KatanaChart(KatanaShape(parameters)).frame();
}

}  // namespace togishi
