// The fit of pixels under many known lights, against the shared formulas and the truth it is given.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "brdf/model.hpp"
#include "capture/light_stack.hpp"
#include "capture/pixel_result.hpp"
#include "capture/self_calibration.hpp"

namespace togishi {
namespace {

constexpr double rad = 0.017453292519943295769;

struct Truth {
    double p, q, mu_t_deg, mu_b_deg, rho_deg, chi, diffuse, pedestal = 0, haze = 0;
};

// Lights as a region sees them, half vectors on a spiral.
struct Scene {
    std::vector<float> u, v, gain, diffuse, area;
    PixelLights lights;
    explicit Scene(int count = 60, double reach_deg = 22) {
        for (int i = 0; i < count; ++i) {
            const double r = reach_deg * std::sqrt((i + 0.5) / count), a = 2.399963 * i;
            u.push_back(static_cast<float>(r * std::cos(a)));
            v.push_back(static_cast<float>(r * std::sin(a)));
            gain.push_back(static_cast<float>(0.9 + 0.2 * i / count));
            diffuse.push_back(static_cast<float>(std::cos(2 * r * rad)));
            area.push_back(1);
        }
        lights.count = count;
        lights.u_deg = u.data();
        lights.v_deg = v.data();
        lights.gain = gain.data();
        lights.diffuse = diffuse.data();
        lights.area = area.data();
        lights.spacing_deg = static_cast<float>(reach_deg * std::sqrt(3.14159 / count));
        lights.reach_deg = static_cast<float>(reach_deg);
    }
    // By the shared formula, not by the kernel's.
    [[nodiscard]] double signal(const Truth& t, std::size_t i) const {
        const auto lobe = [&](double wider) {
            const auto form = f64::lobe_form(f64::lobe_from_mu(
                t.mu_t_deg * wider * rad, t.mu_b_deg * wider * rad, t.rho_deg * rad));
            return f64::lobe_value(form, {(u[i] - t.p) * rad, (v[i] - t.q) * rad});
        };
        return gain[i] * t.chi * (lobe(1) + (t.haze > 0 ? t.haze * lobe(3) : 0)) +
               t.diffuse * diffuse[i] + t.pedestal;
    }
};

struct Samples {
    std::vector<float> value, scale;
    explicit Samples(int count)
        : value(static_cast<std::size_t>(count) * block_pixels, 0.0F), scale(value) {}
    [[nodiscard]] PixelSamples view() const { return {value.data(), scale.data()}; }
    void set(std::size_t i, std::size_t lane, double v, double s = 1) {
        value[i * block_pixels + lane] = static_cast<float>(v);
        scale[i * block_pixels + lane] = static_cast<float>(s);
    }
};

Samples photographed(const Scene& scene, const std::vector<Truth>& truth, double snr,
                     RandomNormal& random) {
    Samples s(scene.lights.count);
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        for (std::size_t i = 0; i < scene.u.size(); ++i) {
            const double y = scene.signal(truth[lane], i);
            s.set(i, lane, y + std::sqrt(std::max(y, 0.0)) / snr * random.normal());
        }
    }
    return s;
}

PixelBlock fitted(const Scene& scene, const Samples& samples, const PixelKernelOptions& options,
                  const char* kernel = "") {
    std::vector<float> scratch(2 * samples.value.size());
    PixelBlock block;
    pixel_kernel(kernel).fit(scene.lights, samples.view(), options, scratch.data(), block);
    return block;
}

PixelKernelOptions exact_lights(double snr = 1000) {
    PixelKernelOptions o;
    o.noise_gain = static_cast<float>(1 / (snr * snr));
    o.noise_floor2 = 1e-8F;
    o.sigma_h_deg = 0.003F;
    return o;
}

f64::LobeAxes axes(const PixelBlock& b, std::size_t lane) {
    return f64::lobe_axes({b.x[ln_mu_deg][lane], b.x[shape_e1][lane], b.x[shape_e2][lane]});
}

std::vector<Truth> truths() {
    RandomNormal random(3);
    std::vector<Truth> all;
    for (int i = 0; i < block_pixels; ++i) {
        const double b = 3 + 3 * random.uniform();
        all.push_back({3 * random.normal(), 3 * random.normal(), b * (1.3 + random.uniform()), b,
                       180 * random.uniform(), 0.3 + random.uniform(), 0.02 * random.uniform()});
    }
    return all;
}

class Kernels : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        try {
            (void)pixel_kernel(GetParam());
        } catch (const InputError&) {
            GTEST_SKIP() << "this processor does not run " << GetParam();
        }
    }
};
INSTANTIATE_TEST_SUITE_P(All, Kernels, testing::Values("baseline", "avx2"));

