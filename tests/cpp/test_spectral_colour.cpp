// Spectra to colour: whites, weights, adaptation, CIEDE2000.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "brdf/model.hpp"
#include "spectral/colour_space.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/delta_e.hpp"
#include "spectral/linear_table.hpp"
#include "spectral/metal.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;

const std::vector<std::string>& many_lights() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const auto& light : builtin_lights()) all.push_back(light->description().name);
        for (const auto* law : {"daylight:4000", "daylight:6500", "daylight:25000", "blackbody:500",
                                "blackbody:2000", "blackbody:100000"}) {
            all.emplace_back(law);
        }
        for (double nm = 400.0; nm <= 700.0; nm += 7.3) all.push_back("line:" + std::to_string(nm));
        all.emplace_back("line:700");
        return all;
    }();
    return names;
}

double sum(const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0);
}

TEST(Pchip, PassesThroughItsPointsAndNeverOvershoots) {
    const std::vector<double> x{0.0, 1.0, 1.5, 4.0, 5.0, 5.1};
    const std::vector<double> y{1.0, 1.0, 3.0, 3.5, -2.0, -2.0};
    const Pchip curve(x, y);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(curve(x[i]), y[i], 1e-15);
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
        double before = y[i];
        for (int step = 1; step <= 50; ++step) {
            const double value = curve(x[i] + (x[i + 1] - x[i]) * step / 50.0);
            EXPECT_GE((value - before) * (y[i + 1] - y[i]), -1e-15);
            before = value;
        }
    }
    EXPECT_NEAR(Pchip({1.0, 3.0}, {2.0, 6.0})(2.5), 5.0, 1e-15);
}

TEST(LinearTable, SharesOutTheIntegralExactly) {
    const std::vector<double> x{395.0, 401.3, 402.0, 402.1, 530.7, 699.0, 720.0};
    const std::vector<double> y{2.0, 0.0, 9.0, 1.0, 4.0, 3.0, 3.0};
    double integral = 0.0;  // 400 to 700 nm
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
        const double a = std::max(x[i], 400.0);
        const double b = std::min(x[i + 1], 700.0);
        auto at = [&](double nm) {
            return y[i] + (y[i + 1] - y[i]) * (nm - x[i]) / (x[i + 1] - x[i]);
        };
        integral += 0.5 * (b - a) * (at(a) + at(b));
    }
    for (const Grid& grid :
         {grid_61, Grid{400.0, 10.0, 31}, Grid{400.0, 1.0, 301}, Grid{400.0, 0.5, 601}}) {
        EXPECT_NEAR(sum(linear_shared_out(x, y, grid)) * grid.step_nm, integral, 1e-10);
    }
    // A straight spectrum is read off unchanged inside.
    const auto straight =
        linear_shared_out(std::vector{300.0, 800.0}, std::vector{3.0, 8.0}, grid_61);
    for (std::size_t i = 1; i + 1 < straight.size(); ++i)
        EXPECT_NEAR(straight[i], grid_61.wavelength_nm(i) / 100.0, 1e-12);
}

TEST(LinearTable, IsZeroOutsideAndExactInside) {
    const std::vector<double> x{400.0, 500.0};
    const std::vector<double> y{1.0, 3.0};
    const std::vector<double> at{399.999, 400.0, 450.0, 500.0, 500.001};
    EXPECT_EQ(linear_at(x, y, at), (std::vector<double>{0.0, 1.0, 2.0, 3.0, 0.0}));
}

TEST(Light, ALineIsSplitBetweenItsNeighbours) {
    const auto samples = find_light("line:589.3")->sample(grid_61);
    EXPECT_NEAR(samples[37] * 5.0, 0.14, 1e-12);  // 585 nm
    EXPECT_NEAR(samples[38] * 5.0, 0.86, 1e-12);  // 590 nm
    EXPECT_NEAR(sum(samples) * 5.0, 1.0, 1e-12);
    for (const auto* edge : {"line:400", "line:700"}) {
        EXPECT_NEAR(sum(find_light(edge)->sample(grid_61)) * 5.0, 1.0, 1e-12);
    }
    EXPECT_EQ(find_light("line:500")->power_at({490.0, 500.0, 510.0}),
              (std::vector<double>{0.0, 1.0, 0.0}));
}

TEST(Light, BlackbodyPeaksByWien) {
    // lambda_max T = 2.897771955e6 nm K (CODATA 2018).
    const auto light = find_light("blackbody:5000");
    std::vector<double> nm;
    for (double w = 570.0; w < 590.0; w += 0.05) nm.push_back(w);
    const auto power = light->power_at(nm);
    const auto peak = std::max_element(power.begin(), power.end()) - power.begin();
    EXPECT_NEAR(nm[static_cast<std::size_t>(peak)], 2.897771955e6 / 5000.0, 0.05);
    EXPECT_NEAR(light->power_at({560.0})[0], 100.0, 1e-12);
}

