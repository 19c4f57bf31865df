// A scanned blade's chart against the generated katana's own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/error.hpp"
#include "blade/katana_mesh.hpp"
#include "katana_stations.hpp"
#include "scanned/chart.hpp"
#include "steel/steel_pattern.hpp"

namespace togishi {
namespace {

struct Charted {
    BladeMesh mesh;       // the katana's, with the scanned chart
    double worst_mm = 0;  // between the two charts, machi to tip
    double off_mm = 0;    // from the outline, machi to tip
};

Charted charted(const KatanaMesh& katana, const ScannedChart& chart) {
    Charted result{on_chart(katana, chart), 0, 0};
    auto from_machi = [](const BladeFrame& frame, const glm::dvec2& at) {
        return glm::dvec2(at.x * frame.length_mm() - frame.nakago_mm,
                          (at.y - 0.5) * frame.chart_height_mm);
    };
    for (std::size_t f = 0; f < katana.face_count(); ++f) {
        if (katana.face_part[f] == Part::nakago) continue;
        for (auto c = static_cast<std::size_t>(katana.face_start[f]);
             c < static_cast<std::size_t>(katana.face_start[f + 1]); ++c) {
            result.worst_mm = std::max(
                result.worst_mm, glm::distance(from_machi(chart.frame(), result.mesh.corner_uv[c]),
                                               from_machi(katana.frame, katana.corner_uv[c])));
            const auto v = static_cast<std::size_t>(katana.corner_vertex[c]);
            result.off_mm =
                std::max(result.off_mm, std::abs(chart.place(katana.positions_mm[v]).off_mm));
        }
    }
    return result;
}

TEST(ScannedChart, PlacesOfTheSurfaceAreFoundAgain) {
    for (const std::string_view zukuri : {"shinogi", "hira"}) {
        const ScannedChart chart(katana_stations(KatanaShape(katana_defaults(zukuri)), 1.0));
        const BladeFrame& frame = chart.frame();
        for (double s = 5 - frame.nakago_mm; s < frame.nagasa_mm - 2; s += 7.3) {
            for (const double share : {0.05, 0.3, 0.6, 0.95}) {
                for (const bool omote : {true, false}) {
                    const double t = share * frame.at(frame.edge_mm, s);
                    const ChartPlace place = chart.place(chart.point(s, t, omote));
                    EXPECT_NEAR(place.s_mm, s, 1e-4) << zukuri << " " << share;
                    EXPECT_NEAR(place.t_mm, t, 1e-3) << zukuri << " " << s;
                    EXPECT_NEAR(place.off_mm, 0, 1e-4) << zukuri << " " << s;
                    EXPECT_EQ(place.omote(), omote) << zukuri << " " << s;
                }
            }
        }
    }
}

// A mitsu-mune has a ridge within it that is not evened out.
TEST(ScannedChart, KeepsTheRidgesOfAThreeSidedMune) {
    KatanaParameters parameters;
    parameters.mune = MuneType::mitsu;
    const KatanaShape shape(parameters);
    const ScannedChart chart(katana_stations(shape));
    const ScannedStations stations = katana_stations(shape, 7.3);
    double worst = 0;
    for (const Station& s : stations.stations) {
        if (s.s_mm < 20 || s.s_mm > 650) continue;
        for (const glm::dvec2& p : s.side[0].outline_mm) {
            if (p.x > 2) break;  // the mune's own
            const glm::dvec3 out = glm::cross(s.along, s.across);
            worst = std::max(worst,
                             std::abs(chart.place(s.ridge_mm + s.across * p.x + out * p.y).off_mm));
        }
    }
    EXPECT_LT(worst, 0.02);
}

TEST(ScannedChart, IsThatOfTheGeneratedKatana) {
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"}) {
        const KatanaParameters p = katana_defaults(zukuri);
        const KatanaMesh katana = make_katana(p, 0.05);
        for (const double step : {0.5, 1.0}) {
            const ScannedChart chart(katana_stations(KatanaShape(p), step));
            const Charted c = charted(katana, chart);
            EXPECT_LE(uv_stretch_percent(c.mesh), 2.0) << zukuri;
            // Where a blade has no yokote the ridge may open from another place on: both are flat.
            EXPECT_LE(c.worst_mm, chart.frame().yokote_s_mm < chart.frame().nagasa_mm ? 0.3 : 0.6)
                << zukuri;
            EXPECT_LE(c.off_mm, step == 0.5 ? 0.03 : 0.08) << zukuri;
            const BladeFrame& frame = chart.frame();
            // The nakago's rounded end lies across the chart.
            EXPECT_NEAR(frame.nakago_mm, katana.frame.nakago_mm, 2);
            EXPECT_NEAR(frame.nagasa_mm, katana.frame.nagasa_mm, 0.1);
            EXPECT_NEAR(frame.yokote_s_mm, katana.frame.yokote_s_mm, 0.1);
            // Before anything is turned or lifted.
            for (double s = 5; s < frame.nagasa_mm - 60; s += 7.3) {
                for (const auto& [name, curve] : frame_curves) {
                    if (name == "suguha_mm") continue;
                    EXPECT_NEAR(frame.at(frame.*curve, s), katana.frame.at(katana.frame.*curve, s),
                                0.01)
                        << zukuri << " " << name << " at " << s;
                }
            }
            EXPECT_NO_THROW(check_frame(frame, "chart"));
        }
    }
}

// What the cross-sections of a scan are unsure of moves the chart no more than that, and hardly
// stretches it.
TEST(ScannedChart, NoiseOfTheCrossSectionsIsEvenedOut) {
    const KatanaParameters p;
    const KatanaMesh katana = make_katana(p, 0.1);
    ScannedStations stations = katana_stations(KatanaShape(p));
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0, 0.01);
    for (Station& station : stations.stations) {
        for (SectionSide& side : station.side) {
            // As cross-sections are that were evened out over a millimetre.
            std::array<glm::dvec2, 60> knots;
            for (glm::dvec2& knot : knots) knot = {noise(random), noise(random)};
            double t = 0;
            glm::dvec2 before(0);
            for (glm::dvec2& point : side.outline_mm) {
                t += glm::distance(point, before);
                before = point;
                const auto k = static_cast<std::size_t>(t);
                point += glm::mix(knots[k], knots[k + 1], t - std::floor(t));
            }
            side.mune_t_mm += 2 * noise(random);
            if (side.mune_t_mm < 0) side.mune_t_mm = 0;
            side.shinogi_t_mm += 10 * noise(random);
        }
    }
    const ScannedChart chart(stations);
    const Charted c = charted(katana, chart);
    EXPECT_LE(uv_stretch_percent(c.mesh, StretchShare{}.least_height_mm), 3.0);
    EXPECT_LE(c.worst_mm, 0.5);
}

