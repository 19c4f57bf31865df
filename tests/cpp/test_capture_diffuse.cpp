// From photographs under diffuse light to w and mu: what is found, how sure it is, what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "capture/diffuse.hpp"
#include "capture/simulate.hpp"

namespace {

using namespace togishi;

constexpr double deg = std::numbers::pi / 180;
constexpr double incidence = 25 * deg;

struct Scene {
    SurfaceView view;
    PixelTruth truth;
};

Scene plate_scene(int width, int height, double variation = 0.05) {
    const glm::dvec3 eye = 800.0 * glm::dvec3(0, std::cos(incidence), -std::sin(incidence));
    Scene scene;
    scene.view = view_of_plate(
        {{40, 20}, {0, 250}},
        camera_looking_at(eye, {0, 0, 0}, {0, 0, 1}, false, width / 38.0, width, height));
    scene.truth = maps_in_view(scene.view, plate_maps(256, 128, 0.8, 5, variation, 7));
    return scene;
}

// A soft box of +-8 degrees whose middle lies `shift` degrees beyond the mirror direction.
DiffuseSource soft_box(double shift_deg, double distance_mm = 700) {
    const double a = incidence + shift_deg * deg;
    const glm::dvec3 to(0, std::cos(a), std::sin(a));
    DiffuseSource source;
    source.centre_mm = distance_mm * to;
    const double half = distance_mm * std::tan(8 * deg);
    source.half_u_mm = {2 * half, 0, 0};
    source.half_v_mm = half * glm::dvec3(0, -to.z, to.y);
    return source;
}

RadianceOptions reference() {
    RadianceOptions options;
    options.metal = "iron_johnson_christy";
    options.light = "line:550";
    return options;
}

DiffuseOptions as_known() {
    DiffuseOptions options;
    options.light = "line:550";
    options.ji = {0.8, 0.8, 0, -1};
    options.ha = {5, 5, 0, -1};
    return options;
}

DiffusePhotograph photograph(const Scene& scene, const DiffuseSource& source, double blur_px,
                             std::uint64_t seed, const RadianceOptions& light = reference()) {
    const auto radiance = reference_radiance(scene.view, scene.truth, source, light);
    SensorOptions sensor;
    sensor.scale = 0.8 / (*std::max_element(radiance.begin(), radiance.end()) + 1e-9);
    sensor.blur_px = blur_px;
    sensor.seed = seed;
    const Camera& camera = scene.view.camera;
    const std::vector<float> picture =
        expose(radiance, camera.width_px, camera.height_px, sensor, seed);
    const PictureNoise noise{1 / (sensor.snr * sensor.snr), sensor.read, 1.0 / 4095};
    DiffusePhotograph out;
    out.source = source;
    for (const float v : picture) {
        out.radiance.push_back(static_cast<float>(v / sensor.scale));
        out.sigma.push_back(static_cast<float>(noise.sigma(v) / sensor.scale));
        out.clipped.push_back(v >= 1 ? 1 : 0);
    }
    return out;
}

// Value below which a share of the values lies; 0 for none.
double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at),
                     values.end());
    return values[at];
}

struct Errors {
    std::vector<double> w, mu;             // absolute, of unmasked pixels
    double covered_w = 0, covered_mu = 0;  // share within one sigma
};

Errors errors_of(const Scene& scene, const DiffuseResult& found) {
    Errors errors;
    double in_w = 0, in_mu = 0;
    for (std::size_t i = 0; i < scene.view.pixels(); ++i) {
        const double w = scene.truth.at(i, MapChannel::w);
        if ((found.mask[i] & mask_no_w) == 0) {
            errors.w.push_back(std::abs(found.w[i] - w));
            if (errors.w.back() <= found.sigma_w[i]) in_w += 1;
        }
        if ((found.mask[i] & mask_no_mu) == 0) {
            const bool ha = found.w[i] > 0.5F;
            const double truth =
                scene.truth.at(i, ha ? MapChannel::ha_ln_mu_deg : MapChannel::ji_ln_mu_deg);
            const double value = ha ? found.ha_ln_mu_deg[i] : found.ji_ln_mu_deg[i];
            errors.mu.push_back(std::abs(value - truth));
            if (errors.mu.back() <= (ha ? found.sigma_ha[i] : found.sigma_ji[i])) in_mu += 1;
        }
    }
    errors.covered_w = in_w / std::max<double>(1, static_cast<double>(errors.w.size()));
    errors.covered_mu = in_mu / std::max<double>(1, static_cast<double>(errors.mu.size()));
    return errors;
}

