// shaders/shared/lobe.glsl and frame.glsl: meaning of the numbers, round trips, defined results,
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
constexpr double degree = std::numbers::pi / 180.0;
constexpr float nan32 = std::numeric_limits<float>::quiet_NaN();
constexpr float inf32 = std::numeric_limits<float>::infinity();

f64::Facet facet_at(double phi_deg, double azimuth_deg) {
    const double phi = phi_deg * degree, azimuth = azimuth_deg * degree;
    const glm::dvec3 half_vector(std::sin(phi) * std::cos(azimuth),
                                 std::sin(phi) * std::sin(azimuth), std::cos(phi));
    const glm::dvec3 up(0, 0, 1);
    return f64::facet_of({glm::cross(up, half_vector), half_vector.z, 1.0}, {1, 0, 0}, {0, 1, 0});
}

double lobe_at(double mu_t_deg, double mu_b_deg, double rho_deg, double phi_deg,
               double azimuth_deg) {
    const auto lobe = f64::lobe_from_mu(mu_t_deg * degree, mu_b_deg * degree, rho_deg * degree);
    return f64::lobe_value(f64::lobe_form(lobe), facet_at(phi_deg, azimuth_deg));
}

TEST(Lobe, ConstantsAreWhatTheirNamesSay) {
    EXPECT_EQ(TG_LN_RAD_PER_DEG, static_cast<float>(std::log(degree)));
    EXPECT_DOUBLE_EQ(f64::lobe_from_mu(degree, degree, 0).ln_mu_deg, 0.0);
    EXPECT_NEAR(f64::lobe_axes({0, 0, 0}).mu_t_rad, degree, 1e-17);
}

TEST(Lobe, HalfWidthsAreWhereDIsAHalf) {
    for (const double mu_t : {0.001, 0.1, 0.8, 5.0, 40.0}) {
        for (const double aspect : {1.0, 3.0, 100.0}) {
            const double mu_b = std::max(mu_t / aspect, 0.001);
            for (const double rho : {0.0, 30.0, 90.0, 135.0, 179.0}) {
                EXPECT_NEAR(lobe_at(mu_t, mu_b, rho, 0, 0), 1.0, 1e-15);
                EXPECT_NEAR(lobe_at(mu_t, mu_b, rho, mu_t, rho), 0.5, 1e-12);
                EXPECT_NEAR(lobe_at(mu_t, mu_b, rho, mu_t, rho + 180), 0.5, 1e-12);
                EXPECT_NEAR(lobe_at(mu_t, mu_b, rho, mu_b, rho + 90), 0.5, 1e-12);
                EXPECT_NEAR(lobe_at(mu_t, mu_b, rho, 2 * mu_b, rho - 90), 0.0625, 1e-12);
            }
        }
    }
}

TEST(Lobe, IsTheStatedFormulaAtAnyAzimuth) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 20'000; ++i) {
        const double mu_b = 0.001 * std::pow(8e4, unit(random));
        const double mu_t = std::min(80.0, mu_b * std::pow(100.0, unit(random)));
        const double rho = 180 * unit(random), azimuth = 360 * unit(random);
        const double psi = (azimuth - rho) * degree;
        const double width2 =
            1 / (std::pow(std::cos(psi) / mu_t, 2) + std::pow(std::sin(psi) / mu_b, 2));
        const double phi = std::min(89.0, 2.0 * std::sqrt(width2) * unit(random));
        const double expected = std::exp(-std::numbers::ln2 * phi * phi / width2);
        ASSERT_NEAR(lobe_at(mu_t, mu_b, rho, phi, azimuth), expected, 1e-10);
    }
}

