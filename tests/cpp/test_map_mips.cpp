// Mip levels of property maps against the mixture of the texels that each texel stands for.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <numbers>
#include <random>

#include "bake/map_mips.hpp"
#include "bake/map_repair.hpp"
#include "base/error.hpp"
#include "brdf/model.hpp"

namespace {

using namespace togishi;
using enum MapChannel;
constexpr double degree = std::numbers::pi / 180.0;
constexpr float nan32 = std::numeric_limits<float>::quiet_NaN();
constexpr float inf32 = std::numeric_limits<float>::infinity();

PropertyMaps random_maps(std::size_t width, std::size_t height, unsigned seed, bool shapes) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    PropertyMaps maps;
    maps.width = width;
    maps.height = height;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        const auto channel = static_cast<MapChannel>(c);
        const bool shape =
            channel == ji_e1 || channel == ji_e2 || channel == ha_e1 || channel == ha_e2;
        if (shape && !shapes) continue;
        auto& plane = maps[channel];
        plane.resize(width * height);
        for (std::size_t i = 0; i < plane.size(); ++i) {
            const float r = unit(random);
            if (shape)
                plane[i] = 1.2F * (r - 0.5F);
            else if (channel == ji_ln_mu_deg)
                plane[i] = std::log(0.3F + r);
            else if (channel == ha_ln_mu_deg)
                plane[i] = std::log(3.0F + 4 * r);
            else if (channel == w)
                plane[i] = r < 0.3F ? 0.0F : r > 0.7F ? 1.0F : r;
            else if (channel == h)
                plane[i] = r < 0.5F ? 0.0F : r;
            else
                plane[i] = std::floor(8 * r);
        }
    }
    return maps;
}

struct Mixture {
    double ji = 0, hadori = 0, ha = 0;                 // energies: mean shares
    std::array<double, 3> ji_moments{}, ha_moments{};  // xx, xy, yy in deg^2, per unit of energy
};

// Of the texels [x0, x1) x [y0, y1), in double, from the definition: mu along an axis, turned by
// rho.
Mixture mixture(const PropertyMaps& maps, std::size_t x0, std::size_t x1, std::size_t y0,
                std::size_t y1) {
    Mixture m;
    const auto add = [](double share, double ln_mu, double e1, double e2,
                        std::array<double, 3>& sum) {
        const double r = std::hypot(e1, e2), rho = 0.5 * std::atan2(e2, e1);
        const double t2 = std::exp(2 * (ln_mu + r)), b2 = std::exp(2 * (ln_mu - r));
        const double c = std::cos(rho), s = std::sin(rho);
        sum[0] += share * (t2 * c * c + b2 * s * s);
        sum[1] += share * (t2 - b2) * s * c;
        sum[2] += share * (t2 * s * s + b2 * c * c);
    };
    const auto value = [&](MapChannel c, std::size_t x, std::size_t y) {
        return maps[c].empty() ? 0.0 : static_cast<double>(maps.at(c, x, y));
    };
    for (std::size_t y = y0; y < y1; ++y) {
        for (std::size_t x = x0; x < x1; ++x) {
            const double share_w = value(w, x, y), share_h = value(h, x, y);
            const double ji = (1 - share_w) * (1 - share_h);
            m.ji += ji;
            m.hadori += (1 - share_w) * share_h;
            m.ha += share_w;
            add(ji, value(ji_ln_mu_deg, x, y), value(ji_e1, x, y), value(ji_e2, x, y),
                m.ji_moments);
            add(share_w, value(ha_ln_mu_deg, x, y), value(ha_e1, x, y), value(ha_e2, x, y),
                m.ha_moments);
        }
    }
    for (auto& v : m.ji_moments) v /= m.ji;
    for (auto& v : m.ha_moments) v /= m.ha;
    const double area = static_cast<double>((x1 - x0) * (y1 - y0));
    m.ji /= area;
    m.hadori /= area;
    m.ha /= area;
    return m;
}

void expect_same(const Mixture& a, const Mixture& b) {
    EXPECT_NEAR(a.ji, b.ji, 2e-6);
    EXPECT_NEAR(a.hadori, b.hadori, 2e-6);
    EXPECT_NEAR(a.ha, b.ha, 2e-6);
    EXPECT_NEAR(a.ji + a.hadori + a.ha, 1.0, 1e-6);
    for (const bool ji : {true, false}) {
        if ((ji ? b.ji : b.ha) == 0) continue;
        const auto &p = ji ? a.ji_moments : a.ha_moments, &q = ji ? b.ji_moments : b.ha_moments;
        const double trace = q[0] + q[2];
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(p[i], q[i], 5e-6 * trace);
    }
}

