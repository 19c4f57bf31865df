#include "scanned/fit_stations.hpp"

#include <algorithm>
#include <cmath>

namespace togishi {
namespace {

constexpr int mune_steps = 12, shinogi_steps = 10, ji_steps = 36;
// Between cross-sections farther apart the blade was not seen.
constexpr double longest_bridge_mm = 9;

// One side of a cross-section by its corners, straight between two sections.
struct SideShape {
    double corner_y = 0, corner_d = 0, shinogi_y = 0, shinogi_d = 0;
    double bulge = 0;  // of the ji over the chord from shinogi to edge, at its middle
};
struct Shape {
    double s_mm = 0;
    double top_d = 0, edge_d = 0;
    double top_y = 0, edge_y = 0;  // of the middle plane
    double foot_y = 0;             // half thickness where the edge side ends; 0 on the blade
    std::array<SideShape, 2> side;
};

Shape blend(const Shape& a, const Shape& b, double f) {
    Shape r;
    auto mix = [&](auto member) { r.*member = std::lerp(a.*member, b.*member, f); };
    for (auto m : {&Shape::s_mm, &Shape::top_d, &Shape::edge_d, &Shape::top_y, &Shape::edge_y,
                   &Shape::foot_y})
        mix(m);
    for (const std::size_t k : {0U, 1U}) {
        for (auto m : {&SideShape::corner_y, &SideShape::corner_d, &SideShape::shinogi_y,
                       &SideShape::shinogi_d, &SideShape::bulge})
            r.side[k].*m = std::lerp(a.side[k].*m, b.side[k].*m, f);
    }
    return r;
}

// Everything nearer to a depth, for the point and the nakago's end.
Shape shrunk(const Shape& from, double s_mm, double top_d, double edge_d, bool thinner) {
    const double f = (edge_d - top_d) / std::max(1e-9, from.edge_d - from.top_d);
    Shape r = from;
    r.s_mm = s_mm;
    r.top_d = top_d;
    r.edge_d = edge_d;
    for (SideShape& side : r.side) {
        side.corner_d = top_d + f * (side.corner_d - from.top_d);
        side.shinogi_d = top_d + f * (side.shinogi_d - from.top_d);
        if (!thinner) continue;
        side.corner_y *= f;
        side.shinogi_y *= f;
        side.bulge *= f;
    }
    if (thinner) r.foot_y *= f;
    return r;
}

Shape shape_of(const SectionFit& f, bool ridge, bool blunt) {
    Shape shape;
    shape.s_mm = f.s_mm;
    shape.top_d = f.top_d;
    shape.edge_d = f.edge_d;
    shape.top_y = f.middle_y;
    const double foot_d = f.edge_d - 0.8;
    shape.edge_y =
        blunt ? 0.5 * (f.half_thickness_ji(0, foot_d) - f.half_thickness_ji(1, foot_d)) : f.edge_y;
    if (blunt)
        shape.foot_y =
            std::max(0.0, 0.5 * (f.half_thickness_ji(0, foot_d) + f.half_thickness_ji(1, foot_d)));
    for (const std::size_t k : {0U, 1U}) {
        SideShape& side = shape.side[k];
        const bool has_ridge = ridge && f.shinogi;
        side.corner_y = f.corner_y[k];
        side.corner_d = f.corner_d[k];
        side.shinogi_y = has_ridge ? f.shinogi_y[k] : f.corner_y[k];
        side.shinogi_d = has_ridge ? f.shinogi_d[k] : f.corner_d[k];
        const double half = 0.5 * (f.edge_d - side.shinogi_d);
        side.bulge = -f.ji[k][2] * half * half;
    }
    return shape;
}

// Only what every part of was found, and nothing that its neighbours do not know.
std::vector<Shape> shapes_of(const std::vector<SectionFit>& fits, bool ridge, bool blunt) {
    std::vector<Shape> shapes;
    for (const SectionFit& f : fits) {
        if (!f.mune || !f.sides || (ridge && !f.shinogi)) continue;
        if (blunt ? !(f.edge_d > f.top_d + 2) : !f.edge) continue;
        const Shape shape = shape_of(f, ridge, blunt);
        bool good = true;
        for (const SideShape& side : shape.side) {
            good = good && side.corner_y > 0 && side.corner_d > shape.top_d - 0.5 &&
                   side.shinogi_d >= side.corner_d && shape.edge_d > side.shinogi_d;
        }
        if (good) shapes.push_back(shape);
    }
    return shapes;
}

// Under a habaki nothing is seen from the machi on: the shape there is the first one that is, grown
// as the blade's lines run on to the machi.
void carry_on_to_machi(const BladeFit& fit, std::vector<Shape>& blade) {
    const BladeLines& lines = fit.lines;
    Shape shape = blade.front();
    if (shape.s_mm - fit.machi_s_mm < longest_bridge_mm) return;
    auto grown = [&](const auto& line) { return line.at(fit.machi_s_mm) - line.at(shape.s_mm); };
    const double top = grown(lines.top_d);
    const double edge = grown(lines.edge_d);
    const double corner_y = grown(lines.corner_y);
    const double corner_d = grown(lines.corner_d);
    const double shinogi_y = fit.ridge ? grown(lines.shinogi_y) : corner_y;
    const double shinogi_d = fit.ridge ? grown(lines.shinogi_d) : corner_d;
    for (SideShape& side : shape.side) {
        side.corner_y += corner_y;
        side.corner_d += corner_d;
        side.shinogi_y += shinogi_y;
        side.shinogi_d += shinogi_d;
    }
    shape.top_d += top;
    shape.edge_d += edge;
    shape.s_mm = fit.machi_s_mm;
    blade.insert(blade.begin(), shape);
}

Shape shape_at(const std::vector<Shape>& shapes, double s, double& gap) {
    const auto after = static_cast<std::size_t>(
        std::lower_bound(shapes.begin(), shapes.end(), s,
                         [](const Shape& shape, double v) { return shape.s_mm < v; }) -
        shapes.begin());
    gap = 0;
    if (after == 0 || after == shapes.size()) {
        Shape shape = after == 0 ? shapes.front() : shapes.back();
        shape.s_mm = s;
        return shape;
    }
    const Shape& a = shapes[after - 1];
    const Shape& b = shapes[after];
    gap = b.s_mm - a.s_mm;
    return blend(a, b, (s - a.s_mm) / std::max(1e-9, gap));
}

SectionSide side_of(const Shape& shape, std::size_t k, const MuneKind& mune) {
    SectionSide result;
    const SideShape& side = shape.side[k];
    const double out = k == 0 ? 1 : -1;
    // Outwards from the plane through mune and edge.
    auto middle = [&](double d) {
        const double f = (d - shape.top_d) / std::max(1e-9, shape.edge_d - shape.top_d);
        return out * (shape.top_y + f * (shape.edge_y - shape.top_y));
    };
    std::vector<glm::dvec2>& line = result.outline_mm;
    double t = 0;
    auto add = [&](double d, double y) {
        const glm::dvec2 p(d, std::max(0.0, y));
        if (!line.empty()) t += glm::distance(line.back(), p);
        line.push_back(p);
    };
    const double corner_y = side.corner_y - middle(side.corner_d);
    const double height = side.corner_d - shape.top_d;
    const double steep = std::clamp(height / std::max(0.1, corner_y), 0.0, 1.0);
    for (int i = 0; i <= mune_steps; ++i) {
        const double eta = static_cast<double>(i) / mune_steps;
        add(shape.top_d + height * mune_profile(mune.type, mune.flat_share, steep, eta),
            eta * corner_y);
    }
    if (mune.type == MuneType::kaku && height > 0) add(side.corner_d, corner_y);
    result.mune_t_mm = t;
    const double shinogi_y = side.shinogi_y - middle(side.shinogi_d);
    if (side.shinogi_d > side.corner_d) {
        for (int i = 1; i <= shinogi_steps; ++i) {
            const double f = static_cast<double>(i) / shinogi_steps;
            add(std::lerp(side.corner_d, side.shinogi_d, f), std::lerp(corner_y, shinogi_y, f));
        }
    }
    result.shinogi_t_mm = t;
    const double end_d = shape.foot_y > 0
                             ? std::max(side.shinogi_d, shape.edge_d - 0.35 * shape.foot_y)
                             : shape.edge_d;
    for (int i = 1; i <= ji_steps; ++i) {
        const double f = static_cast<double>(i) / ji_steps;
        add(std::lerp(side.shinogi_d, end_d, f),
            std::lerp(shinogi_y, shape.foot_y, f) + 4 * side.bulge * f * (1 - f));
    }
    if (shape.foot_y > 0) {
        for (int i = 1; i <= 4; ++i)
            add(std::lerp(end_d, shape.edge_d, 0.25 * i), shape.foot_y * (1 - 0.25 * i));
    }
    result.edge_t_mm = t;
    return result;
}

// Depth of the point's edge at an arc length.
double point_edge_d(const BladeFit& fit, double s) {
    const auto& [a, b, c] = fit.point_edge;
    const double before = a - s;  // = -b d - c d^2
    if (!(before > 0)) return 0;
    const double root = b * b - 4 * c * before;
    if (std::abs(c) < 1e-9 || !(root > 0)) return b < 0 ? -before / b : 0;
    return 2 * before / (-b + std::sqrt(root));
}

}  // namespace

BladePose pose_of_fit(const BladeFit& fit) {
    const glm::dvec3 machi = fit.curve.at(fit.machi_s_mm);
    const glm::dvec3 x = glm::normalize(fit.curve.at(fit.tip_s_mm) - machi);
    const glm::dvec3 y = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), x));
    return {glm::transpose(glm::dmat3(x, y, glm::cross(x, y))), machi};
}