TEST_P(Kernels, FindTheSharedFormulasLobe) {
    const Scene scene;
    RandomNormal random(1);
    const auto truth = truths();
    const PixelBlock b =
        fitted(scene, photographed(scene, truth, 1e5, random), exact_lights(), GetParam());
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        const auto found = axes(b, lane);
        EXPECT_NEAR(found.mu_t_rad / rad, truth[lane].mu_t_deg, 2e-3 * truth[lane].mu_t_deg);
        EXPECT_NEAR(found.mu_b_rad / rad, truth[lane].mu_b_deg, 2e-3 * truth[lane].mu_b_deg);
        EXPECT_NEAR(std::remainder(found.rho_rad / rad - truth[lane].rho_deg, 180), 0, 0.2);
        EXPECT_NEAR(b.x[tilt_u][lane], truth[lane].p, 0.01);
        EXPECT_NEAR(b.x[tilt_v][lane], truth[lane].q, 0.01);
        EXPECT_NEAR(std::exp(b.x[ln_chi][lane]), truth[lane].chi, 2e-3 * truth[lane].chi);
        EXPECT_NEAR(b.x[diffuse][lane], truth[lane].diffuse, 1e-3);
    }
}

TEST_P(Kernels, PedestalAndHazeAreToldApart) {
    const Scene scene;
    RandomNormal random(2);
    auto truth = truths();
    for (Truth& t : truth) {
        t.pedestal = 0.01;
        t.haze = 0.05;
        t.mu_t_deg *= 0.4;
        t.mu_b_deg = std::max(1.6, 0.4 * t.mu_b_deg);
    }
    PixelKernelOptions o = exact_lights(3000);
    o.pedestal = o.haze = true;
    const Scene dense(120, 18);
    const PixelBlock b = fitted(dense, photographed(dense, truth, 3000, random), o, GetParam());
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        EXPECT_NEAR(b.x[8][lane], 0.05, 0.02);
        EXPECT_NEAR(axes(b, lane).mu_b_rad / rad,
                    std::min(truth[lane].mu_b_deg, truth[lane].mu_t_deg),
                    0.03 * truth[lane].mu_b_deg);
    }
}

TEST_P(Kernels, ALaneDoesNotKnowItsNeighbours) {
    const Scene scene;
    RandomNormal random(4);
    const auto truth = truths();
    const Samples all = photographed(scene, truth, 100, random);
    const PixelBlock together = fitted(scene, all, exact_lights(100), GetParam());
    for (const std::size_t lane : {0U, 5U, 15U}) {
        // Alone, and at another place of the block.
        Samples alone(scene.lights.count);
        const std::size_t other = (lane + 7) % block_pixels;
        for (std::size_t i = 0; i < scene.u.size(); ++i)
            alone.set(i, other, all.value[i * block_pixels + lane]);
        const PixelBlock b = fitted(scene, alone, exact_lights(100), GetParam());
        for (std::size_t a = 0; a < 7; ++a) EXPECT_EQ(b.x[a][other], together.x[a][lane]);
        EXPECT_EQ(b.chi2[other], together.chi2[lane]);
        EXPECT_EQ(b.covariance[0][other], together.covariance[0][lane]);
    }
}

