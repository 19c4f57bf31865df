// shaders/shared/surface.glsl and shadowing.glsl: energy, reciprocity, limits, defined results,
// float against double.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "brdf/model.hpp"

namespace {

namespace f32 = togishi::f32;
namespace f64 = togishi::f64;
using std::numbers::pi;
constexpr double degree = pi / 180.0;
constexpr float nan32 = std::numeric_limits<float>::quiet_NaN();
constexpr float inf32 = std::numeric_limits<float>::infinity();
const glm::dvec3 up(0, 0, 1), along(1, 0, 0), across(0, 1, 0);

glm::dvec3 polar(double theta, double azimuth) {
    return {std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth),
            std::cos(theta)};
}

struct Energy {
    double ji, hamon;
};

// Radiance towards V in a room of radiance 1 with F = 1: the integral over all light directions,
// taken over facet directions H, where the lobe is smooth (d omega_i = 4 V.H d omega_h, d omega_h =
// sin(phi)/phi d^2 d).
Energy furnace(double mu_t_deg, double mu_b_deg, double rho_deg, double view_deg,
               double view_azimuth_deg) {
    const auto lobe = f64::lobe_from_mu(mu_t_deg * degree, mu_b_deg * degree, rho_deg * degree);
    const auto form = f64::lobe_form(lobe);
    const glm::dvec3 view = polar(view_deg * degree, view_azimuth_deg * degree);
    constexpr int steps = 240;
    constexpr double reach = 4.8;  // in half widths: exp(-ln 2 4.8^2) = 1e-7
    const double step = 2 * reach / steps;
    Energy sum{0, 0};
    for (int i = 0; i < steps; ++i) {
        for (int j = 0; j < steps; ++j) {
            const double a = (-reach + (i + 0.5) * step) * mu_t_deg * degree;
            const double b = (-reach + (j + 0.5) * step) * mu_b_deg * degree;
            const double phi = std::hypot(a, b);
            if (phi >= pi / 2) continue;
            const glm::dvec3 half_vector = polar(phi, std::atan2(b, a) + rho_deg * degree);
            const double v_dot_h = glm::dot(view, half_vector);
            if (v_dot_h <= 0) continue;
            const glm::dvec3 light = 2.0 * v_dot_h * half_vector - view;
            const auto g = f64::light_geometry(up, along, across, view, light);
            const double solid = 4 * v_dot_h * std::sin(phi) / phi;
            sum.ji += f64::ji_reflection(form, g, -1.0) * solid;
            sum.hamon += f64::hamon_reflection(form, g, -1.0) * solid;
        }
    }
    const double cell = step * step * mu_t_deg * mu_b_deg * degree * degree;
    return {sum.ji * cell, sum.hamon * cell};
}

TEST(Furnace, NormalisedWeightsKeepTheEnergyAtAnyIncidence) {
    struct Case {
        double mu_t, mu_b, rho;
    };
    for (const Case& c : {Case{0.01, 0.01, 0},
                          {0.5, 0.5, 0},
                          {0.8, 0.4, 60},
                          {2, 2, 0},
                          {5, 5, 0},
                          {5, 1, 0},
                          {5, 1, 90},
                          {5, 0.05, 30},
                          {5, 2.5, 135}}) {
        for (const double view : {0.0, 30.0, 60.0, 75.0, 80.0, 85.0, 88.0, 89.5, 89.9}) {
            const Energy e = furnace(c.mu_t, c.mu_b, c.rho, view, 20);
            EXPECT_GE(e.ji, 0.929) << c.mu_t << ' ' << c.mu_b << ' ' << c.rho << " view " << view;
            EXPECT_LE(e.ji, 1.001) << c.mu_t << ' ' << c.mu_b << ' ' << c.rho << " view " << view;
            EXPECT_EQ(e.ji,
                      e.hamon);  // with F = 1 and normalised weights they are the same formula
        }
    }
}

TEST(Furnace, SmoothLimitIsAPerfectMirror) {
    for (const double view : {0.0, 45.0, 80.0, 89.0}) {
        EXPECT_NEAR(furnace(0.01, 0.01, 0, view, 0).ji, 1.0, 2e-4) << view;
    }
}