TEST(MapMips, EveryLevelIsTheMixtureOfItsTexels) {
    for (const bool shapes : {false, true}) {
        const PropertyMaps maps = random_maps(64, 16, 1, shapes);
        const auto levels = coarser_levels(view_of(maps));
        ASSERT_EQ(levels.size(), 6U);
        for (std::size_t n = 0; n < levels.size(); ++n) {
            const PropertyMaps& level = levels[n];
            const std::size_t sx = maps.width / level.width, sy = maps.height / level.height;
            for (std::size_t y = 0; y < level.height; ++y) {
                for (std::size_t x = 0; x < level.width; ++x) {
                    expect_same(mixture(level, x, x + 1, y, y + 1),
                                mixture(maps, x * sx, (x + 1) * sx, y * sy, (y + 1) * sy));
                }
            }
        }
    }
}

TEST(MapMips, OddSizesLoseNothing) {
    // However the sizes divide, the 1 x 1 level is the mixture of the whole map.
    const std::pair<std::size_t, std::size_t> sizes[]{
        {37, 19}, {1, 1023}, {5, 1}, {3, 3}, {100, 7}};
    for (const auto& [width, height] : sizes) {
        const PropertyMaps maps = random_maps(width, height, 3, true);
        const auto levels = coarser_levels(view_of(maps));
        EXPECT_EQ(levels.back().width, 1U);
        EXPECT_EQ(levels.back().height, 1U);
        expect_same(mixture(levels.back(), 0, 1, 0, 1), mixture(maps, 0, width, 0, height));
    }
    EXPECT_TRUE(coarser_levels(view_of(random_maps(1, 1, 1, true))).empty());
    EXPECT_EQ(coarser_levels(view_of(random_maps(3, 1, 1, true))).size(), 1U);
}

TEST(MapMips, MomentsAreThoseOfTheLobeItself) {
    // The moments that the levels add are the integrals of phi phi^T D over the facets: by
    // quadrature of lobe_value.
    const auto lobe = f64::lobe_from_mu(3 * degree, 1 * degree, 0.5);
    const auto form = f64::lobe_form(lobe);
    double energy = 0, xx = 0, xy = 0, yy = 0;
    for (double x = -16; x < 16; x += 0.1) {
        for (double y = -16; y < 16; y += 0.1) {
            const double d = f64::lobe_value(form, {x * degree, y * degree});
            energy += d;
            xx += d * x * x;
            xy += d * x * y;
            yy += d * y * y;
        }
    }
    const auto m = f64::lobe_moments(lobe, f64::lobe_shape(lobe.e1, lobe.e2));
    const double unit = 2 * std::numbers::ln2;
    EXPECT_NEAR(unit * xx / energy, m.xx, 1e-9);
    EXPECT_NEAR(unit * xy / energy, m.xy, 1e-9);
    EXPECT_NEAR(unit * yy / energy, m.yy, 1e-9);
}

TEST(MapMips, PeakOfOneLobeAgainstTheMixture) {
    // What one Gaussian for many costs at its peak, as stated in map_mips.hpp: ratio of 1/(mu_t
    // mu_b).
    const auto peak_ratio = [](float mu_a, float mu_b) {
        PropertyMaps maps;
        maps.width = 2;
        maps.height = 1;
        maps[ji_ln_mu_deg] = {std::log(mu_a), std::log(mu_b)};
        maps[ha_ln_mu_deg] = {1.6F};
        maps[w] = {0.0F};
        const auto levels = coarser_levels(view_of(maps));
        const double one = std::exp(-2.0 * levels[0][ji_ln_mu_deg][0]);
        return one / (0.5 * (1 / (mu_a * mu_a) + 1 / (mu_b * mu_b)));
    };
    EXPECT_NEAR(peak_ratio(0.8F, 5.0F), 0.0975, 0.0005);
    EXPECT_NEAR(peak_ratio(0.72F, 0.88F), 0.961, 0.001);
}

TEST(MapMips, ConstantChannelsStayOneValue) {
    PropertyMaps maps = random_maps(8, 4, 5, true);
    maps[ji_e1] = {0.4F};
    maps[ji_e2] = {-0.3F};
    maps[ha_ln_mu_deg] = {1.5F};
    maps[ha_e1] = {0.2F};
    maps[ha_e2].clear();
    maps[h] = {0.25F};
    maps[part] = {1.0F};
    for (const auto& level : coarser_levels(view_of(maps))) {
        EXPECT_EQ(level[ji_ln_mu_deg].size(), level.width * level.height);
        EXPECT_EQ(level[ji_e1], std::vector<float>{0.4F});
        EXPECT_EQ(level[ji_e2], std::vector<float>{-0.3F});
        EXPECT_EQ(level[ha_ln_mu_deg], std::vector<float>{1.5F});
        EXPECT_EQ(level[ha_e1], std::vector<float>{0.2F});
        EXPECT_TRUE(level[ha_e2].empty());
        EXPECT_EQ(level[h], std::vector<float>{0.25F});
        EXPECT_EQ(level[part], std::vector<float>{1.0F});
    }
}

