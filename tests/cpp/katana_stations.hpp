// The cross-sections of a generated katana, as a perfect scan would have them.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "blade/katana_mesh.hpp"
#include "blade/katana_shape.hpp"
#include "scanned/chart.hpp"
#include "scanned/stations.hpp"

namespace togishi {

inline ScannedStations katana_stations(const KatanaShape& shape, double step_mm = 0.5,
                                       bool with_tang = true) {
    const MuneLine& line = shape.mune_line();
    ScannedStations result;
    result.nagasa_arc_mm = line.blade_arc_mm();
    result.nakago_mm = with_tang ? line.nakago_arc_mm() : 0;
    result.yokote_s_mm =
        shape.has_yokote() ? shape.range(Stretch::kissaki)[0] : result.nagasa_arc_mm;
    const double length = result.nakago_mm + result.nagasa_arc_mm;
    const double count = std::round(length / step_mm);
    result.step_mm = length / count;
    const double jiri_start = shape.range(Stretch::nakago)[0];
    for (int i = 0; i <= static_cast<int>(count); ++i) {
        const double arc = -result.nakago_mm + length * i / count;
        Stretch stretch = Stretch::blade;
        double q = std::min(arc, line.blade_arc_mm() - 1e-9);
        if (arc >= shape.range(Stretch::kissaki)[0]) {
            stretch = Stretch::kissaki;
        } else if (arc < jiri_start) {
            stretch = Stretch::jiri;
            const double share = (arc + line.nakago_arc_mm()) / (jiri_start + line.nakago_arc_mm());
            q = std::acos(std::clamp(1 - share, 0.0, 1.0));
        } else if (arc < shape.range(Stretch::machi)[0]) {
            stretch = Stretch::nakago;
        } else if (arc < 0) {
            stretch = Stretch::machi;
        }
        const KatanaShape::Row row = shape.row(stretch, q);
        Station s;
        s.s_mm = arc;
        s.ridge_mm = {row.line.position_mm.x, 0, row.line.position_mm.y};
        s.along = {row.line.tangent.x, 0, row.line.tangent.y};
        s.across = {row.line.tangent.y, 0, -row.line.tangent.x};
        SectionSide side;
        double t = 0;
        for (const Strip strip : strips) {
            if (shape.has(strip, stretch)) {
                const int cells = strip == Strip::ji || strip == Strip::ha ? 40 : 12;
                for (int k = 0; k <= cells; ++k) {
                    Dual y;
                    Dual d;
                    KatanaShape::point_in_strip(row.section, strip, row.mune,
                                                Dual(static_cast<double>(k) / cells), y, d);
                    side.outline_mm.emplace_back(d.v, y.v);
                }
                t += KatanaShape::developed_mm(row.section, strip, row.mune, 1);
            }
            if (strip == Strip::mune_side) side.mune_t_mm = t;
            if (strip == Strip::shinogi_ji) side.shinogi_t_mm = t;
        }
        side.edge_t_mm = t;
        s.side = {side, side};
        result.stations.push_back(s);
    }
    return result;
}

/// The katana's surface with the scanned chart's places.
inline BladeMesh on_chart(const KatanaMesh& katana, const ScannedChart& chart) {
    BladeMesh mesh = katana;
    mesh.frame = chart.frame();
    for (std::size_t f = 0; f < katana.face_count(); ++f) {
        const auto a = static_cast<std::size_t>(katana.face_start[f]);
        const auto b = static_cast<std::size_t>(katana.face_start[f + 1]);
        float v = 0;
        for (std::size_t c = a; c < b; ++c) v += katana.corner_uv[c].y / static_cast<float>(b - a);
        for (std::size_t c = a; c < b; ++c) {
            const ChartPlace place =
                chart.place(katana.positions_mm[static_cast<std::size_t>(katana.corner_vertex[c])]);
            mesh.corner_uv[c] = chart.uv(place.s_mm, place.t_mm, v < 0.5F);
        }
    }
    return mesh;
}

}  // namespace togishi
