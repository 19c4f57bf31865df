// The double-precision reference: its stated limits, symmetries and refusals. Values against numpy:
// tests/python/test_reference.py.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "brdf/model.hpp"
#include "reference/reference.hpp"
#include "spectral/metal.hpp"

namespace togishi {
namespace {

using glm::dvec3;
using V = std::vector<dvec3>;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

dvec3 polar(double theta_deg, double azimuth_deg) {
    const double t = theta_deg * std::numbers::pi / 180, a = azimuth_deg * std::numbers::pi / 180;
    return {std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)};
}

StoredLobe lobe(double mu_t_deg, double mu_b_deg, double rho_deg) {
    const double half = std::log(mu_t_deg / mu_b_deg) / 2, turn = rho_deg * std::numbers::pi / 90;
    return {std::log(mu_t_deg * mu_b_deg) / 2, half * std::cos(turn), half * std::sin(turn)};
}

// Owns what a ReferenceScene looks at. One point that faces +Z under one light, unless changed.
struct Scene {
    std::string metal = "iron_johnson_christy";
    std::vector<std::string> lights{"D65"};
    std::vector<std::int32_t> light_of{0};
    V normal{{0, 0, 1}}, tangent{{1, 0, 0}}, view{polar(40, 0)}, light{polar(43, 175)};
    std::vector<double> irradiance{1};
    std::vector<StoredLobe> ji{lobe(2, 1, 30)}, hadori{lobe(3, 3, 0)}, ha{lobe(6, 5, 80)};
    std::vector<double> w{0.3}, h{0.4};
    double chi = -1, beta_hadori = -1, beta_ha = -1;
    std::optional<std::pair<std::string, double>> world;
    std::string observer = "cie1931_2";
    ReferenceGrid grid = ReferenceGrid::samples_61;

    [[nodiscard]] V xyz(unsigned threads = 1) const {
        return reference_xyz({metal,
                              lights,
                              light_of,
                              normal,
                              tangent,
                              view,
                              light,
                              irradiance,
                              {ji},
                              {hadori},
                              {ha},
                              {w},
                              {h},
                              chi,
                              beta_hadori,
                              beta_ha,
                              world,
                              observer,
                              grid},
                             threads);
    }
    [[nodiscard]] double y() const { return xyz()[0].y; }
};

void expect_near(const dvec3& a, const dvec3& b, double relative) {
    const double scale = std::max(std::abs(a.y), std::abs(b.y));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], relative * scale);
}

TEST(Reference, MirrorDirectionOfTheJiIsItsClosedForm) {
    // At the mirror direction D = 1 and G = 1 for a steep light: chi F(theta_i) of one line.
    Scene s;
    s.w = {0};
    s.h = {0};
    s.lights = {"line:550"};
    s.view = {polar(30, 0)};
    s.light = {polar(30, 180)};
    s.chi = 2;
    const auto index = find_metal(s.metal)->at(grid_61);
    const double f =
        f64::fresnel_conductor(index.n[30], index.k[30], std::cos(std::numbers::pi / 6));
    EXPECT_NEAR(s.y(), 2 * f, 1e-6 * f);
    // Half of it where the facet angle is the half width: the light turned by 2 mu.
    s.ji = {lobe(2, 2, 0)};
    const double in_mirror = s.y();
    s.view = {polar(32, 0)};
    s.light = {polar(28, 0)};
    s.normal = {polar(30 - 2, 0)};  // H at 30 degrees, N 2 degrees off
    s.light = {polar(28, 0)};
    EXPECT_NEAR(s.y() / in_mirror, 0.5, 0.01);
}