TEST(MapMips, EqualTexelsStayWhatTheyAre) {
    PropertyMaps maps = random_maps(9, 6, 5, true);
    for (auto& plane : maps.channels) plane.assign(plane.size(), plane[7]);
    maps[part].assign(54, 6.0F);
    for (const float all : {0.0F, 0.4F, 1.0F}) {
        maps[w].assign(54, all);
        for (const auto& level : coarser_levels(view_of(maps))) {
            for (std::size_t c = 0; c < map_channel_count; ++c) {
                for (const float value : level.channels[c])
                    EXPECT_NEAR(value, maps.channels[c][0], 3e-6);
            }
        }
    }
}

TEST(MapMips, TurningStrokesWidenALobeOfConstantSize) {
    PropertyMaps maps;
    maps.width = 2;
    maps.height = 1;
    maps[ji_ln_mu_deg] = {0.0F};
    maps[ji_e1] = {0.5F, -0.5F};  // rho 0 and 90 degrees
    maps[ji_e2] = {0.0F};
    maps[ha_ln_mu_deg] = {1.6F};
    maps[w] = {0.0F};
    const auto level = coarser_levels(view_of(maps)).at(0);
    EXPECT_NEAR(level[ji_e1][0], 0, 1e-6);
    EXPECT_NEAR(level[ji_ln_mu_deg][0], 0.5 * std::log(std::cosh(1.0)), 1e-6);
}

TEST(MapMips, PartByMajority) {
    PropertyMaps maps = random_maps(4, 2, 1, false);
    maps[part] = {1, 1, 3, 4, 1, 3, 4, 2};
    auto level = coarser_levels(view_of(maps)).at(0);
    EXPECT_EQ(level[part], (std::vector<float>{1, 4}));
    maps[part] = {2, 1, 3, 3, 1, 2, 3, 3};  // a draw: the lower number
    EXPECT_EQ(coarser_levels(view_of(maps)).at(0)[part], (std::vector<float>{1, 3}));
}

TEST(MapMips, WhatAMapMustNotHoldDoesNotSpread) {
    PropertyMaps maps = random_maps(16, 16, 8, true);
    std::mt19937 random(1);
    for (auto& plane : maps.channels) {
        for (const float bad : {nan32, inf32, -inf32, 1e38F, -1e38F})
            plane[random() % plane.size()] = bad;
    }
    for (const auto& level : coarser_levels(view_of(maps))) {
        for (std::size_t c = 0; c < map_channel_count; ++c) {
            for (const float value : level.channels[c])
                ASSERT_TRUE(std::isfinite(value)) << map_channel_names[c];
        }
    }
}

TEST(MapMips, ResultDoesNotDependOnThreadsOrLayout) {
    const PropertyMaps maps = random_maps(700, 300, 12, true);
    const auto one = coarser_levels(view_of(maps), 1), four = coarser_levels(view_of(maps), 4);
    // The same map as interleaved pixels.
    std::vector<float> pixels(maps.width * maps.height * map_channel_count);
    MapView view;
    view.width = maps.width;
    view.height = maps.height;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        for (std::size_t i = 0; i < maps.width * maps.height; ++i) {
            pixels[i * map_channel_count + c] = maps.channels[c][i];
        }
        view.channels[c] = {pixels.data() + c, map_channel_count};
    }
    const auto interleaved = coarser_levels(view, 3);
    for (std::size_t n = 0; n < one.size(); ++n) {
        EXPECT_EQ(one[n].channels, four[n].channels);
        EXPECT_EQ(one[n].channels, interleaved[n].channels);
    }
}

TEST(MapMips, RefusesWhatIsNoMap) {
    PropertyMaps maps = random_maps(4, 4, 1, false);
    maps[w].clear();
    EXPECT_THROW((void)coarser_levels(view_of(maps)), InputError);
    maps = random_maps(4, 4, 1, false);
    maps.width = 0;
    EXPECT_THROW((void)coarser_levels(view_of(maps)), InputError);
}

