#include "blade/frame.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"

namespace togishi {

double BladeFrame::at(const std::vector<double>& curve, double s_mm) const {
    const double last = static_cast<double>(curve.size() - 1);
    const double x = std::clamp((s_mm + nakago_mm) / length_mm() * last, 0.0, last);
    const double whole = std::min(std::floor(x), last - 1);
    const auto i = static_cast<std::size_t>(whole);
    return curve[i] + (curve[i + 1] - curve[i]) * (x - whole);
}

double BladeFrame::chart_x_mm(double s_mm, double from_ridge_mm) const {
    const double beyond = from_ridge_mm - at(mune_mm, s_mm);
    return s_mm - at(beyond < 0 ? mune_skew : skew, s_mm) * beyond;
}

double BladeFrame::chart_y_mm(double s_mm, double from_ridge_mm) const {
    return from_ridge_mm + at(lift_mm, s_mm);
}

double BladeFrame::distance_to_edge_mm(double x_mm, double y_mm, double s_mm) const {
    const double last = static_cast<double>(edge_mm.size() - 1);
    const double step = length_mm() / last;
    // The edge line starts at the machi; inside the fukura's curve the distance has one minimum, so
    // walk down to it.
    const auto machi = static_cast<std::ptrdiff_t>(std::ceil(nakago_mm / step));
    const auto end = static_cast<std::ptrdiff_t>(edge_mm.size()) - 1;
    auto point_x = [&](std::ptrdiff_t i) {
        const auto k = static_cast<std::size_t>(i);
        return step * static_cast<double>(i) - nakago_mm - skew[k] * (edge_mm[k] - mune_mm[k]);
    };
    auto point_y = [&](std::ptrdiff_t i) {
        const auto k = static_cast<std::size_t>(i);
        return edge_mm[k] + lift_mm[k];
    };
    auto squared = [&](std::ptrdiff_t i) {
        const double dx = point_x(i) - x_mm;
        const double dy = point_y(i) - y_mm;
        return dx * dx + dy * dy;
    };
    auto to_segment = [&](std::ptrdiff_t i) {
        const double ax = point_x(i);
        const double ay = point_y(i);
        const double ex = point_x(i + 1) - ax;
        const double ey = point_y(i + 1) - ay;
        const double along =
            std::clamp(((x_mm - ax) * ex + (y_mm - ay) * ey) / (ex * ex + ey * ey), 0.0, 1.0);
        return std::hypot(ax + along * ex - x_mm, ay + along * ey - y_mm);
    };
    std::ptrdiff_t i =
        std::clamp(static_cast<std::ptrdiff_t>((s_mm + nakago_mm) / step), machi, end);
    double best = squared(i);
    const std::ptrdiff_t direction = i < end && squared(i + 1) < best ? 1 : -1;
    while (i + direction >= machi && i + direction <= end) {
        const double next = squared(i + direction);
        if (next >= best) break;
        best = next;
        i += direction;
    }
    double distance = std::sqrt(best);
    if (i > machi) distance = std::min(distance, to_segment(i - 1));
    if (i < end) distance = std::min(distance, to_segment(i));
    return distance;
}

ChartPoint BladeFrame::locate(double u, double v) const {
    u = std::clamp(u, 0.0, 1.0);
    v = std::clamp(v, 0.0, 1.0);
    ChartPoint p;
    p.omote = v < 0.5;
    const double y = std::abs(v - 0.5) * chart_height_mm;
    const double x = u * length_mm() - nakago_mm;
    // Skew and lift are small and change slowly: the fixed point gains two digits a step. Within
    // the open seam the ridge is the nearest.
    double s = x;
    auto from_ridge = [&] { return std::max(0.0, y - at(lift_mm, s)); };
    for (int i = 0; i < 6; ++i)
        s = std::clamp(x + (s - chart_x_mm(s, from_ridge())), -nakago_mm, nagasa_mm);
    const double t = from_ridge();
    p.s_mm = s;
    p.from_ridge_mm = t;
    p.part = part_at(s, t);
    const double edge = at(edge_mm, s);
    if (s < 0) {
        p.from_edge_mm = std::max(0.0, edge - t);
    } else if (t < edge) {
        p.from_edge_mm = distance_to_edge_mm(x, t + at(lift_mm, s), s);
    }
    return p;
}

Part BladeFrame::part_at(double s_mm, double from_ridge_mm) const {
    if (from_ridge_mm > at(edge_mm, s_mm)) return Part::other;
    if (s_mm < 0) return Part::nakago;
    if (from_ridge_mm <= at(mune_mm, s_mm)) return Part::mune;
    if (from_ridge_mm <= at(shinogi_mm, s_mm)) return Part::shinogi_ji;
    const bool kissaki = s_mm > yokote_s_mm;
    if (from_ridge_mm <= at(suguha_mm, s_mm)) return kissaki ? Part::kissaki : Part::ji;
    return kissaki ? Part::boshi : Part::ha;
}

void check_frame(const BladeFrame& frame, std::string_view where) {
    constexpr double most_mm = 1e5;
    constexpr std::size_t most_samples = 1000000;
    for (const auto& [name, member] : frame_lengths) {
        const double value = frame.*member;
        const bool length = name != "nakago_mm" && name != "yokote_s_mm";
        if (!(value >= (length ? 1e-3 : 0) && value <= most_mm)) {
            throw InputError(where, name, std::to_string(value),
                             length ? "0.001 to 100000 mm" : "0 to 100000 mm");
        }
    }
    const std::size_t samples = frame.edge_mm.size();
    if (samples < 2 || samples > most_samples)
        throw InputError(where, "edge_mm", std::to_string(samples) + " samples", "2 to 1000000");
    for (const auto& [name, member] : frame_curves) {
        const std::vector<double>& curve = frame.*member;
        if (curve.size() != samples) {
            throw InputError(where, name, std::to_string(curve.size()) + " samples",
                             std::to_string(samples) + ", as edge_mm has");
        }
        const auto wrong = std::find_if_not(curve.begin(), curve.end(),
                                            [](double x) { return x >= -most_mm && x <= most_mm; });
        if (wrong != curve.end())
            throw InputError(where, name, std::to_string(*wrong), "-100000 to 100000");
    }
}

}  // namespace togishi