TEST(ColourWeights, TheWhiteIsTheSameOnEveryGrid) {
    for (const auto& observer : builtin_observers()) {
        for (const auto& name : many_lights()) {
            const auto light = find_light(name);
            const auto full = colour_weights(*light, *observer, grid_full);
            for (const Grid& grid : {grid_61, Grid{400.0, 10.0, 31}, Grid{400.0, 20.0, 16}}) {
                const auto weights = colour_weights(*light, *observer, grid);
                EXPECT_NEAR(weights.white.y, 1.0, 1e-13);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(weights.white[c], full.white[c], 1e-12 * (1.0 + full.white[c]));
                for (const auto* column : {&weights.x, &weights.y, &weights.z}) {
                    for (const double w : *column)
                        ASSERT_TRUE(std::isfinite(w) && w >= 0.0) << name;
                }
            }
        }
    }
}

TEST(ColourWeights, AmountsDoNotMatter) {
    const auto observer = find_observer(default_observer);
    auto white = [&](const std::string& unit) {
        return colour_weights(
                   light_from_csv("400,1e" + unit + "\n550,3e" + unit + "\n700,2e" + unit + "\n",
                                  "u", "u"),
                   *observer)
            .white;
    };
    for (const auto* unit : {"-300", "-80", "80", "99"}) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(white(unit)[c], white("0")[c], 1e-12);
    }
}

TEST(ColourWeights, AFineTableAndALineAgree) {
    // A line measured by a spectrometer of 0.2 nm as a narrow triangle is the line.
    const auto observer = find_observer(default_observer);
    const auto narrow = light_from_csv("380,0\n546.0,0\n546.1,1\n546.2,0\n780,0\n", "u", "u");
    const auto a = colour_weights(narrow, *observer).white;
    const auto b = colour_weights(*find_light("line:546.1"), *observer).white;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 2e-5);
}

TEST(ColourWeights, SixtyOneSamplesAgreeWithOneNanometre) {
    const auto observer = find_observer(default_observer);
    const auto d65 = colour_weights(*find_light("D65"), *observer).white;
    double worst = 0.0;
    std::string where;
    for (const auto& metal : builtin_metals()) {
        const auto on_61 = metal->at(grid_61);
        const auto on_full = metal->at(grid_full);
        for (const auto& name : many_lights()) {
            const auto light = find_light(name);
            const auto coarse = colour_weights(*light, *observer);
            const auto fine = colour_weights(*light, *observer, grid_full);
            for (const double angle_deg : {0.0, 30.0, 60.0, 75.0, 85.0, 88.0}) {
                const double c = std::cos(angle_deg * rad_per_deg);
                auto reflectance = [&](const RefractiveIndex& index) {
                    std::vector<double> f(index.n.size());
                    for (std::size_t i = 0; i < f.size(); ++i)
                        f[i] = f64::fresnel_conductor(index.n[i], index.k[i], c);
                    return f;
                };
                const double difference =
                    delta_e00(lab_from_xyz(coarse.xyz(reflectance(on_61)), d65),
                              lab_from_xyz(fine.xyz(reflectance(on_full)), d65));
                if (!(difference <= worst)) {
                    worst = difference;
                    where = std::string(metal->name()) + " " + name;
                }
            }
        }
    }
    EXPECT_LE(worst, 0.08) << where;
    EXPECT_GT(worst, 1e-4);  // the two grids are not one and the same
}

TEST(ColourSpace, WhitesAreWhite) {
    for (const auto& space : colour_spaces()) {
        const auto rgb = space.rgb_from_xyz * space.white_xyz;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], 1.0, 1e-12) << space.name;
    }
    EXPECT_THROW((void)find_colour_space("srgb"), InputError);
    EXPECT_THROW((void)find_adaptation("cat02"), InputError);
}

TEST(Adaptation, MapsOneWhiteToTheOtherAndRefusesLines) {
    const glm::dvec3 a(1.09850, 1.0, 0.35585);
    const glm::dvec3 d65(0.95047, 1.0, 1.08883);
    for (const auto adaptation : {Adaptation::bradford, Adaptation::cat16}) {
        const auto there = adaptation_matrix(adaptation, a, d65);
        const auto back = adaptation_matrix(adaptation, d65, a);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR((there * a)[c], d65[c], 1e-12);
            EXPECT_NEAR((back * there * glm::dvec3(0.2, 0.3, 0.4))[c], glm::dvec3(0.2, 0.3, 0.4)[c],
                        1e-12);
        }
        EXPECT_THROW((void)adaptation_matrix(adaptation, glm::dvec3(0.0, 0.0, 1.0), d65),
                     InputError);
        EXPECT_THROW((void)adaptation_matrix(adaptation, glm::dvec3(0.0), d65), InputError);
    }
    EXPECT_EQ(adaptation_matrix(Adaptation::none, a, d65), glm::dmat3(1.0));
}