TEST_P(Kernels, SlopesAreThoseOfTheResidual) {
    const Scene scene;
    RandomNormal random(5);
    const auto truth = truths();
    const Samples samples = photographed(scene, truth, 100, random);
    PixelKernelOptions o = exact_lights(100);
    o.sigma_h_deg = 0;  // weights then do not move with the unknowns
    PixelBlock b = fitted(scene, samples, o, GetParam());
    const std::size_t n = samples.value.size();
    const auto slopes_at = [&](const PixelBlock& at, std::vector<float>& j) {
        std::vector<float> r(n);
        j.assign(max_unknowns * n, 0.0F);
        pixel_kernel(GetParam()).slopes(scene.lights, samples.view(), o, at, {r.data(), j.data()});
        return r;
    };
    std::vector<float> j, ignored;
    (void)slopes_at(b, j);
    for (std::size_t a = 0; a < 7; ++a) {
        const float step = 2e-3F;
        PixelBlock up = b, down = b;
        for (std::size_t lane = 0; lane < block_pixels; ++lane) {
            up.x[a][lane] += step;
            down.x[a][lane] -= step;
        }
        const auto high = slopes_at(up, ignored), low = slopes_at(down, ignored);
        for (std::size_t k = 0; k < n; ++k) {
            const double by_steps = (high[k] - low[k]) / (2 * step);
            EXPECT_NEAR(j[a * n + k], by_steps, 0.05 + 0.01 * std::abs(by_steps))
                << "unknown " << a << ", sample " << k;
        }
    }
}

TEST(PixelFit, ClippedSamplesAreLowerBounds) {
    const Scene scene;
    RandomNormal random(6);
    const auto truth = truths();
    Samples samples = photographed(scene, truth, 1000, random);
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        for (std::size_t i = 0; i < scene.u.size(); ++i) {
            const double level = 0.5 * truth[lane].chi;
            if (samples.value[i * block_pixels + lane] > level) samples.set(i, lane, level, -1);
        }
    }
    const PixelBlock b = fitted(scene, samples, exact_lights());
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        EXPECT_GT(b.clipped[lane], 0);
        EXPECT_NEAR(std::exp(b.x[ln_chi][lane]), truth[lane].chi, 0.03 * truth[lane].chi);
        EXPECT_NEAR(axes(b, lane).mu_t_rad / rad, truth[lane].mu_t_deg,
                    0.01 * truth[lane].mu_t_deg);
    }
}

TEST(PixelFit, ShadowsAndGlintsAreRejected) {
    const Scene scene;
    RandomNormal random(7);
    const auto truth = truths();
    Samples samples = photographed(scene, truth, 200, random);
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        // In the lobe a shadow; outside a glint.
        samples.set(2, lane, 0);
        samples.set(55, lane, 2);
    }
    const PixelBlock b = fitted(scene, samples, exact_lights(200));
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        EXPECT_GE(b.rejected[lane], 1);
        EXPECT_NEAR(axes(b, lane).mu_b_rad / rad, truth[lane].mu_b_deg,
                    0.03 * truth[lane].mu_b_deg);
    }
}

RegionLights region_of(const Scene& s) {
    RegionLights r;
    const auto frame = f64::tangent_frame(glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0));
    r.normal = frame.normal;
    r.tangent = frame.tangent;
    r.bitangent = frame.bitangent;
    r.u_deg = s.u;
    r.v_deg = s.v;
    r.gain = s.gain;
    r.diffuse = s.diffuse;
    r.area = s.area;
    r.spacing_deg = s.lights.spacing_deg;
    r.reach_deg = s.lights.reach_deg;
    return r;
}

TEST(PixelFit, IntervalsHoldTheTruthAsOftenAsTheySay) {
    const Scene scene;
    RandomNormal random(8);
    const auto truth = truths();
    std::array<int, 3> held{};
    int pixels = 0;
    for (int round = 0; round < 40; ++round) {
        const PixelBlock b =
            fitted(scene, photographed(scene, truth, 100, random), exact_lights(100));
        for (std::size_t lane = 0; lane < truth.size(); ++lane) {
            const PixelResult r = pixel_result(b, lane, region_of(scene), exact_lights(100));
            ASSERT_EQ(r.flags, 0);
            const auto a = axes(b, lane);
            held[0] +=
                std::abs(std::log(a.mu_t_rad / rad / truth[lane].mu_t_deg)) < r.sigma_ln_mu_t;
            held[1] += std::abs(std::remainder(a.rho_rad / rad - truth[lane].rho_deg, 180)) <
                       r.sigma_rho_deg;
            held[2] += std::hypot(b.x[tilt_u][lane] - truth[lane].p,
                                  b.x[tilt_v][lane] - truth[lane].q) < 1.07 * r.sigma_normal_deg;
            ++pixels;
        }
    }
    for (const int n : held) EXPECT_NEAR(static_cast<double>(n) / pixels, 0.68, 0.07);
}

