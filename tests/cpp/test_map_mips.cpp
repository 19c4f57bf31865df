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
#include "bake/normal_mips.hpp"
#include "base/error.hpp"
#include "brdf/area_lights.hpp"
#include "brdf/model.hpp"
#include "brdf/normal_map.hpp"

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

// Leans of each texel, Gaussian about (0.5, -0.2) with a covariance that is not along the axes, as
// a map.
std::vector<float> random_normals(std::size_t width, std::size_t height, double spread) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<float> rgb;
    rgb.reserve(3 * width * height);
    for (std::size_t i = 0; i < width * height; ++i) {
        const double a = spread * normal(random), b = spread * normal(random);
        const glm::dvec3 n =
            glm::normalize(glm::dvec3(0.5 + 2 * a + 0.5 * b, -0.2 + 0.6 * b - a, 1));
        for (int c = 0; c < 3; ++c) rgb.push_back(static_cast<float>(0.5 + 0.5 * n[c]));
    }
    return rgb;
}

TEST(NormalMips, EveryLevelHoldsTheMeanAndCovarianceOfItsTexels) {
    for (const auto& [width, height] :
         {std::pair<std::size_t, std::size_t>{32, 16}, {13, 7}, {1, 5}}) {
        const std::vector<float> rgb = random_normals(width, height, 0.05);
        NormalRepair repair;
        const auto levels = normal_levels({rgb.data(), 3, width, height}, repair);
        EXPECT_TRUE(repair.sentence("map").empty());
        EXPECT_EQ(levels.back().width * levels.back().height, 1U);
        for (const NormalLevel& level : levels) {
            for (std::size_t i = 0; i < level.width * level.height; ++i) {
                // What of level 0 lies in the texel, by area.
                const double x0 =
                    static_cast<double>(i % level.width * width) / static_cast<double>(level.width);
                const double y0 = static_cast<double>(i / level.width * height) /
                                  static_cast<double>(level.height);
                const double w = static_cast<double>(width) / static_cast<double>(level.width);
                const double h = static_cast<double>(height) / static_cast<double>(level.height);
                double area = 0;
                glm::dvec2 mean(0);
                glm::dvec3 square(0);
                for (std::size_t k = 0; k < width * height; ++k) {
                    const auto x = static_cast<double>(k % width),
                               y = static_cast<double>(k / width);
                    const double share = std::max(0.0, std::min(x0 + w, x + 1) - std::max(x0, x)) *
                                         std::max(0.0, std::min(y0 + h, y + 1) - std::max(y0, y));
                    const glm::dvec2 lean(levels[0].lean_x[k], levels[0].lean_y[k]);
                    area += share;
                    mean += share * lean;
                    square += share * glm::dvec3(lean.x * lean.x, lean.x * lean.y, lean.y * lean.y);
                }
                mean /= area;
                square /= area;
                EXPECT_NEAR(level.lean_x[i], mean.x, 1e-6);
                EXPECT_NEAR(level.lean_y[i], mean.y, 1e-6);
                if (level.sd_x.empty()) continue;
                const double sx = level.sd_x[i], sy = level.sd_y[i];
                EXPECT_NEAR(sx * sx, square.x - mean.x * mean.x, 1e-6);
                EXPECT_NEAR(sy * sy, square.z - mean.y * mean.y, 1e-6);
                EXPECT_NEAR(sx * sy * level.correlation[i], square.y - mean.x * mean.y, 1e-6);
            }
        }
    }
}

