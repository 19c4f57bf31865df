#include "blade/development.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <glm/glm.hpp>

namespace togishi {
namespace {

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

// How the misfit of mune and sides is shared out.
struct Shares {
    double lift;        // of the sides' shear, taken by opening the ridge; the rest by turning them
    double spent;       // stretch along the edge that turning the sides may cost
    double mune_spent;  // stretch along the ridge that turning the mune may cost
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

    [[nodiscard]] const Turn& turn(const SurfaceMetric::Point& p) const {
        return p.beyond < 0 ? mune : side;
    }
    // The ds per arc length that keeps lengths at a point.
    [[nodiscard]] double fits(const SurfaceMetric::Point& p) const {
        const Turn& t = turn(p);
        return p.length + t.slope * p.beyond - t.skew * (p.shear + mune_slope);
    }
};

// Largest (singular value - 1) and largest (1 - singular value) of the map into the chart at one
// arc length.
glm::dvec2 over_and_under(const SurfaceMetric& metric, const Layout& layout, double ds) {
    glm::dvec2 worst(0);
    for (const SurfaceMetric::Point& p : metric.points) {
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
std::vector<double> turned(const std::vector<double>& target,
                           const std::vector<SurfaceMetric>& metric,
                           double SurfaceMetric::*half_width, const std::vector<double>& arc_mm,
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

Development develop(const std::vector<SurfaceMetric>& metric, const std::vector<double>& arc_mm,
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
    d.skew = turned(target, metric, &SurfaceMetric::half_width, arc_mm, shares.spent);
    d.mune_skew =
        turned(mune_target, metric, &SurfaceMetric::mune_half_width, arc_mm, shares.mune_spent);
    d.s_mm.assign(n, 0);
    d.worst = 0;
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double step = arc_mm[i + 1] - arc_mm[i];
        const Layout layout{turn_between(d.skew, i, step), turn_between(d.mune_skew, i, step),
                            (d.lift_mm[i + 1] - d.lift_mm[i]) / step, metric[i].mune_slope};
        double least = 1e9;
        double most = 0;
        for (const SurfaceMetric::Point& p : metric[i].points) {
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

double interpolated(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
    const auto next =
        static_cast<std::size_t>(std::upper_bound(xs.begin() + 1, xs.end() - 1, x) - xs.begin());
    const double share = std::clamp((x - xs[next - 1]) / (xs[next] - xs[next - 1]), 0.0, 1.0);
    return ys[next - 1] + (ys[next] - ys[next - 1]) * share;
}

Development develop_blade(const std::vector<SurfaceMetric>& metric,
                          const std::vector<double>& arc_mm, double lift_from_mm) {
    Development best;
    for (const double lift : {0.6, 0.75, 0.9}) {
        for (const double spent : {0.004, 0.008, 0.016}) {
            for (const double mune_spent : {0.004, 0.008, 0.016}) {
                Development tried =
                    develop(metric, arc_mm, lift_from_mm, {lift, spent, mune_spent});
                if (tried.worst < best.worst) best = std::move(tried);
            }
        }
    }
    return best;
}

}  // namespace togishi