TEST(Lobe, HighlightIsLongAcrossTheStrokes) {
    // Strokes along T: rho + 90 = 0 (or 180), so rho = 90; facets tilt further across T than along
    // it.
    const double strokes_deg = 0, rho_deg = strokes_deg + 90;
    EXPECT_GT(lobe_at(3, 1, rho_deg, 2, strokes_deg + 90), 0.5);
    EXPECT_LT(lobe_at(3, 1, rho_deg, 2, strokes_deg), 0.1);
    // Counter-clockwise seen from outside: the wide axis at 45 degrees lies between +T and +B = N x
    // T.
    EXPECT_GT(lobe_at(3, 1, 45, 2, 45), 0.5);
    EXPECT_LT(lobe_at(3, 1, 45, 2, 135), 0.1);
}

TEST(Lobe, HalfATurnOfRhoChangesNothing) {
    for (const double rho : {0.0, 20.0, 100.0}) {
        const auto a = f64::lobe_from_mu(0.03, 0.01, rho * degree);
        const auto b = f64::lobe_from_mu(0.03, 0.01, (rho + 180) * degree);
        EXPECT_NEAR(a.e1, b.e1, 1e-15);
        EXPECT_NEAR(a.e2, b.e2, 1e-15);
        EXPECT_EQ(a.ln_mu_deg, b.ln_mu_deg);
    }
}

TEST(Lobe, SwappedAxesAreTheSameLobeTurnedByARightAngle) {
    const auto a = f64::lobe_from_mu(0.01, 0.03, 10 * degree);
    const auto b = f64::lobe_from_mu(0.03, 0.01, 100 * degree);
    EXPECT_NEAR(a.e1, b.e1, 1e-15);
    EXPECT_NEAR(a.e2, b.e2, 1e-15);
}

TEST(Lobe, StoredFormComesBack) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 50'000; ++i) {
        const double mu_b = 0.001 * std::pow(8e4, unit(random)) * degree;
        const double mu_t = std::min(80 * degree, mu_b * std::pow(99.999, unit(random)));
        const double rho = std::numbers::pi * unit(random);
        const auto axes = f64::lobe_axes(f64::lobe_from_mu(mu_t, mu_b, rho));
        ASSERT_NEAR(axes.mu_t_rad / mu_t, 1, 1e-12);
        ASSERT_NEAR(axes.mu_b_rad / mu_b, 1, 1e-12);
        const double aspect = std::log(mu_t / mu_b);
        if (aspect > 1e-6) {
            ASSERT_NEAR(std::sin(axes.rho_rad - rho), 0, 1e-15 / aspect + 1e-14);
        }
        ASSERT_TRUE(axes.rho_rad >= 0 && axes.rho_rad < std::numbers::pi);
        const auto axes32 = f32::lobe_axes(f32::lobe_from_mu(
            static_cast<float>(mu_t), static_cast<float>(mu_b), static_cast<float>(rho)));
        ASSERT_NEAR(axes32.mu_t_rad / mu_t, 1, 4e-6);
        ASSERT_NEAR(axes32.mu_b_rad / mu_b, 1, 4e-6);
    }
    const auto round = f64::lobe_axes(f64::lobe_from_mu(0.02, 0.02, 1.0));
    EXPECT_EQ(round.rho_rad, 0.0);
}

TEST(Lobe, SmallShapesJoinTheSeriesSmoothly) {
    for (const double r : {0.02999, 0.0300001}) {
        const auto shape = f64::lobe_shape(r, 0.0);
        EXPECT_NEAR(shape.sinh_2r_over_r, std::sinh(2 * r) / r, 1e-8);
        const auto shape32 = f32::lobe_shape(static_cast<float>(r), 0.0F);
        EXPECT_NEAR(shape32.sinh_2r_over_r, std::sinh(2 * r) / r, 2e-5);
    }
    EXPECT_EQ(f64::lobe_shape(0, 0).sinh_2r_over_r, 2.0);
}

TEST(Lobe, FormHasTheDeterminantOfItsScale) {
    for (const double aspect : {1.0, 2.0, 30.0, 99.0}) {
        const auto form = f64::lobe_form(f64::lobe_from_mu(0.1, 0.1 / aspect, 0.7));
        EXPECT_NEAR((form.xx * form.yy - form.xy * form.xy) / (form.scale * form.scale), 1, 1e-11);
        EXPECT_NEAR(form.scale, std::numbers::ln2 * aspect / 0.01, 1e-9 * form.scale);
        EXPECT_NEAR(f64::lobe_normalised_weight(form), form.scale / (4 * std::numbers::pi), 1e-6);
    }
}