TEST(Reference, RoomIsFresnelTimesItsRadiance) {
    Scene s;
    s.light_of = {};
    s.light = {};
    s.irradiance = {};
    s.lights = {};
    s.world = {"line:550", 3.0};
    const auto index = find_metal(s.metal)->at(grid_61);
    for (const double theta : {0.0, 60.0, 89.0}) {
        s.view = {polar(theta, 20)};
        const double f = f64::fresnel_conductor(index.n[30], index.k[30],
                                                std::cos(theta * std::numbers::pi / 180));
        EXPECT_NEAR(s.y(), 3 * f, 1e-9) << theta;
    }
    s.view = {polar(90.1, 0)};
    EXPECT_EQ(s.y(), 0);
    for (const double wrong : {-1.0, nan, infinity}) {
        s.world->second = wrong;
        EXPECT_THROW((void)s.xyz(), InputError) << wrong;
    }
}

TEST(Reference, LightsAddAndLengthsDoNotMatter) {
    Scene one, other, both;
    other.lights = {"A"};
    other.light = {polar(37, 190)};
    other.irradiance = {2.5};
    both.lights = {"D65", "A"};
    both.light_of = {0, 1};
    both.light = {one.light[0] * 1e-150, other.light[0] * 1e150};
    both.irradiance = {1, 2.5};
    both.normal = {dvec3(0, 0, 1e-200)};
    both.tangent = {dvec3(1e200, 0, 0)};
    both.view = {one.view[0] * 1e8};
    expect_near(both.xyz()[0], one.xyz()[0] + other.xyz()[0], 1e-12);
    Scene bright;
    bright.irradiance = {1e8};
    expect_near(bright.xyz()[0], 1e8 * one.xyz()[0], 1e-12);
}

TEST(Reference, HalfATurnOfRhoAndATurnOfTheWholeScene) {
    Scene a;
    const dvec3 expected = a.xyz()[0];
    Scene b;
    b.ji = {lobe(2, 1, 210)};
    b.ha = {lobe(6, 5, 260)};
    expect_near(b.xyz()[0], expected, 1e-12);
    // x -> y -> z -> x
    Scene c;
    const auto turned = [](const dvec3& v) { return dvec3(v.z, v.x, v.y); };
    for (V* list : {&c.normal, &c.tangent, &c.view, &c.light})
        for (dvec3& v : *list) v = turned(v);
    expect_near(c.xyz()[0], expected, 1e-12);
}

TEST(Reference, DarkWhereItIsStated) {
    ASSERT_GT(Scene().y(), 0);
    const std::vector<dvec3> bad{{0, 0, 0}, {nan, 0, 1}, {infinity, 0, 1}};
    for (V Scene::*member : {&Scene::normal, &Scene::view, &Scene::light}) {
        for (const dvec3& v : bad) {
            Scene s;
            s.*member = {v};
            EXPECT_EQ(s.y(), 0);
        }
    }
    for (const double theta : {90.0, 90.5, 135.0, 180.0, 89.9999}) {
        Scene view, light;
        view.view = {polar(theta, 0)};
        light.light = {polar(theta, 180)};
        EXPECT_EQ(view.y(), 0) << theta;
        EXPECT_EQ(light.y(), 0) << theta;
    }
    for (const double irradiance : {0.0, -1.0, nan, infinity, -infinity}) {
        Scene s;
        s.irradiance = {irradiance};
        EXPECT_EQ(s.y(), 0) << irradiance;
    }
}