TEST(PixelFit, WhatNoLightHitIsFlagged) {
    const Scene scene(60, 30);
    RandomNormal random(9);
    auto truth = truths();
    for (Truth& t : truth) t.mu_t_deg = t.mu_b_deg = 0.5;
    const PixelBlock b = fitted(scene, photographed(scene, truth, 100, random), exact_lights(100));
    const Samples dark(scene.lights.count);
    const PixelBlock none = fitted(scene, dark, exact_lights(100));
    for (std::size_t lane = 0; lane < truth.size(); ++lane) {
        EXPECT_NE(pixel_result(b, lane, region_of(scene), exact_lights()).flags & unusable_flags,
                  0);
        EXPECT_NE(pixel_result(none, lane, region_of(scene), exact_lights()).flags & flag_missing,
                  0);
    }
}

TEST(PixelResult, TheLobeTurnsWithTheNormal) {
    // A lobe whose wide axis lies along the picture's x, on a normal leaning in x and y: in the
    // frame tangent_frame(N, x) it keeps its azimuth but for the sphere's own turning.
    Scene scene;
    RegionLights region = region_of(scene);
    PixelBlock b{};
    b.x[tilt_u][0] = 10;
    b.x[tilt_v][0] = 10;
    b.x[shape_e1][0] = 0.4F;
    b.used[0] = 60;
    const PixelResult r = pixel_result(b, 0, region, exact_lights());
    const double phi = std::hypot(10.0, 10.0) * rad;
    EXPECT_NEAR(std::acos(r.normal.z), phi, 1e-6);
    EXPECT_NEAR(r.normal.x, r.normal.y, 1e-6);
    EXPECT_NEAR(std::hypot(r.e1, r.e2), 0.4, 1e-6);
    // Carried along the diagonal by phi, x ends (1 - cos phi)/2 short of the projected x, in sin.
    const double half = 0.5 * (1 - std::cos(phi));
    const glm::dvec3 n(r.normal);
    const glm::dvec3 carried(1 - half, -half, -std::sin(phi) / std::sqrt(2.0));
    const auto frame = f64::tangent_frame(n, glm::dvec3(1, 0, 0));
    const double turn =
        std::atan2(glm::dot(carried, frame.bitangent), glm::dot(carried, frame.tangent));
    EXPECT_NEAR(0.5 * std::atan2(r.e2, r.e1), turn, 1e-5);
    EXPECT_GT(std::abs(turn), 0.005);
}

// A common map of the half vectors makes another ellipse of the lobe: its axes and their turn.
TEST(PixelResult, InheritsWhatTheLightsHaveInCommon) {
    Scene scene;
    const RegionLights region = region_of(scene);
    RandomNormal random(4);
    for (int trial = 0; trial < 20; ++trial) {
        PixelBlock b{};
        const double shape = 0.1 + 0.9 * random.uniform(), rho = 3 * random.uniform();
        b.x[tilt_u][0] = 3;
        b.x[tilt_v][0] = -2;
        b.x[shape_e1][0] = static_cast<float>(shape * std::cos(2 * rho));
        b.x[shape_e2][0] = static_cast<float>(shape * std::sin(2 * rho));
        b.used[0] = 60;
        constexpr double size = 1e-4;
        std::array<double, shared_unknowns> x{};
        for (double& v : x) v = size * random.normal();
        SharedError shared;
        shared.normal = region.normal;
        shared.tangent = region.tangent;
        shared.bitangent = region.bitangent;
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t j = 0; j < x.size(); ++j)
                shared.covariance[i * x.size() + j] = x[i] * x[j];
        const PixelResult r = pixel_result(b, 0, region, exact_lights(), shared);
        // Columns: glm's way.
        const glm::dmat2 turn(std::cos(rho), std::sin(rho), -std::sin(rho), std::cos(rho));
        const glm::dmat2 map(1 + x[2], x[4], x[3], 1 + x[5]);
        const glm::dmat2 axes(std::exp(2 * shape), 0, 0, std::exp(-2 * shape));
        const glm::dmat2 moved = map * turn * axes * glm::transpose(map * turn);
        const double mean = 0.5 * (moved[0].x + moved[1].y), half = 0.5 * (moved[0].x - moved[1].y),
                     apart = std::hypot(half, moved[0].y);
        const auto near = [](double claimed, double true_change) {
            EXPECT_NEAR(claimed, std::abs(true_change), 0.01 * size + 0.01 * std::abs(true_change));
        };
        near(r.sigma_ln_mu_t, 0.5 * std::log((mean + apart) / axes[0].x));
        near(r.sigma_ln_mu_b, 0.5 * std::log((mean - apart) / axes[1].y));
        near(r.sigma_rho_deg * rad,
             0.5 * std::remainder(std::atan2(moved[0].y, half) - 2 * rho, 360 * rad));
        near(r.sigma_normal_deg,
             std::hypot(x[0] + 3 * x[2] - 2 * x[3], x[1] + 3 * x[4] - 2 * x[5]));
        EXPECT_EQ(pixel_result(b, 0, region, exact_lights()).sigma_normal_deg, 0);
    }
}

