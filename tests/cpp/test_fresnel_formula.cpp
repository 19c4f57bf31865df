// shaders/shared/fresnel.glsl against complex arithmetic, its limits and published values.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "brdf/model.hpp"

namespace {

namespace f32 = togishi::f32;
namespace f64 = togishi::f64;
constexpr double degree = std::numbers::pi / 180.0;

// The textbook form in complex numbers (Born & Wolf 14.2): nothing shared with the code under test.
double complex_fresnel(double n, double k, double cosine) {
    const std::complex<double> index(n, k);
    const std::complex<double> inside =
        std::sqrt(index * index - (1.0 - cosine * cosine));  // index times cos of refraction
    const std::complex<double> r_s = (cosine - inside) / (cosine + inside);
    const std::complex<double> r_p =
        (index * index * cosine - inside) / (index * index * cosine + inside);
    return 0.5 * (std::norm(r_s) + std::norm(r_p));
}

struct Index {
    const char* name;
    double n, k;
    double float_tolerance;  // relative, stated in fresnel.glsl
};
// Johnson & Christy 1972/1974 near 550 nm.
constexpr Index iron{"iron", 2.95, 2.93, 5e-7};
constexpr Index copper{"copper", 1.04, 2.59, 2e-6};
constexpr Index silver{"silver", 0.06, 3.59, 4e-6};

TEST(Fresnel, AgreesWithComplexArithmeticAtAllAngles) {
    for (const Index& metal : {iron, copper, silver}) {
        double worst32 = 0, worst64 = 0;
        for (int i = 0; i <= 90000; ++i) {
            // The same cosine for both precisions: what is measured is the formula, not the input.
            const auto cosine = static_cast<float>(std::cos(i * 0.001 * degree));
            const double truth = complex_fresnel(metal.n, metal.k, std::max(cosine, 0.0F));
            const auto n = static_cast<float>(metal.n), k = static_cast<float>(metal.k);
            const double truth32 = complex_fresnel(n, k, std::max(cosine, 0.0F));
            worst32 =
                std::max(worst32, std::abs(f32::fresnel_conductor(n, k, cosine) / truth32 - 1));
            worst64 = std::max(
                worst64, std::abs(f64::fresnel_conductor(metal.n, metal.k, cosine) / truth - 1));
        }
        EXPECT_LT(worst32, metal.float_tolerance) << metal.name;
        EXPECT_LT(worst64, 1e-13) << metal.name;
        RecordProperty(std::string(metal.name) + "_float", std::to_string(worst32));
    }
}

TEST(Fresnel, NormalIncidenceIsTheKnownQuotient) {
    for (const Index& metal : {iron, copper, silver}) {
        const double n = metal.n, k = metal.k;
        const double expected = ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k);
        EXPECT_NEAR(f64::fresnel_conductor(n, k, 1.0), expected, 1e-15);
    }
    EXPECT_NEAR(f64::fresnel_conductor(1.5, 0.0, 1.0), 0.04, 1e-15);  // glass
}

TEST(Fresnel, BrewsterLeavesHalfOfTheSComponent) {
    const double n = 1.5, brewster = std::atan(n);
    // At Brewster's angle R_p = 0 and R_s = ((n^2 - 1)/(n^2 + 1))^2 (Born & Wolf 1.5.3).
    const double r_s = std::pow((n * n - 1) / (n * n + 1), 2);
    EXPECT_NEAR(f64::fresnel_conductor(n, 0.0, std::cos(brewster)), 0.5 * r_s, 1e-14);
}

TEST(Fresnel, TotalReflectionBeyondTheCriticalAngle) {
    const double n = 1 / 1.5, critical = std::asin(n);
    for (double angle = critical + 1e-6; angle < 90 * degree; angle += 0.01) {
        EXPECT_NEAR(f64::fresnel_conductor(n, 0.0, std::cos(angle)), 1.0, 1e-12) << angle;
        EXPECT_NEAR(f32::fresnel_conductor(static_cast<float>(n), 0.0F,
                                           static_cast<float>(std::cos(angle + 1e-4))),
                    1.0F, 2e-6F);
    }
    EXPECT_LT(f64::fresnel_conductor(n, 0.0, std::cos(critical - 0.01)), 0.9);
}

TEST(Fresnel, IronAcrossTheAngles) {
    // F(theta)/F(0) of Johnson & Christy's iron at 550 nm: -0.2 % at 30 degrees, -1 % at 45, -3.7 %
    // at 65, +4.8 % at 80, +28 % at 85. Metals have a minimum of F before grazing; Schlick's
    // formula has none.
    const auto ratio = [](double angle_deg) {
        return f64::fresnel_conductor(iron.n, iron.k, std::cos(angle_deg * degree)) /
               f64::fresnel_conductor(iron.n, iron.k, 1.0);
    };
    EXPECT_NEAR(ratio(30), 0.998, 0.001);
    EXPECT_NEAR(ratio(45), 0.990, 0.001);
    EXPECT_NEAR(ratio(65), 0.963, 0.001);
    EXPECT_NEAR(ratio(80), 1.048, 0.001);
    EXPECT_NEAR(ratio(85), 1.28, 0.005);
}

TEST(Fresnel, DefinedResults) {
    for (const double cosine : {0.0, 1e-9, 0.3, 1.0}) {
        EXPECT_EQ(f32::fresnel_conductor(0, 0, static_cast<float>(cosine)), 1.0F);
        EXPECT_EQ(f64::fresnel_conductor(0, 0, cosine), 1.0);
    }
    EXPECT_EQ(f64::fresnel_conductor(1, 0, 0.0), 1.0);
    EXPECT_EQ(f64::fresnel_conductor(1, 0, 0.5), 0.0);
    for (const Index& metal : {iron, copper, silver}) {
        EXPECT_EQ(
            f32::fresnel_conductor(static_cast<float>(metal.n), static_cast<float>(metal.k), 0), 1);
        EXPECT_EQ(f64::fresnel_conductor(metal.n, metal.k, -0.5), 1.0);  // clamped to 90 degrees
        EXPECT_EQ(f64::fresnel_conductor(metal.n, metal.k, 1.5),
                  f64::fresnel_conductor(metal.n, metal.k, 1.0));
    }
}

TEST(Fresnel, StaysInRangeAndNearDoubleOverTheWholeDomain) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> exponent(-4, 4), unit(0, 1);
    for (int i = 0; i < 300'000; ++i) {
        const float n = std::pow(10.0F, exponent(random));
        const float k = i % 5 == 0 ? 0.0F : std::pow(10.0F, exponent(random));
        const float cosine = i % 7 == 0 ? std::pow(10.0F, exponent(random) - 4) : unit(random);
        const float value = f32::fresnel_conductor(n, k, cosine);
        ASSERT_TRUE(value >= 0 && value <= 1) << n << ' ' << k << ' ' << cosine;
        // Beside the critical angle of n < 1 the slope is infinite: rounding of the squared sine
        // counts 1/sqrt(gap).
        const double t0 = static_cast<double>(n) * n - static_cast<double>(k) * k - 1 +
                          static_cast<double>(cosine) * cosine;
        const double gap = std::hypot(t0, 2.0 * n * k);
        if (gap < 1e-6) continue;
        ASSERT_NEAR(value, complex_fresnel(n, k, cosine), 2e-6 + 4e-7 / std::sqrt(gap))
            << n << ' ' << k << ' ' << cosine;
    }
}

}  // namespace