ScannedStations stations_of_fit(const BladeFit& fit, std::span<const ScanPoint> points,
                                double step_mm) {
    ScannedStations result;
    std::vector<Shape> blade = shapes_of(fit.blade, fit.ridge, false);
    const std::vector<Shape> nakago = shapes_of(fit.nakago, fit.ridge, true);
    if (blade.size() < 4) return result;
    carry_on_to_machi(fit, blade);
    const bool tang = fit.tang && nakago.size() >= 3;
    result.nakago_mm = tang ? fit.machi_s_mm - fit.begin_s_mm : 0;
    result.nagasa_arc_mm = fit.tip_s_mm - fit.machi_s_mm;
    result.yokote_s_mm = fit.yokote ? fit.yokote_s_mm - fit.machi_s_mm : result.nagasa_arc_mm;
    const double length = result.nakago_mm + result.nagasa_arc_mm;
    const double count = std::ceil(length / step_mm);
    result.step_mm = length / count;
    const BladePose pose = pose_of_fit(fit);

    // The nakago's end: how far it reaches up and down.
    struct Reach {
        double top_d = 1e300, edge_d = -1e300;
    };
    const double end_to = tang ? nakago.front().s_mm : fit.begin_s_mm;
    std::vector<Reach> reach(
        static_cast<std::size_t>(std::max(0.0, end_to - fit.begin_s_mm) / result.step_mm) + 2);
    if (tang) {
        for (const ScanPoint& p : points) {
            if (p.position_mm.x > fit.curve.x_at(end_to) + 6) continue;
            const BladePoint at = fit.curve.locate(p.position_mm);
            if (at.s_mm < fit.begin_s_mm - 0.2) continue;
            const auto k = static_cast<std::size_t>(
                std::lround(std::max(0.0, at.s_mm - fit.begin_s_mm) / result.step_mm));
            if (k >= reach.size()) continue;
            reach[k].top_d = std::min(reach[k].top_d, at.d_mm);
            reach[k].edge_d = std::max(reach[k].edge_d, at.d_mm);
        }
    }
    const Shape& last = blade.back();
    const double last_edge = last.edge_d;
    const double last_by_point = std::max(1e-6, point_edge_d(fit, last.s_mm));
    for (int i = 0; i <= static_cast<int>(count); ++i) {
        const double s = fit.tip_s_mm - length + length * i / count;
        Station station;
        station.s_mm = s - fit.machi_s_mm;
        double gap = 0;
        Shape shape;
        if (station.s_mm < -1e-9 && tang) {
            shape = shape_at(nakago, s, gap);
            if (s < end_to) {
                const auto k = static_cast<std::size_t>(i);
                if (k < reach.size() && reach[k].edge_d > reach[k].top_d)
                    shape = shrunk(nakago.front(), s, reach[k].top_d, reach[k].edge_d, false);
                else
                    station.measured = false;
            }
        } else if (s > last.s_mm) {
            // In the point's last millimetres a cross-section is hardly larger than the noise: it
            // shrinks as its edge comes up to the mune line.
            double share = (fit.tip_s_mm - s) / std::max(1e-6, fit.tip_s_mm - last.s_mm);
            if (fit.point_edge_to_d_mm > 0)
                share = std::clamp(point_edge_d(fit, s) / last_by_point, 0.0, 1.0);
            share = std::max(share, 1e-6);  // a section of no size has no outline
            shape = shrunk(last, s, last.top_d * share, last_edge * share, true);
            shape.top_y *= share;
            shape.edge_y *= share;
        } else {
            shape = shape_at(blade, s, gap);
        }
        if (gap > longest_bridge_mm) station.measured = false;
        station.ridge_mm = pose.rotation * (fit.curve.at(s) - pose.origin_mm);
        station.along = pose.rotation * fit.curve.along(s);
        station.across = pose.rotation * fit.curve.across(s);
        for (const std::size_t k : {0U, 1U}) station.side[k] = side_of(shape, k, fit.mune);
        result.stations.push_back(std::move(station));
    }
    return result;
}

}  // namespace togishi
