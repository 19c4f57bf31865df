#include "blade/katana_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/parallel.hpp"

namespace togishi {
namespace {

constexpr double sample_step_mm = 0.25;

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
    struct Point {
        double beyond;  // t beyond the mune's corner, negative on the mune
        double length;  // |P_arc| less its part along P_t
        double shear;
    };
    std::vector<Point> points;
    double mune_slope = 0;  // change of the mune's developed half width along the arc
    double half_width = 0;
    double mune_half_width = 0;
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

// Running mean over some 3 mm: turns kinks into bends, which a map follows.
std::vector<double> smooth(const std::vector<double>& values) {
    constexpr int half = 6;
    const auto n = static_cast<std::ptrdiff_t>(values.size());
    std::vector<double> result(values.size());
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        double sum = 0;
        for (std::ptrdiff_t j = i - half; j <= i + half; ++j) {
            sum += values[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(j, 0, n - 1))];
        }
        result[static_cast<std::size_t>(i)] = sum / (2 * half + 1);
    }
    return result;
}

// Value at x of a curve through (xs, ys), straight between them, xs rising; beyond the ends the end
// pieces' ends.
double interpolated(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
    const auto next =
        static_cast<std::size_t>(std::upper_bound(xs.begin() + 1, xs.end() - 1, x) - xs.begin());
    const double share = std::clamp((x - xs[next - 1]) / (xs[next] - xs[next - 1]), 0.0, 1.0);
    return ys[next - 1] + (ys[next] - ys[next - 1]) * share;
}

// How the misfit of mune and sides is shared out.
struct Shares {
    double lift;        // of the sides' shear, taken by opening the ridge; the rest by turning them
    double spent;       // stretch along the edge that turning the sides may cost
    double mune_spent;  // stretch along the ridge that turning the mune may cost
};

// One way to lay the surface out.
struct Development {
    std::vector<double> skew;       // between samples
    std::vector<double> mune_skew;  // between samples
    std::vector<double> lift_mm;    // at samples
    std::vector<double> s_mm;       // at samples, from 0
    double worst = 1e9;             // largest |singular value - 1| from machi to tip
};

// What turns and lifts the chart at one place: of the sides and of the mune.
struct Turn {
    double skew;
    double slope;  // of the skew along the arc
};
struct Layout {
    Turn side;
    Turn mune;
    double lift_slope;
    double mune_slope;

    [[nodiscard]] const Turn& turn(const Metric::Point& p) const {
        return p.beyond < 0 ? mune : side;
    }
    // The ds per arc length that keeps lengths at a point.
    [[nodiscard]] double fits(const Metric::Point& p) const {
        const Turn& t = turn(p);
        return p.length + t.slope * p.beyond - t.skew * (p.shear + mune_slope);
    }
};

// Largest (singular value - 1) and largest (1 - singular value) of the map into the chart at one
// arc length.
glm::dvec2 over_and_under(const Metric& metric, const Layout& layout, double ds) {
    glm::dvec2 worst(0);
    for (const Metric::Point& p : metric.points) {
        // Derivatives of (x, y) along two unit vectors of the surface at right angles.
        const double x1 = 1 + (ds - layout.fits(p)) / p.length;
        const double x2 = -layout.turn(p).skew;
        const double y1 = (layout.lift_slope - p.shear) / p.length;
        const double sum = x1 * x1 + x2 * x2 + y1 * y1 + 1;
        const double determinant = x1 - x2 * y1;
        const double root = std::sqrt(std::max(0.0, sum * sum - 4 * determinant * determinant));
        worst.x = std::max(worst.x, std::sqrt(0.5 * (sum + root)) - 1);
        worst.y = std::max(worst.y, 1 - std::sqrt(std::max(0.0, 0.5 * (sum - root))));
    }
    return worst;
}

// The skews between samples: what each share asks for, no faster than its cost allows.
std::vector<double> turned(const std::vector<double>& target, const std::vector<Metric>& metric,
                           double Metric::*half_width, const std::vector<double>& arc_mm,
                           double spent) {
    std::vector<double> limit(target.size());
    for (std::size_t i = 0; i < limit.size(); ++i) {
        limit[i] = spent * (arc_mm[i + 1] - arc_mm[i]) / std::max(metric[i].*half_width, 0.5);
    }
    return smooth(smooth(limit_slope(target, limit)));
}

