// The blade frame against brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "blade/katana_frame.hpp"

namespace togishi {
namespace {

double nearest_edge(const BladeFrame& f, double x, double t) {
    double best = 1e9;
    const double step = f.length_mm() / static_cast<double>(f.edge_mm.size() - 1);
    auto place = [&](std::size_t i) {
        return std::array{
            step * static_cast<double>(i) - f.nakago_mm - f.skew[i] * (f.edge_mm[i] - f.mune_mm[i]),
            f.edge_mm[i]};
    };
    for (std::size_t i = 0; i + 1 < f.edge_mm.size(); ++i) {
        if (step * static_cast<double>(i) < f.nakago_mm) continue;
        const auto [ax, at] = place(i);
        const auto [bx, bt] = place(i + 1);
        for (int k = 0; k <= 20; ++k) {
            best = std::min(best,
                            std::hypot(ax + (bx - ax) * k / 20 - x, at + (bt - at) * k / 20 - t));
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
                const double u = (x + f.nakago_mm) / f.length_mm();
                for (const double side : {-1.0, 1.0}) {
                    const ChartPoint p = f.locate(u, 0.5 + side * t / f.chart_height_mm);
                    EXPECT_NEAR(p.s_mm, s, 1e-6);
                    EXPECT_NEAR(p.from_ridge_mm, t, 1e-9);
                    EXPECT_NEAR(p.from_edge_mm, nearest_edge(f, x, t), 0.02)
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
            .locate((f.chart_x_mm(s, t) + f.nakago_mm) / f.length_mm(), 0.5 - t / f.chart_height_mm)
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
    EXPECT_EQ(f.edge_mm.size(), f.skew.size());
    EXPECT_EQ(f.edge_mm.size(), f.suguha_mm.size());
    EXPECT_NEAR(f.edge_mm.back(), 0, 1e-9);
    EXPECT_NEAR(f.nagasa_mm - f.yokote_s_mm, 33, 0.7);
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