// Omote's outline a little wider than ura's: one edge line serves both.
TEST(ScannedChart, SidesThatDifferShareTheEdgeLine) {
    const KatanaParameters p;
    ScannedStations stations = katana_stations(KatanaShape(p));
    for (Station& station : stations.stations) {
        for (glm::dvec2& point : station.side[0].outline_mm) point.y *= 1.05;
    }
    const ScannedChart chart(stations);
    for (const std::size_t i : {500U, 900U, 1300U}) {
        const Station& station = stations.stations[i];
        const glm::dvec3 edge =
            station.ridge_mm + station.across * station.side[0].outline_mm.back().x;
        for (const double out : {1e-3, -1e-3}) {
            const ChartPlace place = chart.place(edge + glm::dvec3(0, out, 0));
            EXPECT_EQ(place.omote(), out > 0);
            EXPECT_NEAR(place.t_mm, chart.frame().at(chart.frame().edge_mm, place.s_mm), 0.01);
        }
    }
}

TEST(ScannedChart, BladeWithoutATangBeginsAtTheMachi) {
    const KatanaParameters p = katana_defaults("hira");
    const ScannedChart chart(katana_stations(KatanaShape(p), 0.5, false));
    EXPECT_EQ(chart.frame().nakago_mm, 0);
    const ChartPlace machi = chart.place({0, 0.5, -10});
    EXPECT_NEAR(machi.s_mm, 0, 0.6);
    EXPECT_NEAR(chart.uv(0, 3, true).x, 0, 1e-3);
    const Charted c = charted(make_katana(p, 0.05), chart);
    EXPECT_LE(uv_stretch_percent(c.mesh), 2.0);
}

// A steel pattern takes the scanned frame as it takes a generated one's, and is the same pattern.
TEST(ScannedChart, TakesASteelPattern) {
    const KatanaParameters p = katana_defaults("hira");
    const ScannedChart chart(katana_stations(KatanaShape(p)));
    const BladeFrame own = make_katana(p, 0.002).frame;
    const Material material;
    SteelParameters steel;
    const PropertyMaps ours = steel_pattern(chart.frame(), material, steel, 700, 50);
    const PropertyMaps theirs = steel_pattern(own, material, steel, 700, 50);
    double difference = 0;
    double mean = 0;
    for (std::size_t y = 0; y < 50; ++y) {
        for (std::size_t x = 0; x < 700; ++x) {
            difference += std::abs(double(ours.at(MapChannel::w, x, y)) -
                                   double(theirs.at(MapChannel::w, x, y)));
            mean += double(theirs.at(MapChannel::w, x, y));
        }
    }
    EXPECT_GT(mean / 35000, 0.1);
    EXPECT_LT(difference / 35000, 0.01);
}

TEST(ScannedChart, RefusesWhatIsNoBlade) {
    const ScannedStations good = katana_stations(KatanaShape(katana_defaults("hira")), 2.0);
    auto refuses = [&](auto&& spoil) {
        ScannedStations s = good;
        spoil(s);
        EXPECT_THROW(ScannedChart{s}, InputError);
    };
    refuses([](ScannedStations& s) { s.stations.resize(7); });
    refuses([](ScannedStations& s) { s.step_mm = 0; });
    refuses([](ScannedStations& s) {
        s.stations[20].side[1].outline_mm[3].x = std::numeric_limits<double>::quiet_NaN();
    });
    refuses([](ScannedStations& s) { std::swap(s.stations[4], s.stations[5]); });
    refuses([](ScannedStations& s) {
        for (Station& station : s.stations) station.s_mm -= 500;
    });
    refuses([](ScannedStations& s) {
        for (Station& station : s.stations)
            for (SectionSide& side : station.side) side.outline_mm.assign(2, {0, 0});
    });
    EXPECT_NO_THROW(ScannedChart{good});
}

}  // namespace
}  // namespace togishi