TEST(CaptureDiffuse, OneSourceGivesTheSharesWhereTheLobesAreKnown) {
    const Scene scene = plate_scene(48, 20, 0.03);
    const DiffuseResult found =
        solve_diffuse(scene.view, {photograph(scene, soft_box(0), 0.5, 1)}, as_known());
    EXPECT_FALSE(found.mu_measured);
    EXPECT_EQ(found.masked(mask_flat_mu), found.seen());
    const Errors errors = errors_of(scene, found);
    EXPECT_GT(errors.w.size(), found.seen() / 2);
    EXPECT_LT(quantile(errors.w, 0.9), 0.08);
    EXPECT_GT(errors.covered_w, 0.6);
}

TEST(CaptureDiffuse, TwoPositionsGiveTheHalfWidthsToo) {
    const Scene scene = plate_scene(48, 20);
    DiffuseOptions options = as_known();
    options.spread = 0.3;
    options.ji = {1.0, 1.0, 0, -1};  // 25 % and 20 % off what the plate has
    options.ha = {4, 4, 0, -1};
    const DiffuseResult found = solve_diffuse(
        scene.view,
        {photograph(scene, soft_box(-9), 0.5, 1), photograph(scene, soft_box(9), 0.5, 2)}, options);
    EXPECT_TRUE(found.mu_measured);
    const Errors errors = errors_of(scene, found);
    EXPECT_GT(errors.w.size(), found.seen() / 2);
    EXPECT_GT(errors.mu.size(), found.seen() / 3);
    EXPECT_LT(quantile(errors.w, 0.9), 0.08);
    EXPECT_LT(quantile(errors.mu, 0.9), 0.10);
    // The prior alone would be off by ln 1.25.
    EXPECT_LT(quantile(errors.mu, 0.5), 0.05);
}

// One pixel, many times: its own noise, and a surface drawn from the prior that the fit is told.
TEST(CaptureDiffuse, SigmaCoversTheErrors) {
    const Scene scene = plate_scene(48, 20);
    DiffuseOptions options = as_known();
    options.spread = 0.15;
    options.model_error = 0;
    const std::array<DiffuseSource, 2> sources{soft_box(-9), soft_box(9)};
    const LuminousFresnel fresnel(options.metal, options.light);
    RandomNormal random(3);
    for (const std::size_t pixel : {std::size_t{10 * 48 + 8}, std::size_t{5 * 48 + 30}}) {
        const SurfacePose pose{scene.view.position_mm[pixel],
                               glm::normalize(glm::dvec3(scene.view.normal[pixel])),
                               glm::dvec3(scene.view.tangent[pixel]),
                               scene.view.camera.view(scene.view.position_mm[pixel])};
        SurfaceView one;
        constexpr int trials = 400;
        one.camera = scene.view.camera.cropped(0, 0, trials, 1);
        one.seen.assign(trials, 1);
        one.position_mm.assign(trials, scene.view.position_mm[pixel]);
        one.normal.assign(trials, scene.view.normal[pixel]);
        one.tangent.assign(trials, scene.view.tangent[pixel]);
        one.uv.assign(trials, glm::vec2(0));
        std::vector<DiffusePhotograph> photographs(2);
        std::vector<double> w(trials), ji(trials), ha(trials);
        std::vector<DiffuseResponse> responses;
        responses.reserve(2);
        for (const DiffuseSource& source : sources)
            responses.emplace_back(source, pose, fresnel, LobeWeights{}, 1.2);
        for (std::size_t k = 0; k < trials; ++k) {
            w[k] = 0.15 + 0.7 * random.uniform();
            ji[k] = options.spread * random.normal();
            ha[k] = options.spread * random.normal();
            for (std::size_t p = 0; p < 2; ++p) {
                const double sigma = 0.004;
                const double radiance =
                    (1 - w[k]) * responses[p].ji({std::log(0.8) + ji[k], 0, 0}) +
                    w[k] * responses[p].ha({std::log(5) + ha[k], 0, 0});
                photographs[p].radiance.push_back(
                    static_cast<float>(radiance + sigma * random.normal()));
                photographs[p].sigma.push_back(static_cast<float>(sigma));
                photographs[p].clipped.push_back(0);
                photographs[p].source = sources[p];
            }
        }
        const DiffuseResult found = solve_diffuse(one, photographs, options);
        double in_w = 0, in_ji = 0, in_ha = 0;
        for (std::size_t k = 0; k < trials; ++k) {
            in_w += std::abs(found.w[k] - w[k]) < found.sigma_w[k];
            in_ji += std::abs(found.ji_ln_mu_deg[k] - std::log(0.8) - ji[k]) < found.sigma_ji[k];
            in_ha += std::abs(found.ha_ln_mu_deg[k] - std::log(5) - ha[k]) < found.sigma_ha[k];
        }
        for (const double inside : {in_w, in_ji, in_ha}) {
            EXPECT_GT(inside / trials, 0.60) << pixel;
            EXPECT_LT(inside / trials, 0.78) << pixel;
        }
    }
}

