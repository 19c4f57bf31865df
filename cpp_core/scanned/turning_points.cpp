#include "scanned/turning_points.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/text.hpp"
#include "scanned/least_squares.hpp"

namespace togishi {
namespace {

// Flat, wall, flat: the depth of the mune about the machi, with its wall from end - run to end.
struct Wall {
    double end = 0, run = 1, drop = 0;
    double squares = 1e300;
};

Wall fit_wall(const std::vector<BladePoint>& points, double end, double run) {
    // value = a + drop * share
    double n = 0, x = 0, xx = 0, y = 0, xy = 0, yy = 0;
    for (const BladePoint& p : points) {
        const double share = std::clamp((end - p.s_mm) / run, 0.0, 1.0);
        n += 1;
        x += share;
        xx += share * share;
        y += p.d_mm;
        xy += share * p.d_mm;
        yy += p.d_mm * p.d_mm;
    }
    const double vx = xx - x * x / n;
    const double vxy = xy - x * y / n;
    Wall wall{end, run, 0, 1e300};
    if (!(vx > 1e-3 * n)) return wall;
    wall.drop = vxy / vx;
    wall.squares = yy - y * y / n - vxy * vxy / vx;
    return wall;
}

Wall find_wall(const std::vector<BladePoint>& points, double from, double to) {
    Wall best;
    if (points.size() < 30) return best;
    auto scan = [&](double end_from, double end_to, double end_step, double run_from, double run_to,
                    double run_step) {
        for (double end = end_from; end <= end_to; end += end_step) {
            for (double run = std::max(run_from, 0.05); run <= run_to; run += run_step) {
                const Wall wall = fit_wall(points, end, run);
                if (wall.squares < best.squares) best = wall;
            }
        }
    };
    scan(from, to, 0.3, 0.1, 3.2, 0.3);
    for (double step = 0.1; step > 0.0005; step /= 3)
        scan(best.end - 3 * step, best.end + 3 * step, step, best.run - 3 * step,
             best.run + 3 * step, step);
    return best;
}

double square(double x) {
    return x * x;
}

// Of one value to the next, whatever smooth course they take.
double noise_of(const std::vector<double>& values) {
    std::vector<double> squares;
    for (std::size_t i = 2; i < values.size(); ++i) {
        const double bend = values[i - 2] - 2 * values[i - 1] + values[i];
        squares.push_back(bend * bend);
    }
    return std::max(1e-6, 1.4826 * std::sqrt(median(squares) / 6));
}

// Without those that lie far from the middle one of their neighbours.
void drop_strays(std::vector<double>& s, std::array<std::vector<double>, 2>& value) {
    std::vector<char> keep(s.size(), 1);
    for (const std::vector<double>& y : value) {
        const double limit = 5 * noise_of(y);
        const std::vector<double> middle = running_median(y, 3);
        for (std::size_t i = 0; i < y.size(); ++i) {
            if (std::abs(y[i] - middle[i]) > limit) keep[i] = 0;
        }
    }
    std::size_t n = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (keep[i] == 0) continue;
        s[n] = s[i];
        for (std::vector<double>& y : value) y[n] = y[i];
        ++n;
    }
    s.resize(n);
    for (std::vector<double>& y : value) y.resize(n);
}

// A course that may break at `at`: by how much a break betters the fit of what lies from `from` to
// `to`, in squares; the rest's squares; and the break's slope.
struct BreakFit {
    double gain = 0, squares = 1e300, turn = 0;
};

BreakFit fit_break(const std::vector<double>& s, const std::vector<double>& y, double at,
                   double from, double to) {
    constexpr double unit = 20;
    auto row = [&](double v) {
        const double x = (v - at) / unit;
        const double over = std::max(0.0, x);
        return std::array<double, 6>{1, x, x * x, over * over, over * over * over, over};
    };
    BreakFit result;
    std::array<double, 2> squares{};
    for (const bool breaks : {false, true}) {
        LeastSquares<6> system;
        std::size_t used = 0;
        for (std::size_t i = 0; i < s.size(); ++i) {
            if (s[i] < from || s[i] > to) continue;
            system.add(row(s[i]), y[i]);
            ++used;
        }
        if (!breaks) system.add({0, 0, 0, 0, 0, 1}, 0, 1e9);
        std::array<double, 6> x{};
        if (used < 14 || !system.solve(x)) return {};
        for (std::size_t i = 0; i < s.size(); ++i) {
            if (s[i] < from || s[i] > to) continue;
            double r = y[i];
            const std::array<double, 6> a = row(s[i]);
            for (std::size_t k = 0; k < 6; ++k) r -= a[k] * x[k];
            squares[breaks ? 1 : 0] += r * r;
        }
        result.turn = x[5] / unit;
    }
    result.gain = squares[0] - squares[1];
    result.squares = squares[1];
    return result;
}

// Where the mune line is as far from the tip as the user says.
void take_given_yokote(double kissaki_mm, BladeFit& fit) {
    if (!(kissaki_mm > 0)) return;
    const glm::dvec3 tip = fit.curve.at(fit.tip_s_mm);
    double s = fit.tip_s_mm - kissaki_mm;
    for (int i = 0; i < 8; ++i) s += glm::distance(fit.curve.at(s), tip) - kissaki_mm;
    const double most = fit.tip_s_mm - fit.machi_s_mm - 20;
    if (!(fit.tip_s_mm - s < most)) {
        throw InputError("scan", "kissaki_mm", std::to_string(kissaki_mm),
                         "below " + whole_number(most) + " mm, on this blade");
    }
    fit.yokote = true;
    fit.yokote_s_mm = s;
}

}  // namespace