// What one texel of a level reflects towards each half vector against the mixture of what its
// texels reflect: values about the peak, and the energy over all half vectors.
TEST(NormalMips, TheWidenedLobeIsTheMixture) {
    constexpr std::size_t size = 64;
    const std::vector<float> rgb = random_normals(size, size, 0.02);
    NormalRepair repair;
    const auto levels = normal_levels({rgb.data(), 3, size, size}, repair);
    const auto form = f64::lobe_form(f64::lobe_from_mu(1.2 * degree, 0.5 * degree, 0.4));
    const f64::dvec3 up(0, 0, 1), u(1, 0, 0), v(0, 1, 0);
    const auto value_about = [&](const f64::LobeForm& lobe, const f64::dvec3& normal,
                                 const f64::dvec3& half) {
        const auto axes = f64::tangent_frame(normal, u);
        const double along = glm::dot(half, axes.normal);
        const glm::dvec2 flat(glm::dot(half, axes.tangent), glm::dot(half, axes.bitangent));
        const double sine = glm::length(flat);
        const double turn = sine > 0 ? std::atan2(sine, along) / sine : 1;
        return f64::lobe_normalised_weight(lobe) *
               f64::lobe_value(lobe, {flat.x * turn, flat.y * turn});
    };
    for (const std::size_t n : {3U, 4U, 6U}) {
        const NormalLevel& level = levels[n];
        const std::size_t covered = size / level.width;
        const f64::BentNormal bent = f64::bent_normal(up, u, v,
                                                      {{level.lean_x[0], level.lean_y[0]},
                                                       {level.sd_x[0], level.sd_y[0]},
                                                       level.correlation[0]});
        const auto axes = f64::tangent_frame(bent.normal, u);
        const auto facet = [&](const f64::dvec3& turn) {
            return f64::Facet{glm::dot(turn, axes.tangent), glm::dot(turn, axes.bitangent)};
        };
        const auto wide =
            f64::lobe_form_widened(form, facet(bent.spread_a), facet(bent.spread_b), 1.0);
        EXPECT_LT(wide.scale, 0.5 * form.scale);  // or the test would hold nothing
        double peak = 0, worst = 0, energy = 0, expected_energy = 0;
        for (double i = -24; i <= 24; i += 3) {
            for (double j = -24; j <= 24; j += 3) {
                const f64::dvec3 half =
                    glm::normalize(bent.normal + 0.01 * (i * axes.tangent + j * axes.bitangent));
                double expected = 0;
                for (std::size_t k = 0; k < covered * covered; ++k) {
                    const std::size_t at = k / covered * size + k % covered;
                    const glm::dvec3 normal =
                        glm::normalize(glm::dvec3(levels[0].lean_x[at], levels[0].lean_y[at], 1));
                    expected +=
                        value_about(form, normal, half) / static_cast<double>(covered * covered);
                }
                const double got = value_about(wide, bent.normal, half);
                peak = std::max(peak, expected);
                worst = std::max(worst, std::abs(got - expected));
                // Solid angle of the step.
                const double solid = std::pow(glm::dot(half, bent.normal), 3);
                energy += solid * got;
                expected_energy += solid * expected;
            }
        }
        std::printf("level %zu: worst %.1f %% of the peak, energy %+.2f %%\n", n,
                    100 * worst / peak, 100 * (energy / expected_energy - 1));
        EXPECT_LT(worst, 0.15 * peak);
        EXPECT_NEAR(energy, expected_energy, 0.01 * expected_energy);
    }
}

TEST(NormalMips, WhatIsNoNormalIsMendedAndCounted) {
    const std::vector<float> rgb{nan32, 0.5F, 1, 0.5F, 0.5F, 0.5F, inf32, 0,    0,  // none
                                 1,     0.5F, 0, 1,    0.5F, 0.5F, 0.5F,  0.5F, 0.75F};
    NormalRepair repair;
    const auto levels = normal_levels({rgb.data(), 3, 6, 1}, repair);
    EXPECT_EQ(repair.without_normal, 3U);
    EXPECT_EQ(repair.too_steep, 2U);
    EXPECT_EQ(levels[0].lean_x, (std::vector<float>{0, 0, 0, 10, 10, 0}));
    EXPECT_NE(repair.sentence("map").find("3 texels hold no normal"), std::string::npos);
    EXPECT_THROW((void)normal_levels({rgb.data(), 3, 0, 1}, repair), InputError);
    for (const NormalLevel& level : levels) {
        for (const float lean : level.lean_x) EXPECT_TRUE(std::isfinite(lean));
    }
}

TEST(NormalMips, ABentNormalNeverMirrorsIntoTheSurface) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const glm::dvec3 up(0, 0, 1);
    int turned = 0;
    for (int k = 0; k < 2000; ++k) {
        const glm::dvec3 view = glm::normalize(
            glm::dvec3(unit(random), unit(random), std::pow(10, 2 * unit(random) - 2)));
        const glm::dvec3 bent = glm::normalize(glm::dvec3(3 * unit(random), 3 * unit(random), 1));
        const auto n = f64::normal_mirroring_outwards(bent, up, view);
        const auto height = [&](const glm::dvec3& by) {
            return 2 * glm::dot(by, view) * by.z - view.z;
        };
        const double limit = std::min(0.9 * view.z, 0.01);
        EXPECT_NEAR(glm::length(n), 1, 1e-12);
        EXPECT_GT(glm::dot(n, view), 0);
        EXPECT_GE(height(n), limit - 1e-12);
        if (height(bent) >= limit) {
            EXPECT_EQ(n, bent);
        } else {
            ++turned;
            EXPECT_NEAR(height(n), limit, 1e-12);  // and no farther
        }
        const auto single =
            f32::normal_mirroring_outwards(glm::vec3(bent), glm::vec3(up), glm::vec3(view));
        EXPECT_NEAR(glm::length(single - glm::vec3(n)), 0, 2e-3);
    }
    EXPECT_GT(turned, 200);
    EXPECT_EQ(f64::normal_mirroring_outwards({0.6, 0, 0.8}, up, {0.6, 0, -0.8}), up);
    EXPECT_EQ(f64::normal_mirroring_outwards({0.6, 0, 0.8}, up, {nan32, 0, 1}), up);
}

}  // namespace