TEST(SelfCalibration, FindsWhereTheLightsStood) {
    const Scene truth_scene(40, 12);
    Scene known = truth_scene;
    RandomNormal random(10);
    for (std::size_t i = 0; i < known.u.size(); ++i) {
        known.u[i] += static_cast<float>(0.18 * random.normal());
        known.v[i] += static_cast<float>(0.18 * random.normal());
    }
    SampleBlocks samples;
    samples.blocks = 40;
    for (std::size_t b = 0; b < samples.blocks; ++b) {
        auto pixels = truths();
        for (Truth& t : pixels) {
            t.p += random.normal();
            t.q += random.normal();
        }
        const Samples s = photographed(truth_scene, pixels, 100, random);
        samples.value.insert(samples.value.end(), s.value.begin(), s.value.end());
        samples.scale.insert(samples.scale.end(), s.scale.begin(), s.scale.end());
    }
    PixelKernelOptions o = exact_lights(100);
    o.sigma_h_deg = 0.18F;
    RegionLights lights = region_of(known);
    const Calibration found = self_calibrate(lights, samples, o, 5, 1);
    double before = 0, after = 0;
    for (std::size_t i = 0; i < known.u.size(); ++i) {
        before +=
            std::pow(known.u[i] - truth_scene.u[i], 2) + std::pow(known.v[i] - truth_scene.v[i], 2);
        after += std::pow(lights.u_deg[i] - truth_scene.u[i], 2) +
                 std::pow(lights.v_deg[i] - truth_scene.v[i], 2);
    }
    EXPECT_LT(after, 0.15 * before);
    EXPECT_GT(found.pixels, 500U);
    // What is left: a common map, within what is claimed of it, and no more than is claimed beside.
    const auto size = static_cast<Eigen::Index>(2 * lights.u_deg.size());
    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(size, shared_unknowns);
    Eigen::VectorXd left(size);
    for (Eigen::Index i = 0; i < size / 2; ++i) {
        const auto k = static_cast<std::size_t>(i);
        left(2 * i) = double{lights.u_deg[k]} - truth_scene.u[k];
        left(2 * i + 1) = double{lights.v_deg[k]} - truth_scene.v[k];
        for (Eigen::Index axis = 0; axis < 2; ++axis) {
            map(2 * i + axis, axis) = 1;
            map(2 * i + axis, 2 + 2 * axis) = truth_scene.u[k];
            map(2 * i + axis, 3 + 2 * axis) = truth_scene.v[k];
        }
    }
    const Eigen::VectorXd common = (map.transpose() * map).llt().solve(map.transpose() * left);
    const Eigen::MatrixXd claimed =
        Eigen::Map<const Eigen::MatrixXd>(found.shared.covariance.data(), 6, 6);
    const double chi2 = common.dot(claimed.llt().solve(common));
    EXPECT_LT(chi2, 22.5) << "0.1 % of 6 degrees of freedom";
    EXPECT_GT(chi2, 0.38);
    const double rest = (left - map * common).norm() / std::sqrt(double(size - shared_unknowns));
    EXPECT_LT(rest, 1.5 * found.sigma_h_deg);
    EXPECT_GT(rest, 0.5 * found.sigma_h_deg);
    RegionLights again = region_of(known);
    const Calibration threaded = self_calibrate(again, samples, o, 5, 3);
    EXPECT_EQ(again.u_deg, lights.u_deg) << "the same bits for any number of threads";
    EXPECT_EQ(threaded.sigma_h_deg, found.sigma_h_deg);
}

}  // namespace
}  // namespace togishi