void find_machi(std::span<const BladePoint> points, BladeFit& fit) {
    if (fit.given_machi) {
        fit.machi = true;
        fit.machi_s_mm = fit.curve.locate(*fit.given_machi).s_mm;
        return;
    }
    if (!fit.tang || points.empty()) return;
    const SectionGuess blade = fit.blade_guess.at(fit.machi_s_mm + 3);
    const double middle = fit.machi_s_mm;
    const double reach = fit.machi ? 5 : 8;
    // Up to the habaki, if there is one.
    double end = middle + reach;
    const double lean = fit.settled ? 1 : 4.5;  // of which so much was added to be sure
    for (const auto& [from, to] : fit.fittings_s) {
        if (to > middle && from > middle - reach) end = std::min(end, from + lean);
    }
    std::vector<BladePoint> back;
    for (const BladePoint& p : points) {
        if (p.s_mm < middle - reach || p.s_mm > end || p.d_mm < -0.35) continue;
        if (std::abs(p.y_mm) < 0.25 * blade.corner_y && p.d_mm < 0.3 * blade.edge_d)
            back.push_back(p);
    }
    const Wall wall = find_wall(back, middle - 0.7 * reach, middle + 0.7 * reach);
    fit.machi = wall.squares < 1e299 && wall.drop > 0.35;
    if (fit.machi) fit.machi_s_mm = wall.end;
}