Turn turn_between(const std::vector<double>& skew, std::size_t i, double step) {
    const double before = i > 0 ? 0.5 * (skew[i - 1] + skew[i]) : skew[i];
    const double after = i + 1 < skew.size() ? 0.5 * (skew[i] + skew[i + 1]) : skew[i];
    return {skew[i], (after - before) / step};
}

Development develop(const std::vector<Metric>& metric, const std::vector<double>& arc_mm,
                    double lift_from_mm, const Shares& shares) {
    const std::size_t n = arc_mm.size();
    Development d;
    d.lift_mm.assign(n, 0);
    std::vector<double> target(n - 1);
    std::vector<double> mune_target(n - 1);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double step = arc_mm[i + 1] - arc_mm[i];
        const double lift = arc_mm[i] >= lift_from_mm
                                ? std::max(-d.lift_mm[i], shares.lift * metric[i].shear * step)
                                : 0;
        d.lift_mm[i + 1] = d.lift_mm[i] + lift;
        target[i] = lift / step - metric[i].shear;
        mune_target[i] = lift / step;
    }
    d.skew = turned(target, metric, &Metric::half_width, arc_mm, shares.spent);
    d.mune_skew = turned(mune_target, metric, &Metric::mune_half_width, arc_mm, shares.mune_spent);
    d.s_mm.assign(n, 0);
    d.worst = 0;
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double step = arc_mm[i + 1] - arc_mm[i];
        const Layout layout{turn_between(d.skew, i, step), turn_between(d.mune_skew, i, step),
                            (d.lift_mm[i + 1] - d.lift_mm[i]) / step, metric[i].mune_slope};
        double least = 1e9;
        double most = 0;
        for (const Metric::Point& p : metric[i].points) {
            const double fits = layout.fits(p);
            least = std::min(least, fits);
            most = std::max(most, fits);
        }
        double ds = 0.5 * (least + most);
        // Where next to nothing is turned, nothing is to be evened out, nor can the worst place lie
        // there.
        if (arc_mm[i] >= 0 && std::abs(d.skew[i]) + std::abs(metric[i].shear) > 4e-3) {
            // Turned parts stretch one way more than the other: even that out.
            const glm::dvec2 first = over_and_under(metric[i], layout, ds);
            ds *= 1 - 0.5 * (first.x - first.y);
            const glm::dvec2 range = over_and_under(metric[i], layout, ds);
            d.worst = std::max({d.worst, range.x, range.y});
        }
        d.s_mm[i + 1] = d.s_mm[i] + step * ds;
    }
    return d;
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
    parallel_for(n - 1, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            double arc = 0.5 * (sample_arc_mm_[i] + sample_arc_mm_[i + 1]);
            if (arc < 0) arc = std::clamp(arc, nakago_first, nakago_last);
            metric[i] = metric_at(shape, arc);
            if (arc < 0) metric[i].shear = 0;
        }
    });
    // How to share the misfit out: by whichever way stretches the chart least at its worst place.
    const double lift_from_mm = shape.range(Stretch::kissaki)[0];
    Development best;
    for (const double lift : {0.6, 0.75, 0.9}) {
        for (const double spent : {0.004, 0.008, 0.016}) {
            for (const double mune_spent : {0.004, 0.008, 0.016}) {
                Development tried =
                    develop(metric, sample_arc_mm_, lift_from_mm, {lift, spent, mune_spent});
                if (tried.worst < best.worst) best = std::move(tried);
            }
        }
    }
    std::vector<double>& s = best.s_mm;
    const double machi = s[before];
    for (double& value : s) value -= machi;
    sample_s_mm_ = s;
    frame_.nakago_mm = -s.front();
    frame_.nagasa_mm = s.back();
    frame_.yokote_s_mm =
        shape.has_yokote() ? s_mm(shape.range(Stretch::kissaki)[0]) : frame_.nagasa_mm;

    const auto samples = static_cast<std::size_t>(frame_.length_mm() / sample_step_mm) + 2;
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
