// The fields that the steel pattern is made of: noise, grids, distances, grains, layers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "steel/field_grid.hpp"
#include "steel/hada.hpp"
#include "steel/line_distance.hpp"
#include "steel/nie.hpp"
#include "steel/nioiguchi.hpp"
#include "steel/noise.hpp"
#include "steel/random_stream.hpp"

namespace togishi {
namespace {

struct Moments {
    double mean = 0;
    double variance = 0;
};

Moments moments(const std::vector<double>& values) {
    Moments m;
    for (const double x : values) m.mean += x;
    m.mean /= static_cast<double>(values.size());
    for (const double x : values) m.variance += (x - m.mean) * (x - m.mean);
    m.variance /= static_cast<double>(values.size());
    return m;
}

/// Correlation of a series with itself, shifted by `lag` samples.
double autocorrelation(const std::vector<double>& values, std::size_t lag) {
    const Moments m = moments(values);
    double sum = 0;
    for (std::size_t i = 0; i + lag < values.size(); ++i) {
        sum += (values[i] - m.mean) * (values[i + lag] - m.mean);
    }
    return sum / static_cast<double>(values.size() - lag) / m.variance;
}

TEST(SteelNoise, HasMeanZeroAndDeviationOneHalf) {
    std::vector<double> plane;
    std::vector<double> line;
    for (int i = 0; i < 700; ++i) {
        for (int j = 0; j < 700; ++j) plane.push_back(noise_value(i * 0.371, j * 0.293, 5));
    }
    for (int i = 0; i < 400000; ++i) line.push_back(noise_1d(i * 0.137, 9));
    const Moments p = moments(plane);
    const Moments l = moments(line);
    EXPECT_NEAR(p.mean, 0.0, 0.03);
    EXPECT_NEAR(p.variance, 0.25, 0.01);
    EXPECT_NEAR(l.mean, 0.0, 0.03);
    EXPECT_NEAR(l.variance, 0.25, 0.01);
}

TEST(SteelNoise, GradientIsThatOfItsValue) {
    for (int i = 0; i < 500; ++i) {
        const double x = i * 1.713 - 300.0;
        const double y = i * 0.977 - 90.0;
        constexpr double h = 1e-3;
        const NoiseSample n = noise_2d(x, y, 3);
        EXPECT_EQ(n.value, noise_value(x, y, 3));
        EXPECT_NEAR(n.dx, (noise_value(x + h, y, 3) - noise_value(x - h, y, 3)) / (2 * h), 0.02);
        EXPECT_NEAR(n.dy, (noise_value(x, y + h, 3) - noise_value(x, y - h, 3)) / (2 * h), 0.02);
    }
}

TEST(SteelNoise, StreamsOfTheTwoSidesAreRelated) {
    for (const double asymmetry : {0.0, 0.35, 1.0}) {
        SideStream omote(4, 11, true, asymmetry);
        SideStream ura(4, 11, false, asymmetry);
        double product = 0;
        constexpr int count = 20000;
        for (int i = 0; i < count; ++i) product += omote.normal() * ura.normal();
        EXPECT_NEAR(product / count, 1.0 - asymmetry, 0.08);
    }
}

TEST(SteelFieldGrid, ReproducesAPlaneAndItsSlope) {
    FieldGrid grid(-2.0, 1.0, 0.125, 80, 60);
    for (std::size_t i = 0; i < grid.columns(); ++i) {
        for (std::size_t j = 0; j < grid.rows(); ++j) {
            grid.column(i)[j] = static_cast<float>(0.7 * grid.s_of(i) - 0.3 * grid.q_of(j) + 2.0);
        }
    }
    const FieldSample f = grid.sample(1.234, 3.456);
    EXPECT_NEAR(f.value, 0.7 * 1.234 - 0.3 * 3.456 + 2.0, 1e-5);
    EXPECT_NEAR(f.ds, 0.7, 1e-4);
    EXPECT_NEAR(f.dq, -0.3, 1e-4);
}

TEST(SteelFieldGrid, DiffusionSpreadsAStepAsAGaussian) {
    FieldGrid grid(0.0, 0.0, 0.1, 200, 30);
    for (std::size_t i = 0; i < grid.columns(); ++i) {
        std::fill_n(grid.column(i), grid.rows(), i < 100 ? 0.0F : 1.0F);
    }
    constexpr double sigma = 0.4;
    grid.diffuse(sigma, 0.2, 2);
    for (std::size_t i = 80; i < 120; ++i) {
        const double x = (static_cast<double>(i) - 99.5) * 0.1;
        EXPECT_NEAR(grid.column(i)[15], 0.5 * (1.0 + std::erf(x / sigma / std::sqrt(2.0))), 2e-3);
    }
}

TEST(SteelLineDistance, IsTheDistanceToACircle) {
    FieldGrid field(-5.0, -5.0, 0.125, 81, 81);
    for (std::size_t i = 0; i < field.columns(); ++i) {
        for (std::size_t j = 0; j < field.rows(); ++j) {
            const double d = 3.0 - std::hypot(field.s_of(i), field.q_of(j));
            field.column(i)[j] = static_cast<float>(2.0 * d + 0.1 * d * d);
        }
    }
    const FieldGrid distance = distance_to_zero(field, 4.0F);
    for (std::size_t i = 0; i < field.columns(); ++i) {
        for (std::size_t j = 0; j < field.rows(); ++j) {
            const double d = 3.0 - std::hypot(field.s_of(i), field.q_of(j));
            EXPECT_NEAR(distance.column(i)[j], d, 0.05 + 0.04 * std::abs(d));
        }
    }
}

TEST(SteelNioiguchi, RisesFromTheJiAndIsBrightestJustInside) {
    constexpr float width = 0.5F;
    float last = 0;
    float brightest_at = -9;
    float brightest = 0;
    for (float depth = -4; depth < 0.0F; depth += 0.05F) {
        const Nioiguchi n = nioiguchi_at(depth, width, 0.8F);
        EXPECT_GE(n.w, last);
        last = n.w;
    }
    for (float depth = -4; depth < 4.0F; depth += 0.05F) {
        const Nioiguchi n = nioiguchi_at(depth, width, 0.8F);
        EXPECT_GE(n.w, 0.0F);
        EXPECT_LE(n.w, 1.0F);
        if (n.glow > brightest) {
            brightest = n.glow;
            brightest_at = depth;
        }
    }
    EXPECT_GT(brightest_at, 0.0F);
    EXPECT_LT(brightest_at, width);
    EXPECT_EQ(nioiguchi_at(-4.0F, width, 0.8F).w, 0.0F);
    EXPECT_NEAR(nioiguchi_at(4.0F, width, 0.8F).w, 0.8F, 0.03F);
}

TEST(SteelNie, CoversTheShareAskedForAtAnyFootprint) {
    constexpr float amount = 0.12F;
    for (const float footprint : {0.01F, 0.08F, 0.2F, 0.5F}) {
        double cover = 0;
        constexpr int count = 250;
        for (int i = 0; i < count; ++i) {
            for (int j = 0; j < count; ++j) {
                cover += nie_grains(i * 0.0531, j * 0.0477, amount, footprint, footprint, 8).cover;
            }
        }
        EXPECT_NEAR(cover / count / count, amount, 0.15 * amount) << footprint;
    }
}

TEST(SteelHada, NeverRepeatsAlongABlade) {
    for (const HadaStyle style : {HadaStyle::itame, HadaStyle::masame, HadaStyle::ayasugi}) {
        const Hada hada(style, 1.0, 7);
        constexpr double step = 0.1;
        constexpr std::size_t lines = 40;
        std::vector<double> correlation(4000);
        for (std::size_t k = 0; k < lines; ++k) {
            std::vector<double> tone;
            for (double s = 0; s < 720.0; s += step) {
                tone.push_back(hada.at(s, 1.37 * static_cast<double>(k), 0.1F, 0.1F).tone);
            }
            for (std::size_t lag = 600; lag < correlation.size(); lag += 3) {
                correlation[lag] += autocorrelation(tone, lag) / lines;
            }
        }
        // Ayasugi has its own wave by name; its layers must not repeat with it.
        for (std::size_t lag = 600; lag < correlation.size(); lag += 3) {
            EXPECT_LT(std::abs(correlation[lag]), 0.25) << static_cast<double>(lag) * step << " mm";
        }
    }
}

TEST(SteelHada, MasameRunsStraightAndItameDoesNot) {
    // How steeply the layers cross the blade's length, in the mean.
    const auto slant = [](HadaStyle style) {
        const Hada hada(style, 1.0, 3);
        double sum = 0;
        for (int i = 0; i < 4000; ++i) {
            const HadaSample h = hada.at(i * 0.173, i * 0.0071, 0.1F, 0.1F);
            sum += std::abs(std::atan2(h.ds, h.dq));
        }
        return sum / 4000.0;
    };
    const double itame = slant(HadaStyle::itame);
    const double masame = slant(HadaStyle::masame);
    const double ayasugi = slant(HadaStyle::ayasugi);
    EXPECT_LT(masame, 0.06);
    EXPECT_GT(itame, 2.0 * masame);
    EXPECT_GT(ayasugi, 2.0 * masame);
}

TEST(SteelHada, FadesWhereTheFootprintHidesIt) {
    const Hada hada(HadaStyle::itame, 1.0, 3);
    const auto spread = [&](float footprint) {
        std::vector<double> tone;
        for (int i = 0; i < 6000; ++i)
            tone.push_back(hada.at(i * 0.21, (i % 60) * 0.31, footprint, footprint).tone);
        return std::sqrt(moments(tone).variance);
    };
    const double fine = spread(0.02F);
    EXPECT_NEAR(fine, 0.45, 0.1);
    EXPECT_LT(spread(0.5F), fine);
    EXPECT_LT(spread(5.0F), 0.2 * fine);
}

}  // namespace
}  // namespace togishi
