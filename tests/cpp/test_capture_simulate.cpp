// The simulated photographs: what the reference must give whatever the method.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "blade/katana_mesh.hpp"
#include "capture/diffuse_response.hpp"
#include "capture/simulate.hpp"

namespace {

using namespace togishi;

constexpr double deg = std::numbers::pi / 180;

// A pixel of a flat plate that looks at the eye under `incidence`, the mirror direction in x-y.
SurfaceView one_pixel(double incidence_deg) {
    const double a = incidence_deg * deg;
    const glm::dvec3 eye = 500.0 * glm::dvec3(-std::sin(a), std::cos(a), 0);
    return view_of_plate({{100, 100}, {0, 0}},
                         camera_looking_at(eye, {0, 0, 0}, {0, 0, 1}, false, 10, 1, 1));
}

PixelTruth one_truth(double mu_ji_deg, double mu_ha_deg, double w, double e1 = 0, double e2 = 0) {
    PixelTruth truth;
    truth.values.assign(map_channel_count, 0.0F);
    const auto set = [&](MapChannel c, double v) {
        truth.values[static_cast<std::size_t>(c)] = static_cast<float>(v);
    };
    set(MapChannel::ji_ln_mu_deg, std::log(mu_ji_deg));
    set(MapChannel::ha_ln_mu_deg, std::log(mu_ha_deg));
    set(MapChannel::ji_e1, e1);
    set(MapChannel::ji_e2, e2);
    set(MapChannel::ha_e1, e1);
    set(MapChannel::ha_e2, e2);
    set(MapChannel::w, w);
    return truth;
}

// A soft box in the mirror direction of one_pixel(incidence), shifted by so many degrees.
DiffuseSource box(double incidence_deg, double shift_deg, double half_deg) {
    const double a = (incidence_deg + shift_deg) * deg;
    const glm::dvec3 to(std::sin(a), std::cos(a), 0);
    DiffuseSource source;
    source.centre_mm = 600.0 * to;
    const double half = 600 * std::tan(half_deg * deg);
    source.half_u_mm = half * glm::dvec3(to.y, -to.x, 0);
    source.half_v_mm = half * glm::dvec3(0, 0, 1);
    return source;
}

RadianceOptions iron() {
    RadianceOptions options;
    options.metal = "iron_johnson_christy";
    options.light = "D65";
    return options;
}

double radiance(double incidence_deg, const PixelTruth& truth, const DiffuseSource& source,
                double piece = 1.8) {
    RadianceOptions options = iron();
    options.piece = piece;
    return reference_radiance(one_pixel(incidence_deg), truth, source, options)[0];
}

TEST(CaptureSimulate, AMirrorUnderALargeSourceShowsItTimesF) {
    const LuminousFresnel fresnel("iron_johnson_christy", "D65");
    for (const double mu : {0.3, 0.8, 3.0}) {
        const double found = radiance(20, one_truth(mu, 5, 0), box(20, 0, 55));
        EXPECT_NEAR(found, fresnel.at(std::cos(20 * deg)), 0.012) << mu;
    }
}

TEST(CaptureSimulate, FinerPiecesChangeNothing) {
    for (const double mu : {0.4, 1.0, 5.0}) {
        for (const double shift : {0.0, 9.0, 14.0}) {
            const PixelTruth truth = one_truth(mu, 5, 0.3, 0.3, 0.2);
            EXPECT_NEAR(radiance(30, truth, box(30, shift, 10)),
                        radiance(30, truth, box(30, shift, 10), 0.7), 2e-4)
                << mu << ' ' << shift;
        }
    }
}

TEST(CaptureSimulate, TheResponseAgreesWithTheReference) {
    const LuminousFresnel fresnel("iron_johnson_christy", "D65");
    for (const double incidence : {5.0, 50.0}) {
        const SurfaceView view = one_pixel(incidence);
        const SurfacePose pose{view.position_mm[0], glm::dvec3(view.normal[0]),
                               glm::dvec3(view.tangent[0]), view.camera.view(view.position_mm[0])};
        DiffuseSource disk = box(incidence, 7, 9);
        disk.kind = SourceKind::disk;
        DiffuseSource dome;
        dome.kind = SourceKind::hemisphere;
        dome.half_u_mm = {0.8, 0.6, 0};
        dome.far_away = true;
        for (const DiffuseSource& source :
             {box(incidence, 0, 10), box(incidence, 8, 10), box(incidence, 10, 10),
              box(incidence, 16, 8), disk, dome}) {
            const DiffuseResponse response(source, pose, fresnel, {}, 1.0);
            for (const double mu : {0.3, 0.8, 4.0, 9.0}) {
                for (const double e1 : {0.0, 0.5}) {
                    const std::array<double, 3> lobe{std::log(mu), e1, 0.3 * e1};
                    EXPECT_NEAR(response.ji(lobe),
                                radiance(incidence, one_truth(mu, 5, 0, e1, 0.3 * e1), source),
                                0.004)
                        << incidence << ' ' << mu << ' ' << e1;
                    EXPECT_NEAR(response.ha(lobe),
                                radiance(incidence, one_truth(1, mu, 1, e1, 0.3 * e1), source),
                                0.004)
                        << incidence << ' ' << mu << ' ' << e1;
                }
            }
        }
    }
}

TEST(CaptureSimulate, BesideASoftBoxRadianceRisesAndFalls) {
    // 10 degrees off a box's edge: little of a narrow lobe reaches it, and a wide one passes it.
    const double narrow = radiance(30, one_truth(0.8, 5, 0), box(30, 15, 10)),
                 middle = radiance(30, one_truth(5, 5, 0), box(30, 15, 10)),
                 wide = radiance(30, one_truth(14, 5, 0), box(30, 15, 10));
    EXPECT_LT(narrow, 0.5 * middle);
    EXPECT_LT(wide, 0.8 * middle);
}

TEST(CaptureSimulate, TheSensorKeepsItsPromises) {
    const int n = 200;
    SensorOptions sensor;
    sensor.scale = 0.5;
    sensor.blur_px = 1;
    sensor.snr = 100;
    sensor.read = 1e-3;
    const std::vector<double> even(n * n, 0.8);
    const std::vector<float> picture = expose(even, n, n, sensor, 0);
    double mean = 0, square = 0;
    for (const float v : picture) {
        mean += v / (n * n);
        const double levels = v * 4095.0;
        EXPECT_NEAR(levels, std::round(levels), 1e-3);
    }
    for (const float v : picture) square += (v - mean) * (v - mean) / (n * n);
    EXPECT_NEAR(mean, 0.4, 1e-4);
    EXPECT_NEAR(std::sqrt(square), std::sqrt(0.4e-4 + 1e-6), 2e-4);
    EXPECT_EQ(picture, expose(even, n, n, sensor, 0));
    EXPECT_NE(picture, expose(even, n, n, sensor, 1));
    // Blur spreads a point over its own variance and loses nothing.
    std::vector<double> point(n * n, 0.0);
    point[100 * n + 100] = 1;
    blur_picture(point, n, n, 1.5);
    double sum = 0, second = 0;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            sum += point[static_cast<std::size_t>(y * n + x)];
            second += point[static_cast<std::size_t>(y * n + x)] * (x - 100) * (x - 100);
        }
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(second, 1.5 * 1.5, 0.01);
}

