// shaders/shared/area/lobe_filter.glsl and environment_taps.glsl: what a pixel sees of a lobe, and
// a lobe as a row of taps.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "brdf/area_lights.hpp"

namespace {

using namespace togishi;

constexpr double degree = std::numbers::pi / 180;

f64::Facet facet(double x_deg, double y_deg) {
    return {x_deg * degree, y_deg * degree};
}

double brute(const f64::LobeForm& form, f64::Facet at, f64::Facet x, f64::Facet y) {
    constexpr int n = 400;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const double s = (i + 0.5) / n - 0.5, t = (j + 0.5) / n - 0.5;
            sum +=
                f64::lobe_value(form, {at.dx + s * x.dx + t * y.dx, at.dy + s * x.dy + t * y.dy});
        }
    }
    return sum / (n * n);
}

TEST(LobeFilter, NoTurnIsTheLobe) {
    const auto form = f64::lobe_form(f64::lobe_from_mu(3 * degree, degree, 0.4));
    for (const double x : {-4.0, 0.0, 1.5}) {
        const double plain = f64::lobe_value(form, facet(x, 0.5));
        EXPECT_NEAR(f64::lobe_value_box(form, facet(x, 0.5), {0, 0}, {0, 0}, 1), plain, 1e-12);
        const auto same = f64::lobe_form_widened(form, {0, 0}, {0, 0}, 0.25);
        EXPECT_NEAR(f64::lobe_value(same, facet(x, 0.5)), plain, 1e-12);
        EXPECT_NEAR(same.scale / form.scale, 1, 1e-14);
    }
}

TEST(LobeFilter, OneTurnIsTheExactMean) {
    const auto form = f64::lobe_form(f64::lobe_from_mu(0.3 * degree, 0.1 * degree, 0.7));
    for (const double turn : {0.05, 0.5, 5.0}) {
        for (const double at : {0.0, 0.2, 0.6}) {
            const auto x = facet(turn, 0.4 * turn);
            EXPECT_NEAR(f64::lobe_value_box(form, facet(at, -at), x, {0, 0}, 1),
                        brute(form, facet(at, -at), x, {0, 0}), 2e-5);
        }
    }
}

TEST(LobeFilter, FourNodesAreTheMeanOverAParallelogram) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto form = f64::lobe_form(f64::lobe_from_mu(0.9 * degree, 0.1 * degree, 0.3));
    for (int i = 0; i < 20; ++i) {
        const auto x = facet(unit(random), unit(random)), y = facet(unit(random), unit(random));
        const auto at = facet(0.3 * unit(random), 0.3 * unit(random));
        const double truth = brute(form, at, x, y);
        EXPECT_NEAR(f64::lobe_value_box(form, at, x, y, 8), truth, 0.02 * truth + 1e-3);
    }
}

TEST(LobeFilter, WideningKeepsTheEnergyAndTheCovariance) {
    const auto form = f64::lobe_form(f64::lobe_from_mu(0.4 * degree, 0.1 * degree, 1.1));
    const auto x = facet(0.7, -0.3), y = facet(0.2, 0.5);
    const auto wide = f64::lobe_form_widened(form, x, y, 0.25);
    EXPECT_NEAR(wide.scale, std::sqrt(wide.xx * wide.yy - wide.xy * wide.xy), 1e-9 * wide.scale);
    // Covariance = form^-1/2 grows by a quarter of x x^T + y y^T.
    const auto covariance = [](const f64::LobeForm& f) {
        const double det = f.xx * f.yy - f.xy * f.xy;
        return glm::dvec3(f.yy, -f.xy, f.xx) / (2 * det);
    };
    const glm::dvec3 grown = covariance(wide) - covariance(form);
    EXPECT_NEAR(grown.x, 0.25 * (x.dx * x.dx + y.dx * y.dx), 1e-12);
    EXPECT_NEAR(grown.y, 0.25 * (x.dx * x.dy + y.dx * y.dy), 1e-12);
    EXPECT_NEAR(grown.z, 0.25 * (x.dy * x.dy + y.dy * y.dy), 1e-12);
}