// The middle of the plate is whitened; without the third lobe that would pass for hamon.
TEST(CaptureDiffuse, HadoriIsAThirdLobe) {
    Scene scene = plate_scene(32, 12, 0.03);
    const auto whitened = [](std::size_t pixel) {
        const std::size_t x = pixel % 32;
        return x >= 23 && x < 28 ? 0.8F : 0.0F;  // in the ji: u runs to the left
    };
    for (std::size_t i = 0; i < scene.view.pixels(); ++i)
        scene.truth.values[i * map_channel_count + std::size_t(MapChannel::h)] = whitened(i);
    std::vector<DiffusePhotograph> photographs;
    for (const double shift : {-9.0, 0.0, 9.0, 12.0}) {
        RadianceOptions light = reference();
        light.hadori = {std::log(2.2), 0, 0};
        photographs.push_back(
            photograph(scene, soft_box(shift), 0.5, photographs.size() + 1, light));
    }
    DiffuseOptions options = as_known();
    options.spread = 0.05;
    EXPECT_THROW((void)solve_diffuse(scene.view, {photographs[0]},
                                     [&] {
                                         DiffuseOptions one = options;
                                         one.hadori = MaterialLobe{2.2, 2.2, 0, -1};
                                         return one;
                                     }()),
                 InputError);
    const DiffuseResult two_lobes = solve_diffuse(scene.view, photographs, options);
    options.hadori = MaterialLobe{2.2, 2.2, 0, -1};
    const DiffuseResult found = solve_diffuse(scene.view, photographs, options);
    std::vector<double> error, mistaken;
    for (std::size_t i = 0; i < scene.view.pixels(); ++i) {
        if ((found.mask[i] & mask_no_w) != 0) continue;
        const double w = scene.truth.at(i, MapChannel::w);
        error.push_back(std::abs((1 - found.w[i]) * found.h[i] - (1 - w) * whitened(i)));
        error.push_back(std::abs(found.w[i] - w));
        if (whitened(i) > 0) mistaken.push_back(std::abs(two_lobes.w[i] - w));
    }
    EXPECT_GT(error.size(), found.seen());  // half of the surface or more
    EXPECT_LT(quantile(error, 0.9), 0.08);
    EXPECT_GT(quantile(mistaken, 0.5), 0.1);
    const PropertyMaps maps = diffuse_maps(found, options);
    EXPECT_EQ(maps[MapChannel::h].size(), found.h.size());
}

TEST(CaptureDiffuse, PixelsBesideTheOutlineAreMasked) {
    Scene scene = plate_scene(24, 10);
    scene.view.seen[5 * 24 + 12] = 0;
    DiffuseOptions options = as_known();
    const DiffusePhotograph picture = photograph(scene, soft_box(0), 0.5, 1);
    const DiffuseResult found = solve_diffuse(scene.view, {picture}, options);
    for (const std::size_t beside : {4u * 24 + 11, 5u * 24 + 13, 6u * 24 + 12})
        EXPECT_NE(found.mask[beside] & mask_border, 0) << beside;
    EXPECT_EQ(found.mask[5 * 24 + 14] & mask_border, 0);
    options.border_px = 0;
    EXPECT_EQ(solve_diffuse(scene.view, {picture}, options).masked(mask_border), 0u);
    options.border_px = -1;
    EXPECT_THROW((void)solve_diffuse(scene.view, {picture}, options), InputError);
}

