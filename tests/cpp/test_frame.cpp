// The blade frame against brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "blade/katana_frame.hpp"

namespace togishi {
namespace {

double nearest_edge(const BladeFrame& f, double x, double y) {
    double best = 1e9;
    const double step = f.length_mm() / static_cast<double>(f.edge_mm.size() - 1);
    auto place = [&](std::size_t i) {
        return std::array{
            step * static_cast<double>(i) - f.nakago_mm - f.skew[i] * (f.edge_mm[i] - f.mune_mm[i]),
            f.edge_mm[i] + f.lift_mm[i]};
    };
    for (std::size_t i = 0; i + 1 < f.edge_mm.size(); ++i) {
        if (step * static_cast<double>(i) < f.nakago_mm) continue;
        const auto [ax, ay] = place(i);
        const auto [bx, by] = place(i + 1);
        for (int k = 0; k <= 20; ++k) {
            best = std::min(best,
                            std::hypot(ax + (bx - ax) * k / 20 - x, ay + (by - ay) * k / 20 - y));
        }
    }
    return best;
}

TEST(BladeFrame, DistanceToTheEdgeIsTheShortest) {
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"}) {
        const BladeFrame f = make_blade_frame(katana_defaults(zukuri));
        for (double s = 0.5; s < f.nagasa_mm; s += 5.7) {
            for (const double share : {0.02, 0.3, 0.6, 0.95}) {
                const double t = share * f.at(f.edge_mm, s);
                const double x = f.chart_x_mm(s, t);
                const double y = f.chart_y_mm(s, t);
                const double u = (x + f.nakago_mm) / f.length_mm();
                for (const double side : {-1.0, 1.0}) {
                    const ChartPoint p = f.locate(u, 0.5 + side * y / f.chart_height_mm);
                    EXPECT_NEAR(p.s_mm, s, 1e-6);
                    EXPECT_NEAR(p.from_ridge_mm, t, 1e-6);
                    EXPECT_NEAR(p.from_edge_mm, nearest_edge(f, x, y), 0.02)
                        << zukuri << " s " << s << " t " << t;
                    EXPECT_EQ(p.omote, side < 0);
                    EXPECT_NE(p.part, Part::other);
                }
            }
        }
    }
}

TEST(BladeFrame, PartsLieWhereTheyShould) {
    const BladeFrame f = make_blade_frame(KatanaParameters{});
    auto part = [&](double s, double t) {
        return f
            .locate((f.chart_x_mm(s, t) + f.nakago_mm) / f.length_mm(),
                    0.5 - f.chart_y_mm(s, t) / f.chart_height_mm)
            .part;
    };
    EXPECT_EQ(part(300, 0.5), Part::mune);
    EXPECT_EQ(part(300, 6), Part::shinogi_ji);
    EXPECT_EQ(part(300, 15), Part::ji);
    EXPECT_EQ(part(300, f.at(f.edge_mm, 300) - 1), Part::ha);
    EXPECT_EQ(part(300, f.at(f.edge_mm, 300) + 0.3), Part::other);
    EXPECT_EQ(part(-50, 12), Part::nakago);
    EXPECT_EQ(part(f.yokote_s_mm + 5, 12), Part::kissaki);
    EXPECT_EQ(part(f.yokote_s_mm + 5, f.at(f.edge_mm, f.yokote_s_mm + 5) - 0.5), Part::boshi);
    for (const auto* curve : {&f.skew, &f.mune_skew, &f.lift_mm})
        EXPECT_EQ(f.edge_mm.size(), curve->size());
    EXPECT_EQ(f.edge_mm.size(), f.suguha_mm.size());
    EXPECT_NEAR(f.edge_mm.back(), 0, 1e-9);
    EXPECT_NEAR(f.nagasa_mm - f.yokote_s_mm, 33, 0.7);
}

TEST(BladeFrame, TheRidgeOpensInTheKissakiOnly) {
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"}) {
        KatanaParameters p = katana_defaults(zukuri);
        p.mune = MuneType::kaku;
        const BladeFrame f = make_blade_frame(p);
        for (double s = -f.nakago_mm; s < f.nagasa_mm - 1.2 * p.kissaki_mm; s += 1.0)
            EXPECT_EQ(f.at(f.lift_mm, s), 0.0) << zukuri << " " << s;
        // By no more than the mune is wide: its corner keeps about its place in the chart.
        EXPECT_GT(f.lift_mm.back(), 0.5);
        EXPECT_LT(f.lift_mm.back(), f.at(f.mune_mm, f.nagasa_mm - p.kissaki_mm));
        EXPECT_TRUE(std::is_sorted(f.lift_mm.begin(), f.lift_mm.end()));
        // Inside the open seam lies the ridge of either side.
        const double s = f.nagasa_mm - 3;
        const double u = (f.chart_x_mm(s, 0) + f.nakago_mm) / f.length_mm();
        for (const double side : {-1.0, 1.0}) {
            const double inside = 0.3 * f.at(f.lift_mm, s) / f.chart_height_mm;
            const ChartPoint at = f.locate(u, 0.5 + side * inside);
            EXPECT_EQ(at.from_ridge_mm, 0.0);
            EXPECT_EQ(at.part, Part::mune);
            EXPECT_EQ(at.omote, side < 0);
            EXPECT_NEAR(at.s_mm, s, 1e-6);
        }
    }
}

TEST(BladeFrame, OutsideTakesTheNearestPoint) {
    const BladeFrame f = make_blade_frame(KatanaParameters{});
    for (const double u : {-5.0, 0.0, 0.4, 1.0, 7.0}) {
        for (const double v : {-3.0, 0.0, 0.5, 1.0, 9.0}) {
            const ChartPoint p = f.locate(u, v);
            EXPECT_TRUE(std::isfinite(p.s_mm + p.from_edge_mm + p.from_ridge_mm));
            EXPECT_GE(p.from_edge_mm, 0);
            EXPECT_GE(p.s_mm, -f.nakago_mm);
            EXPECT_LE(p.s_mm, f.nagasa_mm);
        }
    }
}

TEST(BladeFrame, WithoutYokoteThereIsNoKissaki) {
    const BladeFrame f = make_blade_frame(katana_defaults("hira"));
    EXPECT_EQ(f.yokote_s_mm, f.nagasa_mm);
    for (std::size_t i = 0; i < f.mune_mm.size(); ++i) EXPECT_EQ(f.mune_mm[i], f.shinogi_mm[i]);
}

}  // namespace
}  // namespace togishi