TEST(CaptureSimulate, ABladeIsSeenWhereItIs) {
    const KatanaMesh mesh = make_katana(katana_defaults(), 0.1);
    const Camera camera =
        camera_looking_at({300, 800, -32}, {300, 0, -32}, {0, 0, 1}, true, 1600, 160, 80);
    const SurfaceView view = view_of_mesh(mesh, camera);
    std::size_t seen = 0;
    for (std::size_t i = 0; i < view.pixels(); ++i) {
        if (view.seen[i] == 0) continue;
        ++seen;
        const auto pixel = camera.project(view.position_mm[i]);
        ASSERT_TRUE(pixel);
        EXPECT_NEAR(pixel->x, static_cast<double>(i % 160) + 0.5, 1e-6);
        EXPECT_NEAR(pixel->y, static_cast<double>(i / 160) + 0.5, 1e-6);
        EXPECT_NEAR(glm::length(view.normal[i]), 1, 1e-5);
        EXPECT_NEAR(glm::dot(view.normal[i], view.tangent[i]), 0, 1e-5);
        EXPECT_GT(view.position_mm[i].y, 0);  // omote
        EXPECT_LT(view.uv[i].y, 0.52F);
    }
    // 31 mm of blade at 2 pixels a millimetre, over the whole width.
    EXPECT_GT(seen, 160 * 50);
    EXPECT_LT(seen, 160 * 66);
}

TEST(CaptureSimulate, BadInputIsNamed) {
    EXPECT_THROW((void)view_of_plate({{0, 10}, {0, 0}}, one_pixel(10).camera), InputError);
    EXPECT_THROW((void)view_of_plate({{10, 10}, {20, 0}}, one_pixel(10).camera), InputError);
    DiffuseSource flat = box(0, 0, 5);
    flat.half_v_mm = flat.half_u_mm * 2.0;
    EXPECT_THROW(check_source(flat, "test"), InputError);
    EXPECT_THROW((void)camera_looking_at({0, 1, 0}, {0, 0, 0}, {0, 1, 0}, false, 1, 10, 10),
                 InputError);
}

}  // namespace