TEST(LobeFilter, HighlightKeepsItsEnergyAtAnyPhase) {
    const float mu = static_cast<float>(0.1 * degree);
    const auto form = f32::lobe_form(f32::lobe_from_mu(mu, mu, 0));
    for (const float width : {0.05F, 0.2F, 1.0F, 2.0F}) {
        const float rate = mu / 1.17741F / width;
        for (const float phase : {0.0F, 0.13F, 0.5F}) {
            double sum = 0;
            for (int i = -20; i <= 20; ++i)
                sum += static_cast<double>(f32::lobe_value_box(
                    form, {(static_cast<float>(i) + phase) * rate, 0}, {rate, 0}, {0, 0}, 1));
            const double exact = std::sqrt(2 * std::numbers::pi) * static_cast<double>(width);
            EXPECT_NEAR(sum / exact, 1, 2e-3) << width << ' ' << phase;
        }
    }
}

TEST(LobeFilter, RidgeIsTheMeanOverItsFacets) {
    const auto form = f64::lobe_form(f64::lobe_from_mu(degree, degree, 0));
    const auto from = facet(-12, 0.3), to = facet(20, 0.3);
    for (const double width : {1e-4, 0.03, 0.7, 4.0, 50.0}) {
        for (const double begin : {-0.9, -0.2, 0.1}) {
            constexpr int n = 200'000;
            double sum = 0;
            for (int i = 0; i < n; ++i) {
                const double x = begin + width * (i + 0.5) / n;
                if (x < -0.5 || x > 0.5) continue;
                const double s = (x - begin) / width;
                sum +=
                    width / n * f64::lobe_value(form, {from.dx + s * (to.dx - from.dx), from.dy});
            }
            EXPECT_NEAR(f64::lobe_value_ridge(form, from, to, begin, begin + width), sum,
                        2e-4 * sum + 1e-9)
                << width << ' ' << begin;
        }
    }
}

TEST(LobeFilter, ExtremesAreFinite) {
    for (const float mu : {1e-5F, 1e-3F, 1.0F}) {
        const auto form = f32::lobe_form(f32::lobe_from_mu(mu, mu / 20, 0.5F));
        for (const float at : {0.0F, 1e-6F, 1.5F}) {
            for (const float turn : {0.0F, 1e-12F, 1e-4F, 3.0F}) {
                const float value = f32::lobe_value_box(form, {at, -at}, {turn, 0}, {0, turn}, 4);
                EXPECT_TRUE(value >= 0 && value <= 1.001F) << mu << ' ' << at << ' ' << turn;
                const auto wide = f32::lobe_form_widened(form, {turn, 0}, {0, turn}, 0.25F);
                EXPECT_TRUE(f32::lobe_value(wide, {at, at}) >= 0);
                const float ridge =
                    f32::lobe_value_ridge(form, {-at, 0}, {turn, 0}, 0.1F, 0.1F + turn);
                EXPECT_TRUE(ridge >= 0 && ridge <= 1.001F);
            }
        }
    }
}

TEST(EnvironmentTaps, AddUpToTheLobe) {
    for (const double aspect : {1.0, 2.0, 3.0, 6.0}) {
        const auto taps = f64::environment_taps(aspect, 25);
        double total = 0, peak = 0, second = 0;
        for (int k = 0; k < 25; ++k) {
            const double place = f64::environment_tap_place(taps, 25, k);
            const double weight = f64::environment_tap_weight(taps, place);
            total += weight;
            second += weight * (place * place + taps.width * taps.width);
            peak += weight * std::exp(-0.5 * place * place / (taps.width * taps.width));
        }
        EXPECT_NEAR(peak / total * aspect / (taps.width * taps.width), 1, 0.02) << aspect;
        EXPECT_NEAR(std::sqrt(second / total) / aspect, 1, 0.03) << aspect;
    }
    EXPECT_EQ(f64::environment_taps(0.5, 5).step, 0);
    EXPECT_EQ(f64::environment_taps(40, 5).step, f64::environment_taps(20, 5).step);
}

}  // namespace