TEST(Lobe, MomentsAndBack) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 20'000; ++i) {
        const double mu_b = 0.001 * std::pow(1e3, unit(random)) * degree;
        const double aspect = std::pow(99.0, unit(random));
        const auto lobe = f64::lobe_from_mu(mu_b * aspect, mu_b, std::numbers::pi * unit(random));
        const auto moments = f64::lobe_moments(lobe, f64::lobe_shape(lobe.e1, lobe.e2));
        const auto back = f64::lobe_from_moments(moments);
        ASSERT_NEAR(back.ln_mu_deg, lobe.ln_mu_deg, 1e-10);
        ASSERT_NEAR(back.e1, lobe.e1, 1e-10);
        ASSERT_NEAR(back.e2, lobe.e2, 1e-10);
        // The moments are the inverse of the form: xx of both along one axis give 1/(2 ln2) of each
        // other's unit.
        const auto form = f64::lobe_form(lobe);
        const double unit_deg2 = std::numbers::ln2 / (degree * degree);
        ASSERT_NEAR(form.xx * moments.xx + form.xy * moments.xy, unit_deg2,
                    1e-12 * unit_deg2 * aspect * aspect);
        const f32::LobeMoments m32{static_cast<float>(moments.xx), static_cast<float>(moments.xy),
                                   static_cast<float>(moments.yy)};
        const auto back32 = f32::lobe_from_moments(m32);
        const double tolerance = 2e-6 + 1e-7 * aspect * aspect;
        ASSERT_NEAR(back32.ln_mu_deg, lobe.ln_mu_deg, tolerance) << aspect;
        ASSERT_NEAR(back32.e1, lobe.e1, tolerance) << aspect;
        ASSERT_NEAR(back32.e2, lobe.e2, tolerance) << aspect;
    }
    const auto nothing = f32::lobe_from_moments({0, 0, 0});
    EXPECT_EQ(nothing.ln_mu_deg, 0.0F);
    const auto flat = f64::lobe_from_moments({1, 0, 0});  // no width at all across
    EXPECT_NEAR(flat.e1, std::log(10.0), 1e-12);
}

void expect_lobe(const f32::Lobe& lobe, float ln_mu, float e1, float e2) {
    EXPECT_FLOAT_EQ(lobe.ln_mu_deg, ln_mu);
    EXPECT_FLOAT_EQ(lobe.e1, e1);
    EXPECT_FLOAT_EQ(lobe.e2, e2);
}

TEST(Lobe, WhatAMapMayHoldIsBroughtIntoRange) {
    const auto sane = [](float ln_mu, float e1, float e2) {
        return f32::sanitise_lobe({ln_mu, e1, e2});
    };
    const float lowest = std::log(0.001F), highest = std::log(80.0F), longest = std::log(10.0F);
    expect_lobe(sane(0.5F, 0.3F, -0.2F), 0.5F, 0.3F, -0.2F);
    expect_lobe(sane(-20, 0, 0), lowest, 0, 0);
    expect_lobe(sane(20, 0, 0), highest, 0, 0);
    expect_lobe(sane(inf32, 0, 0), highest, 0, 0);
    expect_lobe(sane(-inf32, 0, 0), lowest, 0, 0);
    expect_lobe(sane(nan32, 0, 0), 0, 0, 0);
    expect_lobe(sane(0, 100, 0), 0, longest, 0);
    expect_lobe(sane(0, 0, -5), 0, 0, -longest);
    expect_lobe(sane(0, 3e4F, 4e4F), 0, 0.6F * longest, 0.8F * longest);
    expect_lobe(sane(0, nan32, 1), 0, 0, 0);
    expect_lobe(sane(0, 1, inf32), 0, 0, 0);
    expect_lobe(sane(0, 3e38F, 3e38F), 0, 0, 0);
}