TEST(DeltaE, PublishedPairs) {
    // Sharma, Wu and Dalal 2005, table 1.
    struct Pair {
        glm::dvec3 a, b;
        double de00;
    };
    const std::array<Pair, 34> pairs{{
        {{50.0000, 2.6772, -79.7751}, {50.0000, 0.0000, -82.7485}, 2.0425},
        {{50.0000, 3.1571, -77.2803}, {50.0000, 0.0000, -82.7485}, 2.8615},
        {{50.0000, 2.8361, -74.0200}, {50.0000, 0.0000, -82.7485}, 3.4412},
        {{50.0000, -1.3802, -84.2814}, {50.0000, 0.0000, -82.7485}, 1.0000},
        {{50.0000, -1.1848, -84.8006}, {50.0000, 0.0000, -82.7485}, 1.0000},
        {{50.0000, -0.9009, -85.5211}, {50.0000, 0.0000, -82.7485}, 1.0000},
        {{50.0000, 0.0000, 0.0000}, {50.0000, -1.0000, 2.0000}, 2.3669},
        {{50.0000, -1.0000, 2.0000}, {50.0000, 0.0000, 0.0000}, 2.3669},
        {{50.0000, 2.4900, -0.0010}, {50.0000, -2.4900, 0.0009}, 7.1792},
        {{50.0000, 2.4900, -0.0010}, {50.0000, -2.4900, 0.0010}, 7.1792},
        {{50.0000, 2.4900, -0.0010}, {50.0000, -2.4900, 0.0011}, 7.2195},
        {{50.0000, 2.4900, -0.0010}, {50.0000, -2.4900, 0.0012}, 7.2195},
        {{50.0000, -0.0010, 2.4900}, {50.0000, 0.0009, -2.4900}, 4.8045},
        {{50.0000, -0.0010, 2.4900}, {50.0000, 0.0010, -2.4900}, 4.8045},
        {{50.0000, -0.0010, 2.4900}, {50.0000, 0.0011, -2.4900}, 4.7461},
        {{50.0000, 2.5000, 0.0000}, {50.0000, 0.0000, -2.5000}, 4.3065},
        {{50.0000, 2.5000, 0.0000}, {73.0000, 25.0000, -18.0000}, 27.1492},
        {{50.0000, 2.5000, 0.0000}, {61.0000, -5.0000, 29.0000}, 22.8977},
        {{50.0000, 2.5000, 0.0000}, {56.0000, -27.0000, -3.0000}, 31.9030},
        {{50.0000, 2.5000, 0.0000}, {58.0000, 24.0000, 15.0000}, 19.4535},
        {{50.0000, 2.5000, 0.0000}, {50.0000, 3.1736, 0.5854}, 1.0000},
        {{50.0000, 2.5000, 0.0000}, {50.0000, 3.2972, 0.0000}, 1.0000},
        {{50.0000, 2.5000, 0.0000}, {50.0000, 1.8634, 0.5757}, 1.0000},
        {{50.0000, 2.5000, 0.0000}, {50.0000, 3.2592, 0.3350}, 1.0000},
        {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
        {{63.0109, -31.0961, -5.8663}, {62.8187, -29.7946, -4.0864}, 1.2630},
        {{61.2901, 3.7196, -5.3901}, {61.4292, 2.2480, -4.9620}, 1.8731},
        {{35.0831, -44.1164, 3.7933}, {35.0232, -40.0716, 1.5901}, 1.8645},
        {{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
        {{36.4612, 47.8580, 18.3852}, {36.2715, 50.5065, 21.2231}, 1.4146},
        {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
        {{90.9257, -0.5406, -0.9208}, {88.6381, -0.8985, -0.7239}, 1.5381},
        {{6.7747, -0.2908, -2.4247}, {5.8714, -0.0985, -2.2286}, 0.6377},
        {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
    }};
    for (const auto& [a, b, expected] : pairs) {
        EXPECT_NEAR(delta_e00(a, b), expected, 5.1e-5);
        EXPECT_NEAR(delta_e00(b, a), expected, 5.1e-5);
        EXPECT_EQ(delta_e00(a, a), 0.0);
    }
    EXPECT_TRUE(std::isfinite(delta_e00({0.0, 0.0, 0.0}, {100.0, 1e6, -1e6})));
    EXPECT_TRUE(std::isnan(delta_e00({NAN, 0.0, 0.0}, {1.0, 0.0, 0.0})));
}

TEST(Metal, RefusesWavelengthsThatWereNotMeasured) {
    const auto iron = find_metal(default_metal);
    EXPECT_NO_THROW((void)iron->at(std::vector{188.0, 1937.0}));
    EXPECT_THROW((void)iron->at(std::vector{187.9}), InputError);
    EXPECT_THROW((void)iron->at(std::vector{1937.1}), InputError);
    EXPECT_THROW((void)iron->at(std::vector<double>{NAN}), InputError);
    const auto at_node = iron->at(std::vector{549.0});
    EXPECT_EQ(at_node.n[0], 2.95);
    EXPECT_EQ(at_node.k[0], 2.93);
}

}  // namespace
}  // namespace togishi
