#include "scanned/section_fit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scanned/least_squares.hpp"

namespace togishi {
namespace {

// Least squares, then twice without what lies more than 3 deviations off.
template <std::size_t N, class Row>
bool fit_trimmed(std::span<const BladePoint> points, const Row& row, std::array<double, N>& x,
                 double& squares, std::size_t& count) {
    double cut = 1e300;
    for (int pass = 0; pass < 3; ++pass) {
        LeastSquares<N> system;
        std::size_t used = 0;
        std::array<double, N> a{};
        double value = 0;
        for (const BladePoint& p : points) {
            row(p, a, value);
            if (pass > 0) {
                double r = value;
                for (std::size_t i = 0; i < N; ++i) r -= a[i] * x[i];
                if (std::abs(r) > cut) continue;
            }
            system.add(a, value);
            ++used;
        }
        if (used < N + 4 || !system.solve(x)) return false;
        squares = 0;
        count = 0;
        for (const BladePoint& p : points) {
            row(p, a, value);
            double r = value;
            for (std::size_t i = 0; i < N; ++i) r -= a[i] * x[i];
            if (std::abs(r) > cut) continue;
            squares += r * r;
            ++count;
        }
        if (count < N + 4) return false;
        cut = 3 * std::sqrt(squares / static_cast<double>(count - N)) + 1e-9;
    }
    return true;
}

std::vector<BladePoint> mune_points(std::span<const BladePoint> points, const SectionGuess& g) {
    std::vector<BladePoint> chosen;
    const double wide = 0.86 * g.corner_y;
    const double deep = std::max(g.corner_d, g.top_d) + 0.25 * g.corner_y;
    for (const BladePoint& p : points) {
        if (std::abs(p.y_mm) < wide && p.d_mm < deep) chosen.push_back(p);
    }
    return chosen;
}

struct MuneFit {
    double top = 0, tilt = 0, height = 0;
    double squares = 0;
    std::size_t count = 0;
    bool good = false;
};

MuneFit fit_mune(std::span<const BladePoint> points, double s_mm, double half_mm,
                 const SectionGuess& g, const MuneKind& kind) {
    MuneFit fit;
    const double c = std::max(0.2, g.corner_y);
    const double steep = std::clamp((g.corner_d - g.top_d) / c, 0.02, 1.0);
    if (kind.type == MuneType::kaku) {
        std::array<double, 3> x{};
        fit.good = fit_trimmed<3>(
            points,
            [&](const BladePoint& p, std::array<double, 3>& a, double& v) {
                a = {1, p.y_mm / c, (p.s_mm - s_mm) / half_mm};
                v = p.d_mm;
            },
            x, fit.squares, fit.count);
        fit.top = x[0];
        fit.tilt = x[1] / c;
        return fit;
    }
    std::array<double, 4> x{};
    fit.good = fit_trimmed<4>(
        points,
        [&](const BladePoint& p, std::array<double, 4>& a, double& v) {
            a = {1, p.y_mm / c, mune_profile(kind.type, kind.flat_share, steep, p.y_mm / c),
                 (p.s_mm - s_mm) / half_mm};
            v = p.d_mm;
        },
        x, fit.squares, fit.count);
    fit.top = x[0];
    fit.tilt = x[1] / c;
    fit.height = x[2];
    return fit;
}

}  // namespace

double mune_profile(MuneType type, double share, double height_over_half, double eta) {
    const double e = std::abs(eta);
    switch (type) {
        case MuneType::iori:
            return e;
        case MuneType::mitsu:
            return e <= share ? 0 : (e - share) / (1 - share);
        case MuneType::maru: {
            const double h = std::clamp(height_over_half, 0.02, 1.0);
            const double radius = (1 + h * h) / (2 * h);
            return (radius - std::sqrt(std::max(0.0, radius * radius - e * e))) / h;
        }
        case MuneType::kaku:
            break;
    }
    return 0;
}

double SectionFit::half_thickness(int side, double d) const {
    const auto k = static_cast<std::size_t>(side);
    if (shinogi && d < shinogi_d[k]) return flat[k][0] + flat[k][1] * d;
    return half_thickness_ji(side, d);
}

double SectionFit::half_thickness_ji(int side, double d) const {
    const auto k = static_cast<std::size_t>(side);
    const double x = d - ji_d;
    return ji[k][0] + x * (ji[k][1] + x * ji[k][2]);
}

MuneMisfit mune_misfit(std::span<const BladePoint> points, double s_mm, double half_mm,
                       const SectionGuess& guess, const MuneKind& mune) {
    const MuneFit fit = fit_mune(mune_points(points, guess), s_mm, half_mm, guess, mune);
    if (!fit.good) return {};
    return {fit.squares, static_cast<double>(fit.count), fit.height};
}

SectionFit fit_section(std::span<const BladePoint> points, double s_mm, double half_mm,
                       const SectionGuess& g, const MuneKind& kind) {
    SectionFit f;
    f.s_mm = s_mm;
    f.points = points.size();
    const double width = g.edge_d - g.top_d;
    const bool ridge = g.shinogi_d > g.corner_d + 0.1 * width;
    const double room = std::min(0.5, 0.05 * width);  // kept off the lines
    const double foot = g.blunt ? std::max(1.2, 0.5 * g.corner_y) : 0;
    const double split = ridge ? g.shinogi_d : g.corner_d;
    f.ji_d = 0.5 * (split + g.edge_d);

    std::array<std::vector<BladePoint>, 2> flat;
    std::array<std::vector<BladePoint>, 2> ji;
    for (const BladePoint& p : points) {
        // Within the mune's width above its corners nothing belongs to the sides.
        if (p.d_mm < g.corner_d + 0.6 * room) continue;
        const std::size_t side = p.omote ? 0 : 1;
        if (ridge && p.d_mm < g.shinogi_d - room) flat[side].push_back(p);
        if (p.d_mm > split + room && p.d_mm < g.edge_d - 0.7 * room - foot) ji[side].push_back(p);
    }
    double squares = 0;
    double weight = 0;
    auto count_in = [&](double s, std::size_t n, std::size_t unknowns) {
        squares += s;
        weight += static_cast<double>(n - unknowns);
    };
    f.sides = true;
    for (const std::size_t k : {0U, 1U}) {
        const double out = k == 0 ? 1 : -1;
        double sum = 0;
        std::size_t n = 0;
        std::array<double, 4> b{};
        const double scale = std::max(0.5, 0.5 * (g.edge_d - split));
        const bool good = fit_trimmed<4>(
            ji[k],
            [&](const BladePoint& p, std::array<double, 4>& a, double& v) {
                const double x = (p.d_mm - f.ji_d) / scale;
                a = {1, x, x * x, (p.s_mm - s_mm) / half_mm};
                v = out * p.y_mm;
            },
            b, sum, n);
        if (!good) {
            f.sides = false;
            continue;
        }
        f.ji[k] = {b[0], b[1] / scale, b[2] / (scale * scale)};
        count_in(sum, n, 4);
        if (!ridge) {
            f.flat[k] = {f.ji[k][0] - f.ji[k][1] * f.ji_d + f.ji[k][2] * f.ji_d * f.ji_d,
                         f.ji[k][1] - 2 * f.ji[k][2] * f.ji_d};
            continue;
        }
        std::array<double, 3> a3{};
        const double middle = 0.5 * (g.corner_d + g.shinogi_d);
        const bool even = fit_trimmed<3>(
            flat[k],
            [&](const BladePoint& p, std::array<double, 3>& a, double& v) {
                a = {1, (p.d_mm - middle) / scale, (p.s_mm - s_mm) / half_mm};
                v = out * p.y_mm;
            },
            a3, sum, n);
        if (!even) {
            f.sides = false;
            continue;
        }
        count_in(sum, n, 3);
        f.flat[k] = {a3[0] - a3[1] / scale * middle, a3[1] / scale};
    }
    if (weight > 0) f.residual = std::sqrt(squares / weight);
    if (!f.sides) return f;

    if (ridge) {
        // Where the ji's parabola and the shinogi-ji's line meet.
        f.shinogi = true;
        for (const std::size_t k : {0U, 1U}) {
            double d = g.shinogi_d;
            for (int i = 0; i < 12; ++i) {
                const double x = d - f.ji_d;
                const double gap = f.ji[k][0] + x * (f.ji[k][1] + x * f.ji[k][2]) - f.flat[k][0] -
                                   f.flat[k][1] * d;
                const double slope = f.ji[k][1] + 2 * x * f.ji[k][2] - f.flat[k][1];
                if (!(std::abs(slope) > 1e-3)) break;
                d -= std::clamp(gap / slope, -1.0, 1.0);
            }
            f.shinogi_d[k] = d;
            f.shinogi_y[k] = f.flat[k][0] + f.flat[k][1] * d;
            if (!(std::abs(d - g.shinogi_d) < 0.25 * width)) f.shinogi = false;
        }
    }
    if (!g.blunt) {
        // Where the two sides meet.
        std::array<double, 3> sum{};
        for (std::size_t i = 0; i < 3; ++i) sum[i] = f.ji[0][i] + f.ji[1][i];
        double x = g.edge_d - f.ji_d;
        bool falls = true;
        for (int i = 0; i < 12; ++i) {
            const double slope = sum[1] + 2 * sum[2] * x;
            falls = slope < -0.02;
            if (!falls) break;
            x -= std::clamp((sum[0] + x * (sum[1] + x * sum[2])) / slope, -1.0, 1.0);
        }
        f.edge_d = f.ji_d + x;
        f.edge_y = f.ji[0][0] + x * (f.ji[0][1] + x * f.ji[0][2]);
        f.edge = falls && std::abs(f.edge_d - g.edge_d) < std::max(2.0, 0.15 * width);
    }

    const MuneFit mune = fit_mune(mune_points(points, g), s_mm, half_mm, g, kind);
    if (!mune.good) return f;
    f.mune = true;
    count_in(mune.squares, mune.count, 4);
    f.residual = std::sqrt(squares / weight);
    f.mune_height = mune.height;
    const double c = std::max(0.2, g.corner_y);
    const double steep = std::clamp(mune.height / c, 0.0, 1.0);
    for (const std::size_t k : {0U, 1U}) {
        const double out = k == 0 ? 1 : -1;
        double y = g.corner_y;
        double d = g.corner_d;
        for (int i = 0; i < 20; ++i) {
            d = mune.top + mune.tilt * out * y +
                mune.height * mune_profile(kind.type, kind.flat_share, steep, y / c);
            y = f.flat[k][0] + f.flat[k][1] * d;
        }
        f.corner_y[k] = y;
        f.corner_d[k] = d;
    }
    f.middle_y = 0.5 * (f.corner_y[0] - f.corner_y[1]);
    // The ridge lies in the middle plane, which the fit's y = 0 need not.
    f.top_d = mune.top + mune.tilt * f.middle_y;
    if (kind.type == MuneType::iori) f.top_d += mune.height / c * std::abs(f.middle_y);
    f.mune_height = 0.5 * (f.corner_d[0] + f.corner_d[1]) - f.top_d;
    return f;
}

}  // namespace togishi