TEST(Furnace, MeasuredChiDarkensAsTheCosine) {
    // The paper's form with a constant chi: the reason why the normalised weight carries
    // G/cos(theta_r).
    const auto form = f64::lobe_form(f64::lobe_from_mu(degree, degree, 0));
    const double chi = f64::lobe_normalised_weight(form);
    for (const double view_deg : {0.0, 60.0}) {
        const glm::dvec3 view = polar(view_deg * degree, 0), light = polar(view_deg * degree, pi);
        const auto g = f64::light_geometry(up, along, across, view, light);
        EXPECT_NEAR(f64::ji_reflection(form, g, chi) / f64::ji_reflection(form, g, -1.0),
                    std::cos(view_deg * degree), 1e-9);
    }
}

TEST(Shadowing, IsTheTextbookFormulaOverTheCosine) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 50'000; ++i) {
        const auto l = polar(std::acos(0.001 + 0.999 * unit(random)), 2 * pi * unit(random));
        const auto v = polar(std::acos(0.001 + 0.999 * unit(random)), 2 * pi * unit(random));
        const auto h = glm::normalize(l + v);
        const double g = std::min({1.0, 2 * h.z * v.z / dot(v, h), 2 * h.z * l.z / dot(v, h)});
        ASSERT_NEAR(f64::shadowing_over_cos_r(h.z, v.z, l.z, dot(v, h)) * v.z, g, 1e-12);
        ASSERT_LE(g, 1.0);
        ASSERT_GE(g, 0.0);
    }
}

TEST(Shadowing, Limits) {
    EXPECT_EQ(f64::shadowing_over_cos_r(1, 1, 1, 1), 1.0);  // normal incidence: nothing is shadowed
    // In the mirror direction G = 1 at every angle: 1/cos(theta_r).
    for (const double c : {0.9, 0.5, 0.01})
        EXPECT_NEAR(f64::shadowing_over_cos_r(1, c, c, c), 1 / c, 1e-9);
    // Grazing view, light overhead (theta_H = 45): G/cos(theta_r) tends to 2 (N.H)/(V.H) = 2, not
    // to infinity.
    EXPECT_NEAR(f64::shadowing_over_cos_r(std::sqrt(0.5), 1e-9, 1, std::sqrt(0.5)), 2.0, 1e-6);
    // Nowhere above 1/TG_MIN_COS.
    EXPECT_LE(f32::shadowing_over_cos_r(1, 1e-4F, 1e-4F, 1e-7F), 1.0001e4F);
}

TEST(Surface, HamonTimesCosineIsReciprocal) {
    const auto form = f64::lobe_form(f64::lobe_from_mu(20 * degree, 8 * degree, 0.4));
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(0, 1);
    double sum = 0;
    for (int i = 0; i < 20'000; ++i) {
        const auto a = polar(1.55 * unit(random), 2 * pi * unit(random));
        const auto b = polar(1.55 * unit(random), 2 * pi * unit(random));
        const auto ab = f64::light_geometry(up, along, across, a, b);
        const auto ba = f64::light_geometry(up, along, across, b, a);
        // Radiance per irradiance facing the light, times cos(theta_r): the BRDF times both
        // cosines.
        const double forth = f64::hamon_reflection(form, ab, 3.0) * a.z *
                             f64::fresnel_conductor(2.95, 2.93, ab.cos_h);
        const double back = f64::hamon_reflection(form, ba, 3.0) * b.z *
                            f64::fresnel_conductor(2.95, 2.93, ba.cos_h);
        ASSERT_NEAR(forth, back, 1e-12 * (1 + forth));
        sum += forth;
        // The ji's weight too; its F(theta_i) is not: the paper's Eq. 1 takes the angle of the
        // light.
        ASSERT_NEAR(f64::ji_reflection(form, ab, -1.0) * a.z,
                    f64::ji_reflection(form, ba, -1.0) * b.z, 1e-12);
    }
    EXPECT_GT(sum, 1.0);
}

TEST(Surface, PeakStandsInTheMirrorDirection) {
    // C = beta F D G/cos(theta_r): at the mirror direction D = G = 1 and theta_H = theta_i.
    const double theta = 40 * degree;
    const auto form = f64::lobe_form(f64::lobe_from_mu(degree, degree, 0));
    const auto g = f64::light_geometry(up, along, across, polar(theta, 0), polar(theta, pi));
    EXPECT_NEAR(g.cos_h, std::cos(theta), 1e-14);
    EXPECT_NEAR(g.cos_i, std::cos(theta), 1e-14);
    EXPECT_NEAR(f64::hamon_reflection(form, g, 2.5), 2.5 / std::cos(theta), 1e-12);
    EXPECT_NEAR(f64::ji_reflection(form, g, 2.5), 2.5, 1e-12);
    const double normalised = std::numbers::ln2 / (4 * pi * degree * degree);
    EXPECT_NEAR(f64::hamon_reflection(form, g, -1), normalised / std::cos(theta), 1e-8);
    // A light 2 mu off turns H by mu: half of the peak.
    const auto off =
        f64::light_geometry(up, along, across, polar(theta, 0), polar(theta + 2 * degree, pi));
    EXPECT_NEAR(f64::ji_reflection(form, off, 2.5), 1.25, 1e-9);
}