TEST(MapMips, ExtremeSizes) {
    for (const auto& [width, height] :
         {std::pair<std::size_t, std::size_t>{16384, 16}, {16, 16384}}) {
        const auto levels = coarser_levels(view_of(random_maps(width, height, 4, false)));
        EXPECT_EQ(levels.size(), 14U);
        EXPECT_EQ(levels.back().width * levels.back().height, 1U);
        EXPECT_TRUE(std::isfinite(levels.back()[ji_ln_mu_deg][0]));
    }
}

TEST(MapMips, Cost) {
    // A figure for the report, not a bound: other programs run beside the tests. Bounds stand in
    // tests/bench.
    for (const bool shapes : {false, true}) {
        const PropertyMaps maps = random_maps(1024, 512, 2, shapes);
        double best = 1e9;
        for (int i = 0; i < 3; ++i) {
            const std::clock_t start = std::clock();  // of this process: others may be running
            const auto levels = coarser_levels(view_of(maps), 1);
            best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
            ASSERT_EQ(levels.size(), 10U);
        }
        std::printf("  %s: %.1f ns per texel of level 0, one core\n",
                    shapes ? "shapes" : "isotropic", 1e9 * best / (1024 * 512));
    }
}

TEST(MapRepair, NaNTakesTheNearestValidValue) {
    PropertyMaps maps = random_maps(5, 1, 1, false);
    maps[w] = {nan32, 0.25F, nan32, inf32, 0.75F};
    maps[ji_ln_mu_deg] = {0.0F, -inf32, nan32, nan32, nan32};
    maps[h] = {nan32, nan32, nan32, nan32, nan32};
    maps[part] = {1, 9, 2.5F, -1, nan32};
    EXPECT_FALSE(is_valid(view_of(maps)));
    const MapRepair repair = repair_map(maps);
    EXPECT_EQ(maps[w], (std::vector<float>{0.25F, 0.25F, 0.25F, 0.75F, 0.75F}));
    EXPECT_EQ(maps[ji_ln_mu_deg], (std::vector<float>{0, 0, 0, 0, 0}));
    EXPECT_EQ(maps[h], (std::vector<float>{0, 0, 0, 0, 0}));
    EXPECT_EQ(maps[part], (std::vector<float>{1, 0, 0, 0, 0}));
    EXPECT_EQ(repair.not_finite, 3U + 4U + 5U + 1U);
    EXPECT_EQ(repair.out_of_range, 4U);  // 9, 2.5, -1 and the copy of -1
    EXPECT_TRUE(is_valid(view_of(maps)));
    EXPECT_NE(repair.sentence("blade.exr").find("13 values were NaN"), std::string::npos);
    EXPECT_EQ(MapRepair{}.sentence("x"), "");
}

TEST(MapRepair, RangesOfTheModel) {
    PropertyMaps maps = random_maps(2, 1, 1, true);
    maps[w] = {-0.5F, 1.5F};
    maps[ha_ln_mu_deg] = {-100, 100};
    maps[ji_e1] = {3.0F, 0.1F};
    maps[ji_e2] = {4.0F, 0.1F};
    maps[ha_e1] = {50.0F};
    maps[ha_e2] = {0.0F, 1.0F};
    (void)repair_map(maps);
    EXPECT_EQ(maps[w], (std::vector<float>{0, 1}));
    EXPECT_NEAR(maps[ha_ln_mu_deg][0], std::log(0.001), 1e-6);
    EXPECT_NEAR(maps[ha_ln_mu_deg][1], std::log(80.0), 1e-6);
    EXPECT_NEAR(maps[ji_e1][0], 0.6 * std::log(10.0), 1e-5);
    EXPECT_NEAR(maps[ji_e2][0], 0.8 * std::log(10.0), 1e-5);
    EXPECT_EQ(maps[ji_e1][1], 0.1F);
    ASSERT_EQ(maps[ha_e1].size(), 2U);
    EXPECT_NEAR(maps[ha_e1][1], std::log(10.0), 1e-3);
    EXPECT_TRUE(is_valid(view_of(maps)));
    // An aspect of exactly 100:1 is in range whatever its direction.
    const auto lobe = f32::lobe_from_mu(0.1F, 0.001F, 1.0F);
    maps[ji_e1] = {lobe.e1, 0};
    maps[ji_e2] = {lobe.e2, 0};
    EXPECT_FALSE(repair_map(maps).any());
}

TEST(MapRepair, ValidMapsAreLeftAlone) {
    PropertyMaps maps = random_maps(33, 17, 1, true);
    EXPECT_TRUE(is_valid(view_of(maps)));
    PropertyMaps copy = copy_of(view_of(maps));
    EXPECT_FALSE(repair_map(copy).any());
    EXPECT_EQ(copy.channels, maps.channels);
}

}  // namespace