TEST(CaptureDiffuse, AnEvenHemisphereTellsNothingAndSaysSo) {
    const Scene scene = plate_scene(12, 5);
    DiffuseSource dome;
    dome.kind = SourceKind::hemisphere;
    dome.half_u_mm = {0, 1, 0};
    dome.far_away = true;
    const DiffusePhotograph picture = photograph(scene, dome, 0, 1);
    // The premise: the same radiance for both polishes, to a per cent.
    const auto [low, high] = std::minmax_element(picture.radiance.begin(), picture.radiance.end());
    EXPECT_LT((*high - *low) / *high, 0.08);
    try {
        (void)solve_diffuse(scene.view, {picture, picture}, as_known());
        FAIL() << "not refused";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("hemisphere"), std::string::npos);
    }
}

TEST(CaptureDiffuse, WithoutGeometryTwoAreasCalibrate) {
    // Flat and the source far away, so that it looks the same everywhere.
    Scene scene;
    scene.view = view_of_plate(
        {{40, 20}, {0, 0}},
        camera_looking_at(800.0 * glm::dvec3(0, std::cos(incidence), -std::sin(incidence)),
                          {0, 0, 0}, {0, 0, 1}, false, 48 / 38.0, 48, 20));
    scene.truth = maps_in_view(scene.view, plate_maps(256, 128, 0.8, 5, 0.02, 7));
    DiffusePhotograph picture = photograph(scene, soft_box(0, 20000), 0.5, 1);
    for (float& v : picture.radiance) v *= 3;  // any scale
    for (float& v : picture.sigma) v *= 3;
    // Seen from +y the plate's u runs to the left.
    const std::vector<ReferenceArea> areas{{37, 4, 8, 10, false, 0.8}, {18, 4, 6, 10, true, 5}};
    const DiffuseResult found = solve_by_references(48, 20, {picture}, areas, as_known());
    EXPECT_NE(found.calibration.find("two reference areas"), std::string::npos);
    EXPECT_LT(quantile(errors_of(scene, found).w, 0.9), 0.08);
    EXPECT_THROW((void)solve_by_references(48, 20, {picture}, {areas[0]}, as_known()), InputError);
    EXPECT_THROW((void)solve_by_references(48, 20, {picture}, {areas[0], {37, 4, 8, 10, true, 5}},
                                           as_known()),
                 InputError);
    EXPECT_THROW((void)solve_by_references(48, 20, {picture}, {areas[0], {44, 4, 8, 10, true, 5}},
                                           as_known()),
                 InputError);
}

TEST(CaptureDiffuse, BadPixelsAreMaskedAndBadInputIsNamed) {
    const Scene scene = plate_scene(12, 5);
    DiffusePhotograph picture = photograph(scene, soft_box(0), 0, 1);
    picture.radiance[3] = NAN;
    picture.radiance[7] = 40;  // nothing is so bright
    picture.clipped[5] = 1;
    const DiffuseResult found = solve_diffuse(scene.view, {picture}, as_known());
    EXPECT_EQ(found.mask[3], mask_not_finite);
    EXPECT_NE(found.mask[5] & mask_clipped, 0);
    EXPECT_NE(found.mask[7] & mask_misfit, 0);
    const PropertyMaps maps = diffuse_maps(found, as_known());
    for (const auto& plane : maps.channels)
        for (const float v : plane) EXPECT_TRUE(std::isfinite(v));
    DiffusePhotograph cut = picture;
    cut.radiance.pop_back();
    EXPECT_THROW((void)solve_diffuse(scene.view, {cut}, as_known()), InputError);
    EXPECT_THROW((void)solve_diffuse(scene.view, {}, as_known()), InputError);
    EXPECT_THROW(
        (void)solve_diffuse(scene.view, {picture}, as_known(), [](double) { return false; }),
        DiffuseCancelled);
}

TEST(CaptureDiffuse, NoiseIsReadOffThePicture) {
    const int width = 256, height = 128;
    std::vector<double> slope(static_cast<std::size_t>(width * height));
    for (std::size_t i = 0; i < slope.size(); ++i)
        slope[i] = 0.05 + 0.8 * static_cast<double>(i % width) / width;
    SensorOptions sensor;
    sensor.blur_px = 0;
    sensor.read = 2e-3;
    const PictureNoise noise =
        estimate_noise(expose(slope, width, height, sensor, 0), width, height);
    for (const double v : {0.1, 0.4, 0.8})
        EXPECT_NEAR(noise.sigma(v), std::sqrt(1e-4 * v + 4e-6), 0.12 * noise.sigma(v)) << v;
}

}  // namespace