TEST(Reference, ExtremeGeometryStaysFiniteAndNotNegative) {
    const std::vector<dvec3> tangents{
        {1, 0, 0}, {0, 0, 1}, {0, 0, 0}, {nan, 1, 0}, {0, 0, -1e-300}};
    const std::vector<double> thetas{0, 1e-9, 45, 89, 89.99, 90};
    std::size_t lit = 0;
    Scene s;
    s.normal.clear();
    s.tangent.clear();
    s.view.clear();
    s.light.clear();
    s.irradiance.clear();
    s.ji.clear();
    s.hadori.clear();
    s.ha.clear();
    s.w.clear();
    s.h.clear();
    for (const dvec3& t : tangents) {
        for (const double view : thetas) {
            for (const double light : thetas) {
                for (const double azimuth : {0.0, 90.0, 180.0}) {
                    for (const double mu : {0.001, 1.0, 80.0, nan, 800.0}) {
                        for (const double aspect : {1.0, 100.0}) {
                            s.normal.emplace_back(0, 0, 1);
                            s.tangent.push_back(t);
                            s.view.push_back(polar(view, 0));
                            s.light.push_back(polar(light, azimuth));
                            s.irradiance.push_back(1e8);
                            s.ji.push_back(lobe(mu, mu / aspect, azimuth));
                            s.hadori.push_back({mu, nan, -infinity});
                            s.ha.push_back(lobe(mu, mu / aspect, 10));
                            s.w.push_back(aspect > 1 ? 0.5 : mu);
                            s.h.push_back(aspect > 1 ? nan : 0.5);
                        }
                    }
                }
            }
        }
    }
    s.light_of = {0};
    for (const dvec3& xyz : s.xyz(2)) {
        ASSERT_TRUE(std::isfinite(xyz.x) && std::isfinite(xyz.y) && std::isfinite(xyz.z));
        ASSERT_GE(std::min({xyz.x, xyz.y, xyz.z}), 0);
        lit += xyz.y > 0 ? 1 : 0;
    }
    EXPECT_GT(lit, s.normal.size() / 20) << "too dark to show anything";
}

TEST(Reference, LightAgainstTheViewIsDefined) {
    Scene s;
    s.view = {polar(89, 0)};
    s.light = {-polar(89, 0)};  // L = -V: no half vector
    EXPECT_EQ(s.y(), 0);
    s.view = {polar(89.99, 0)};
    s.light = {polar(89.99, 180)};  // nearly so, and both lit
    EXPECT_TRUE(std::isfinite(s.y()));
    EXPECT_GT(s.y(), 0);
}

TEST(Reference, ThreadsDoNotChangeTheSum) {
    Scene s;
    const std::size_t points = 300;
    s.normal.assign(points, {0, 0, 1});
    s.tangent.assign(points, {1, 0, 0});
    s.view.clear();
    s.light.clear();
    for (std::size_t p = 0; p < points; ++p) {
        s.view.push_back(polar(30 + 0.1 * static_cast<double>(p), 0));
        s.light.push_back(polar(45, 180));
    }
    s.irradiance.assign(points, 1);
    const V one = s.xyz(1), four = s.xyz(4);
    ASSERT_EQ(one.size(), points);
    for (std::size_t p = 0; p < points; ++p) EXPECT_EQ(one[p], four[p]);
}

TEST(Reference, GridsAgreeUnderASmoothLight) {
    Scene coarse, fine;
    fine.grid = ReferenceGrid::full_1nm;
    coarse.lights = fine.lights = {"A"};
    expect_near(coarse.xyz()[0], fine.xyz()[0], 2e-3);
}

TEST(Reference, WrongSizesAndNamesAreRefused) {
    const auto said = [](auto change) -> std::string {
        Scene s;
        change(s);
        try {
            (void)s.xyz();
        } catch (const InputError& error) {
            return error.what();
        }
        return "no error";
    };
    EXPECT_NE(said([](Scene& s) { s.tangent.clear(); }).find("tangent"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.view.push_back({}); }).find("view"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.light.clear(); }).find("light_direction"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.irradiance = {1, 2}; }).find("irradiance"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.ji.clear(); }).find("lobe_ji"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.hadori.resize(2); }).find("lobe_hadori"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.ha.resize(3); }).find("lobe_ha"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.w = {}; }).find("w is"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.h = {0, 0}; }).find("h is"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.light_of = {1}; }).find("light_of"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.light_of = {-1}; }).find("light_of"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.metal = "tin"; }).find("tin"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.lights = {"D66"}; }).find("D66"), std::string::npos);
    EXPECT_NE(said([](Scene& s) { s.observer = "me"; }).find("me"), std::string::npos);
}

TEST(Reference, NoPointsAndNoLights) {
    Scene s;
    s.light_of = {};
    s.light = {};
    s.irradiance = {};
    EXPECT_EQ(s.y(), 0);
    s.normal = s.tangent = s.view = {};
    EXPECT_TRUE(s.xyz().empty());
}

}  // namespace
}  // namespace togishi