TEST(Lobe, FromMuOfAnyNumberIsDefined) {
    const float lowest = std::log(0.001F);
    EXPECT_NEAR(f32::lobe_from_mu(0, 0, 0).ln_mu_deg, lowest, 1e-5);
    EXPECT_NEAR(f32::lobe_from_mu(-1, -1, 0).ln_mu_deg, lowest, 1e-5);
    EXPECT_NEAR(f32::lobe_from_mu(nan32, nan32, 0).ln_mu_deg, 0, 1e-5);
    EXPECT_NEAR(f32::lobe_from_mu(inf32, inf32, 0).ln_mu_deg, std::log(80.0), 1e-5);
    const auto turned = f32::lobe_from_mu(0.02F, 0.01F, nan32);
    EXPECT_EQ(turned.e1, 0.0F);
    EXPECT_EQ(turned.e2, 0.0F);
}

TEST(Lobe, NothingInAMapMakesNaN) {
    const std::array<float, 16> nasty{0,      1,     -1,    nan32, inf32,  -inf32, 1e-30F, 2.3F,
                                      -2.31F, 88.0F, -88.F, 1e18F, -1e30F, 3e38F,  0.03F,  -6.9F};
    const std::array<float, 7> offsets{0, 1e-30F, 1e-6F, 0.01F, 0.5F, -1.2F, 1.57F};
    for (const float ln_mu : nasty) {
        EXPECT_TRUE(std::isfinite(f32::lobe_form_isotropic(ln_mu).scale));
        for (const float e1 : nasty) {
            for (const float e2 : nasty) {
                const auto form = f32::lobe_form({ln_mu, e1, e2});
                const auto form64 = f64::lobe_form({ln_mu, e1, e2});
                ASSERT_TRUE(std::isfinite(form.xx) && std::isfinite(form.xy) &&
                            std::isfinite(form.yy) && std::isfinite(form.scale) && form.scale > 0);
                ASSERT_NEAR(form.scale / form64.scale, 1, 1e-5);
                for (const float dx : offsets) {
                    for (const float dy : offsets) {
                        const float value = f32::lobe_value(form, {dx, dy});
                        ASSERT_TRUE(value >= 0 && value <= 1) << ln_mu << ' ' << e1 << ' ' << e2;
                    }
                }
            }
        }
    }
}

// Random unit vectors; every fourth within 1e-5..1 of the pole, where lobes live.
glm::vec3 direction(std::mt19937& random, const glm::vec3& pole, int i) {
    std::normal_distribution<float> normal;
    const glm::vec3 v = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    if (i % 2 == 0) return v;
    return glm::normalize(pole + v * std::pow(10.0F, -static_cast<float>(i % 6)));
}