TEST(Surface, BlendIsTheDesignsFormula) {
    const auto r = f64::blend_reflection(2, 3, 5, 0.25, 0.4);
    EXPECT_NEAR(r.at_theta_i, 0.75 * 0.6 * 2, 1e-15);
    EXPECT_NEAR(r.at_theta_h, 0.75 * 0.4 * 3 + 0.25 * 5, 1e-15);
    // What a map may hold by mistake.
    EXPECT_EQ(f32::blend_reflection(2, 3, 5, nan32, nan32).at_theta_i, 2.0F);
    EXPECT_EQ(f32::blend_reflection(2, 3, 5, inf32, 0).at_theta_h, 5.0F);
    EXPECT_EQ(f32::blend_reflection(2, 3, 5, -1, -7).at_theta_i, 2.0F);
    EXPECT_EQ(f32::blend_reflection(2, 3, 5, 1.5F, 0).at_theta_i, 0.0F);
}

bool is_dark(const f32::LightGeometry& g) {
    return g.lit == 0 && g.cos_i == 0 && g.cos_h == 0 && g.g_over_cos_r == 0 && g.facet.dx == 0 &&
           g.facet.dy == 0;
}

TEST(Surface, NothingIsReflectedWhereNothingCanBe) {
    const glm::vec3 n(0, 0, 1), t(1, 0, 0), b(0, 1, 0), in(0.6F, 0, 0.8F);
    for (const glm::vec3& dark :
         {glm::vec3(1, 0, 0), glm::vec3(0, 0, -1), -in, glm::vec3(0), glm::vec3(nan32, 0, 1),
          glm::vec3(nan32), glm::vec3(inf32, 0, 1), glm::vec3(-inf32, 0, inf32),
          glm::normalize(glm::vec3(1, 0, 0.99e-4F))}) {
        EXPECT_TRUE(is_dark(f32::light_geometry(n, t, b, in, dark)));
        EXPECT_TRUE(is_dark(f32::light_geometry(n, t, b, dark, in)));
        EXPECT_TRUE(is_dark(f32::light_geometry(n, t, b, dark, -dark)));
    }
    EXPECT_TRUE(is_dark(f32::light_geometry(glm::vec3(0), t, b, in, in)));
    EXPECT_TRUE(is_dark(f32::light_geometry(glm::vec3(nan32), t, b, in, in)));
    EXPECT_FALSE(is_dark(f32::light_geometry(n, t, b, in, in)));
    EXPECT_FALSE(
        is_dark(f32::light_geometry(n, t, b, in, glm::normalize(glm::vec3(1, 0, 1.1e-4F)))));
}