void find_tip(std::span<const BladePoint> points, BladeFit& fit) {
    // The edge near the point runs across the sections: it is found by bands of equal depth, as the
    // line in which the two sides, fitted over the last millimetres before it, meet.
    if (points.empty()) return;
    const double width = fit.blade_guess.at(body_middle(fit)).edge_d;
    const double deepest = std::clamp(0.3 * width, 3.0, 8.0);
    constexpr double band_mm = 0.5;
    std::vector<double> s_of;
    std::vector<double> d_of;
    std::vector<double> ends;
    for (double d = 1.5; d < deepest; d += band_mm) {
        // Not so far back that the band leaves the ji for the shinogi-ji.
        const double reach_mm = fit.ridge ? std::min(3.5, 0.75 * d) : 3.5;
        ends.clear();
        for (const BladePoint& p : points) {
            if (std::abs(p.d_mm - d) < 0.5 * band_mm) ends.push_back(p.s_mm);
        }
        if (ends.size() < 8) continue;
        std::sort(ends.begin(), ends.end());
        const double end = ends[ends.size() - 1 - ends.size() / 100];
        std::array<LeastSquares<4>, 2> system;
        for (const BladePoint& p : points) {
            if (std::abs(p.d_mm - d) > band_mm || p.s_mm < end - reach_mm) continue;
            const double u = (p.s_mm - end) / reach_mm;
            system[p.omote ? 0 : 1].add({1, u, u * u, (p.d_mm - d) / band_mm},
                                        p.omote ? p.y_mm : -p.y_mm);
        }
        std::array<std::array<double, 4>, 2> side{};
        if (!system[0].solve(side[0]) || !system[1].solve(side[1])) continue;
        std::array<double, 3> sum{};
        for (std::size_t k = 0; k < 3; ++k) sum[k] = side[0][k] + side[1][k];
        double x = 0;
        bool falls = true;
        for (int i = 0; i < 10 && falls; ++i) {
            const double slope = sum[1] + 2 * sum[2] * x;
            falls = slope < -0.02;
            if (falls) x -= std::clamp((sum[0] + x * (sum[1] + x * sum[2])) / slope, -0.4, 0.4);
        }
        if (!falls || !(std::abs(x) < 0.6)) continue;
        s_of.push_back(end + x * reach_mm);
        d_of.push_back(d);
    }
    if (s_of.size() < 4) return;
    std::array<double, 3> best{};
    std::vector<char> kept(s_of.size(), 1);
    for (int pass = 0; pass < 2; ++pass) {
        LeastSquares<3> line;
        for (std::size_t i = 0; i < s_of.size(); ++i) {
            if (kept[i] != 0) line.add({1, d_of[i], d_of[i] * d_of[i]}, s_of[i]);
        }
        if (!line.solve(best)) return;
        std::vector<double> off;
        for (std::size_t i = 0; i < s_of.size(); ++i)
            off.push_back(std::abs(s_of[i] - best[0] - d_of[i] * (best[1] + d_of[i] * best[2])));
        std::vector<double> sorted = off;
        std::sort(sorted.begin(), sorted.end());
        const double cut = 4 * sorted[sorted.size() / 2] + 0.02;
        for (std::size_t i = 0; i < off.size(); ++i) kept[i] = off[i] < cut ? 1 : 0;
    }
    // Not where no point of the scan is.
    const double outermost = points[points.size() - std::min<std::size_t>(points.size(), 3)].s_mm;
    if (!(std::abs(best[0] - outermost) < 2)) {
        fit.tip_s_mm = outermost;
        fit.point_edge_to_d_mm = 0;
        return;
    }
    fit.point_edge = best;
    fit.point_edge_to_d_mm = d_of.back();
    fit.tip_s_mm = best[0];
}

void find_begin(std::span<const BladePoint> points, BladeFit& fit) {
    // The third-outermost point: one stray point is no end.
    if (points.size() < 3) return;
    fit.begin_s_mm = points[2].s_mm;
    if (!fit.tang && !fit.given_machi) fit.machi_s_mm = fit.begin_s_mm;
}

void find_nakago_length(std::span<const ScanPoint> points, BladeFit& fit) {
    fit.nakago_mm = 0;
    if (!fit.tang) return;
    const glm::dvec3 machi = fit.curve.at(fit.machi_s_mm);
    const double near_end = fit.curve.x_at(fit.begin_s_mm) + 12;
    std::array<double, 3> farthest{};
    for (const ScanPoint& p : points) {
        if (p.position_mm.x > near_end) continue;
        const double far = glm::distance(p.position_mm, machi);
        if (far <= farthest[0]) continue;
        farthest[0] = far;
        std::sort(farthest.begin(), farthest.end());
    }
    fit.nakago_mm = farthest[0];
}