TEST(Lobe, FloatAgreesWithDoubleOnTheSameInput) {
    std::mt19937 random(17);
    std::uniform_real_distribution<float> unit(0, 1);
    double worst_facet = 0, worst_value = 0;
    for (int i = 0; i < 200'000; ++i) {
        const glm::vec3 normal = direction(random, {0, 0, 1}, 0),
                        tangent = direction(random, normal, 0);
        const glm::vec3 half_vector = direction(random, normal, i);
        const auto frame = f32::tangent_frame(normal, tangent);
        const auto frame64 = f64::tangent_frame(normal, tangent);
        if (std::abs(glm::dot(normal, tangent)) > 0.99F)
            continue;  // axes ill-defined by the input itself
        // L = V = H, so that S = 2 H.
        const auto facet = f32::facet_of(f32::half_angle(frame.normal, half_vector, half_vector),
                                         frame.tangent, frame.bitangent);
        const auto facet64 = f64::facet_of(
            f64::half_angle(frame64.normal, glm::dvec3(half_vector), glm::dvec3(half_vector)),
            frame64.tangent, frame64.bitangent);
        const double away = std::hypot(facet64.dx, facet64.dy);
        // At H near -N the azimuth jumps; no lit point is beyond 90 degrees.
        if (away > std::numbers::pi / 2) continue;
        const double error = std::hypot(facet.dx - facet64.dx, facet.dy - facet64.dy);
        worst_facet = std::max(worst_facet, error / (1 + 3 * away));
        const double mu_b = 0.01 * std::pow(8e2, unit(random)),
                     aspect = std::pow(100.0, unit(random));
        const float rho = 3.14F * unit(random);
        const auto lobe = f32::lobe_from_mu(static_cast<float>(mu_b * aspect * degree),
                                            static_cast<float>(mu_b * degree), rho);
        const double value = f32::lobe_value(f32::lobe_form(lobe), facet);
        const double value64 =
            f64::lobe_value(f64::lobe_form({lobe.ln_mu_deg, lobe.e1, lobe.e2}), facet64);
        const double stated = 1e-6 + 3e-7 / (mu_b * degree) + 1e-7 * aspect * aspect;
        worst_value = std::max(worst_value, std::abs(value - value64) / stated);
    }
    EXPECT_LT(worst_facet, 3e-7);
    EXPECT_LT(worst_value, 1.0);
    RecordProperty("facet_rad", std::to_string(worst_facet * 1e7));
}

TEST(Frame, IsOrthonormalForAnyUsableInput) {
    std::mt19937 random(23);
    for (int i = 0; i < 100'000; ++i) {
        const glm::vec3 normal = direction(random, {0, 0, 1}, 0);
        // From perpendicular to parallel, in km and in nm.
        const float length = std::pow(10.0F, static_cast<float>(i % 25) - 12.0F);
        const glm::vec3 tangent = direction(random, normal, i) * length;
        const auto f = f32::tangent_frame(normal * (i % 3 == 0 ? 1e-9F : 1.0F), tangent);
        ASSERT_NEAR(glm::length(f.tangent), 1, 6e-6);
        ASSERT_NEAR(glm::length(f.bitangent), 1, 6e-6);
        ASSERT_NEAR(glm::dot(f.tangent, f.normal), 0, 1e-6);
        ASSERT_NEAR(glm::dot(f.bitangent, f.normal), 0, 1e-6);
        ASSERT_NEAR(glm::dot(f.bitangent, f.tangent), 0, 1e-6);
        ASSERT_NEAR(glm::dot(glm::cross(f.normal, f.tangent), f.bitangent), 1,
                    6e-6);  // right-handed
    }
}

TEST(Frame, DefinedResults) {
    const glm::vec3 up(0, 0, 1);
    for (const glm::vec3& tangent :
         {glm::vec3(0), up, -up, glm::vec3(nan32, 0, 0), glm::vec3(0, inf32, 0),
          glm::vec3(1e-6F, 0, 1), glm::vec3(1e30F)}) {
        for (const glm::vec3& normal : {up, glm::vec3(1, 0, 0), glm::vec3(0.6F, 0, 0.8F)}) {
            const auto f = f32::tangent_frame(normal, tangent);
            EXPECT_NEAR(glm::length(f.tangent), 1, 1e-6);
            EXPECT_NEAR(glm::length(f.bitangent), 1, 1e-6);
            EXPECT_NEAR(glm::dot(f.tangent, f.normal), 0, 1e-6);
        }
    }
    for (const glm::vec3& normal :
         {glm::vec3(0), glm::vec3(nan32, 0, 1), glm::vec3(0, -inf32, 0)}) {
        for (const glm::vec3& tangent : {glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(nan32)}) {
            const auto f = f32::tangent_frame(normal, tangent);
            EXPECT_EQ(f.normal, glm::vec3(0));
            EXPECT_EQ(f.bitangent, glm::vec3(0));
            EXPECT_NEAR(glm::length(f.tangent), 1, 1e-6);
        }
    }
}

}  // namespace