TEST(Surface, ExtremesStayFiniteAndFloatNearDouble) {
    std::mt19937 random(9);
    std::uniform_real_distribution<float> unit(0, 1);
    std::normal_distribution<float> normal;
    const auto unit_vector = [&] {
        return glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    };
    const auto grazing =
        [&](const glm::vec3& n) {  // within 1e-1 .. 1e-6 of the horizon, either side
            const glm::vec3 v = unit_vector();
            const glm::vec3 flat = glm::normalize(v - n * glm::dot(n, v));
            const float off =
                std::pow(10.0F, -1 - 5 * unit(random)) * (unit(random) < 0.2F ? -1.0F : 1.0F);
            return glm::normalize(flat + n * off);
        };
    int lit = 0;
    for (int i = 0; i < 300'000; ++i) {
        const glm::vec3 n = unit_vector();
        const glm::vec3 t = i % 10 == 0 ? n : i % 10 == 1 ? glm::vec3(0) : unit_vector();
        const glm::vec3 v = i % 3 == 0 ? grazing(n) : unit_vector();
        const glm::vec3 l = i % 7 == 0   ? -v
                            : i % 7 == 1 ? grazing(n)
                            : i % 7 < 5
                                ? glm::normalize(2 * glm::dot(n, v) * n - v + 0.02F * unit_vector())
                                : unit_vector();
        const double mu_b = 0.001 * std::pow(8e4, unit(random));
        const double aspect = std::min(80 / mu_b, std::pow(100.0, unit(random)));
        const auto lobe = f32::lobe_from_mu(static_cast<float>(mu_b * aspect * degree),
                                            static_cast<float>(mu_b * degree), 7 * unit(random));
        const auto f = f32::tangent_frame(n, t);
        const auto g = f32::light_geometry(f.normal, f.tangent, f.bitangent, v, l);
        const auto form = f32::lobe_form(lobe);
        for (const float measured : {-1.0F, 0.0F, 1e8F}) {
            const float ji = f32::ji_reflection(form, g, measured);
            const float hamon = f32::hamon_reflection(form, g, measured);
            ASSERT_TRUE(std::isfinite(ji) && ji >= 0 && std::isfinite(hamon) && hamon >= 0);
            const auto r = f32::blend_reflection(ji, hamon, hamon, unit(random), unit(random));
            ASSERT_TRUE(std::isfinite(r.at_theta_i) && std::isfinite(r.at_theta_h));
            ASSERT_TRUE(g.lit == 1 || (ji == 0 && hamon == 0));
        }
        // Agreement where the light is not within rounding of a limit.
        const auto f64_frame = f64::tangent_frame(n, t);
        const auto g64 =
            f64::light_geometry(f64_frame.normal, f64_frame.tangent, f64_frame.bitangent, v, l);
        const double nv = glm::dot(glm::dvec3(n), glm::dvec3(v)),
                     nl = glm::dot(glm::dvec3(n), glm::dvec3(l));
        if (std::abs(nv - 1e-4) < 1e-6 || std::abs(nl - 1e-4) < 1e-6) continue;
        ASSERT_EQ(g.lit, g64.lit);
        if (g.lit == 0 || (i % 10 == 0)) continue;
        ++lit;
        // Cosines carry 2e-7; where L is nearly -V, H itself carries 1e-7/|L + V|.
        const double cosine = std::min(nv, nl);
        const double opposed = 1e-7 / g64.cos_h;
        ASSERT_NEAR(g.cos_i, g64.cos_i, 4e-7);
        ASSERT_NEAR(g.cos_h, g64.cos_h, 4e-7);
        ASSERT_NEAR(g.g_over_cos_r / g64.g_over_cos_r, 1, 1e-6 / cosine + 6 * opposed);
        const double value = f32::lobe_value(form, g.facet);
        const double value64 =
            f64::lobe_value(f64::lobe_form({lobe.ln_mu_deg, lobe.e1, lobe.e2}), g64.facet);
        ASSERT_NEAR(value, value64,
                    1e-6 + (3e-7 + 3 * opposed) / (mu_b * degree) + 1e-7 * aspect * aspect);
    }
    EXPECT_GT(lit, 50'000);
}

TEST(Plain, LambertAndGloss) {
    const auto g = f64::light_geometry(up, along, across, polar(0.3, 0), polar(0.7, 1));
    EXPECT_NEAR(f64::plain_diffuse(g), std::cos(0.7) / pi, 1e-15);
    const auto below = f64::light_geometry(up, along, across, polar(0.3, 0), polar(2.0, 1));
    EXPECT_EQ(f64::plain_diffuse(below), 0.0);
    const auto form = f64::lobe_form(f64::lobe_from_mu(0.1, 0.1, 0));
    EXPECT_NEAR(f64::plain_gloss(form, g, 1.5),
                f64::hamon_reflection(form, g, -1) * f64::fresnel_conductor(1.5, 0, g.cos_h),
                1e-15);
    EXPECT_GT(f64::plain_gloss(form, g, 1.5), 0.0);
}

TEST(Table, PositionAndCosineAreInverse) {
    for (const double size : {2.0, 64.0, 256.0}) {
        EXPECT_EQ(f64::fresnel_table_position(0, size), 0.0);
        EXPECT_EQ(f64::fresnel_table_position(1, size), size - 1);
        EXPECT_EQ(f64::fresnel_table_position(-3, size), 0.0);
        EXPECT_EQ(f64::fresnel_table_position(7, size), size - 1);
        for (double c = 0; c <= 1; c += 0.01) {
            EXPECT_NEAR(f64::fresnel_table_cosine(f64::fresnel_table_position(c, size), size), c,
                        1e-14);
        }
    }
}

}  // namespace