void find_yokote(BladeFit& fit) {
    fit.yokote = false;
    fit.yokote_unsure = false;
    fit.yokote_s_mm = fit.tip_s_mm;
    if (fit.given_kissaki_mm) {
        take_given_yokote(*fit.given_kissaki_mm, fit);
        return;
    }
    if (!fit.ridge || !fit.point) return;
    const double width = fit.blade_guess.at(body_middle(fit)).edge_d;
    const double from = std::max(fit.machi_s_mm + 10, fit.tip_s_mm - 4.8 * width);
    const double to = fit.tip_s_mm - 5;
    // Two things break there: the shinogi's depth, and how far the ji bulges over its chord.
    std::vector<double> s_of;
    std::array<std::vector<double>, 2> value;
    for (const SectionFit& f : fit.blade) {
        if (!f.shinogi || !f.edge || f.s_mm < from || f.s_mm > to) continue;
        const double depth = 0.5 * (f.shinogi_d[0] + f.shinogi_d[1]);
        const double ji = f.edge_d - depth;
        s_of.push_back(f.s_mm);
        value[0].push_back(depth);
        value[1].push_back(-0.125 * ji * ji * (f.ji[0][2] + f.ji[1][2]));
    }
    if (s_of.size() < 24) return;
    drop_strays(s_of, value);
    if (s_of.size() < 24) return;
    const std::array<double, 2> weight{1 / square(noise_of(value[0])),
                                       1 / square(noise_of(value[1]))};
    auto both = [&](double at, double from_s, double to_s) {
        BreakFit sum{0, 0, 0};
        for (const std::size_t k : {0U, 1U}) {
            const BreakFit one = fit_break(s_of, value[k], at, from_s, to_s);
            // The shinogi turns to the mune there and the bulge falls; nothing else is a yokote.
            if (one.turn < 0) sum.gain += weight[k] * one.gain;
            sum.squares += weight[k] * one.squares;
        }
        return sum;
    };
    // Where a break betters its surroundings' fit most, then where it fits best.
    constexpr double before_mm = 35;
    auto behind = [&](double at) { return at + std::clamp(0.6 * (fit.tip_s_mm - at), 9.0, 30.0); };
    double best = 0;
    double most = 0;
    for (double s = fit.tip_s_mm - 3.6 * width; s < fit.tip_s_mm - 0.7 * width; s += 0.5) {
        const double gain = both(s, s - before_mm, behind(s)).gain;
        if (gain <= most) continue;
        most = gain;
        best = s;
    }
    // Facets move either slope about as much as they scatter the shinogi: with 20,000 triangles
    // (.02 mm) shobu-zukuri reach 4.2 of the 3.5 below, and o-kissaki stay at 1.8.
    const double doubtful = 100 * noise_of(value[0]);
    if (most < 150) {
        fit.yokote_unsure = doubtful > 3.5;
        return;
    }
    const double window_from = best - before_mm;
    const double window_to = behind(best);
    double least = 1e300;
    for (double step = 0.5; step > 0.002; step /= 3) {
        const double middle = best;
        for (int k = -6; k <= 6; ++k) {
            const double squares = both(middle + k * step, window_from, window_to).squares;
            if (squares >= least) continue;
            least = squares;
            best = middle + k * step;
        }
    }
    // A shobu-zukuri's shinogi bends too, but without a break, and its ji goes on as it was. Slopes
    // of generated blades' yokote: shinogi .055 to .2, bulge .005 to .018; of shobu-zukuri's at
    // most .073 with .0024, and .053 with .0035.
    const double shinogi_turn = fit_break(s_of, value[0], best, window_from, window_to).turn;
    const double bulge_turn = fit_break(s_of, value[1], best, window_from, window_to).turn;
    const double speaks = std::max(0.0, -shinogi_turn) / 0.03 + std::max(0.0, -bulge_turn) / 0.004;
    fit.yokote = speaks > 3.5;
    fit.yokote_unsure = std::abs(speaks - 3.5) < doubtful;
    if (fit.yokote) fit.yokote_s_mm = best;
}

double body_middle(const BladeFit& fit) {
    return 0.5 * (fit.machi_s_mm + fit.tip_s_mm);
}

}  // namespace togishi
