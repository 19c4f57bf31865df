// Maps of photographs onto the blade: known maps photographed and brought back; seams; directions.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "blade/katana_mesh.hpp"
#include "brdf/model.hpp"
#include "capture/project.hpp"
#include "capture/simulate.hpp"

namespace {

using namespace togishi;

constexpr std::size_t width = 512, height = 64;

const KatanaMesh& blade() {
    static const KatanaMesh mesh = make_katana(katana_defaults(), 0.2);
    return mesh;
}

Camera over(double x_mm, int width_px) {
    return camera_looking_at({x_mm, 900, -25}, {x_mm, 0, -25}, {0, 0, 1}, false, 4, width_px, 240);
}

// Smooth maps whose truth is known anywhere on the chart.
PropertyMaps smooth_maps() {
    PropertyMaps maps;
    maps.width = width;
    maps.height = height;
    for (auto& plane : maps.channels) plane.assign(width * height, 0.0F);
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = y * width + x;
            const double u = (double(x) + 0.5) / width;
            maps[MapChannel::ji_ln_mu_deg][i] = static_cast<float>(0.2 * std::sin(30 * u));
            maps[MapChannel::ji_e1][i] = 0.3F;
            maps[MapChannel::ji_e2][i] = 0.1F;
            maps[MapChannel::ha_ln_mu_deg][i] = 1.5F;
            maps[MapChannel::w][i] = static_cast<float>(0.5 + 0.4 * std::sin(20 * u));
        }
    }
    return maps;
}

// What an evaluation would make of a photograph, were it exact.
ProjectedMap photographed(const PropertyMaps& truth, const Camera& camera) {
    const SurfaceView view = view_of_mesh(blade(), camera);
    const PixelTruth pixels = maps_in_view(view, truth);
    ProjectedMap out;
    out.camera = camera;
    out.maps.width = static_cast<std::size_t>(camera.width_px);
    out.maps.height = static_cast<std::size_t>(camera.height_px);
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        auto& plane = out.maps.channels[c];
        plane.resize(view.pixels());
        for (std::size_t i = 0; i < plane.size(); ++i) {
            const std::size_t row = i / out.maps.width, x = i % out.maps.width;
            plane[(out.maps.height - 1 - row) * out.maps.width + x] =
                pixels.at(i, static_cast<MapChannel>(c));
        }
    }
    return out;
}

ProjectOptions options() {
    ProjectOptions o;
    o.width = width;
    o.height = height;
    return o;
}

TEST(CaptureProject, AMapComesBackWhereItWasPhotographed) {
    const PropertyMaps truth = smooth_maps();
    const ProjectResult found = project_maps(
        blade(), {photographed(truth, over(250, 900)), photographed(truth, over(420, 900))},
        options());
    std::size_t covered = 0;
    for (std::size_t i = 0; i < width * height; ++i) {
        if (!(found.coverage[i] > 0)) continue;
        ++covered;
        for (const MapChannel c : {MapChannel::ji_ln_mu_deg, MapChannel::ji_e1, MapChannel::ji_e2,
                                   MapChannel::ha_ln_mu_deg, MapChannel::w})
            EXPECT_NEAR(found.maps[c][i], truth[c][i], 0.02) << i << ' ' << int(c);
    }
    // Omote from 140 to 530 mm of 948, its half of the chart.
    EXPECT_GT(covered, found.on_blade / 7);
    EXPECT_GT(found.holes, found.on_blade / 3);  // ura is not seen
    EXPECT_EQ(found.on_blade - found.holes, covered);
}

TEST(CaptureProject, PhotographsThatDisagreeMeetWithoutASeam) {
    PropertyMaps bright = smooth_maps(), dark = bright;
    bright[MapChannel::w].assign(width * height, 0.8F);
    dark[MapChannel::w].assign(width * height, 0.2F);
    const ProjectResult found = project_maps(
        blade(), {photographed(bright, over(250, 1000)), photographed(dark, over(420, 1000))},
        options());
    const std::size_t row = height / 4;
    double largest = 0;
    float least = 1, most = 0;
    for (std::size_t x = 1; x < width; ++x) {
        const std::size_t i = row * width + x;
        if (!(found.coverage[i] > 0 && found.coverage[i - 1] > 0)) continue;
        const float w = found.maps[MapChannel::w][i];
        largest = std::max(largest, double(std::abs(w - found.maps[MapChannel::w][i - 1])));
        least = std::min(least, w);
        most = std::max(most, w);
    }
    EXPECT_NEAR(least, 0.2, 0.01);
    EXPECT_NEAR(most, 0.8, 0.01);
    // A step of 0.6 over the overlap of 80 mm, 43 texels: 0.014 each where it is shared out evenly.
    EXPECT_LT(largest, 0.02);
}

// Two polishes in turn under one texel: their variances are averaged, not the logarithms.
TEST(CaptureProject, ATexelHoldsTheMeanVarianceOfItsPixels) {
    Camera camera = over(300, 600);
    ProjectedMap picture = photographed(smooth_maps(), camera);
    for (std::size_t i = 0; i < picture.maps[MapChannel::w].size(); ++i) {
        picture.maps[MapChannel::w][i] = 0;
        picture.maps[MapChannel::h][i] = 0;
        picture.maps[MapChannel::ji_e1][i] = 0;
        picture.maps[MapChannel::ji_e2][i] = 0;
        picture.maps[MapChannel::ji_ln_mu_deg][i] = i % 2 == 0 ? 0.0F : std::log(3.0F);
    }
    const ProjectResult found = project_maps(blade(), {picture}, options());
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < width * height / 4; ++i) {
        if (!(found.coverage[i] > 0)) continue;
        sum += found.maps[MapChannel::ji_ln_mu_deg][i];
        count += 1;
    }
    EXPECT_GT(count, 500);
    // Variances 1 and 9; the logarithms' mean would be ln 3 / 2.
    EXPECT_NEAR(sum / count, 0.5 * std::log(5.0), 0.01);
}

// A photograph's masked pixels are left to the others; where there is none the map has a hole.
TEST(CaptureProject, MaskedPixelsAreFilledByOtherPhotographsOrMarked) {
    PropertyMaps bright = smooth_maps(), dark = bright;
    bright[MapChannel::w].assign(width * height, 0.8F);
    dark[MapChannel::w].assign(width * height, 0.2F);
    ProjectedMap first = photographed(bright, over(300, 600));
    const ProjectedMap second = photographed(dark, over(300, 600));
    first.usable.assign(600u * 240u, 1);
    for (std::size_t i = 0; i < first.usable.size(); ++i)
        if (i % 600 >= 200 && i % 600 < 260) first.usable[i] = 0;
    const ProjectResult alone = project_maps(blade(), {first}, options());
    const ProjectResult both = project_maps(blade(), {first, second}, options());
    const ProjectResult whole = project_maps(blade(), {second}, options());
    EXPECT_GT(alone.holes, whole.holes + 100);
    EXPECT_EQ(both.holes, whole.holes);
    float most = 0;
    for (std::size_t i = 0; i < width * height; ++i) {
        if (!(both.coverage[i] > 0 && alone.coverage[i] == 0)) continue;
        most = std::max(most, std::abs(both.maps[MapChannel::w][i] - 0.2F));
    }
    EXPECT_LT(most, 1e-3F);
}

TEST(CaptureProject, DirectionsAreTurnedFromThePictureToTheBlade) {
    // In the picture's frame the wide axis lies at 30 degrees from its x axis. Seen from +y with
    // the back upwards, x runs to the nakago: T turned by 180 degrees, which a lobe does not see.
    const double angle = 30 * 3.14159265358979323846 / 180;
    const Camera upright = over(300, 600);
    Camera rolled = upright;  // the picture turned by 30 degrees about its middle
    rolled.right = std::cos(angle) * upright.right + std::sin(angle) * upright.down;
    rolled.down = std::cos(angle) * upright.down - std::sin(angle) * upright.right;
    PropertyMaps along = smooth_maps();
    along[MapChannel::ji_e1].assign(width * height, 0.5F);
    along[MapChannel::ji_e2].assign(width * height, 0.0F);
    ProjectedMap picture = photographed(along, rolled);
    picture.frame = MapFrame::image;
    const ProjectResult found = project_maps(blade(), {picture}, options());
    std::size_t checked = 0;
    for (std::size_t i = 0; i < width * height; ++i) {
        if (!(found.coverage[i] > 0)) continue;
        const std::size_t y = i / width;
        if (y > height / 4) continue;  // the omote's side, not the mune
        const auto axes =
            f64::lobe_axes({found.maps[MapChannel::ji_ln_mu_deg][i],
                            found.maps[MapChannel::ji_e1][i], found.maps[MapChannel::ji_e2][i]});
        EXPECT_NEAR(axes.mu_t_rad / axes.mu_b_rad, std::exp(1.0), 0.1);
        // The wide axis lies along the picture's x, which is turned clockwise as the camera sees
        // it.
        const glm::dvec3 x = rolled.right;
        const double expected = std::atan2(x.z, x.x);
        // T is +x, the normal +y, B = N x T = -z: counter-clockwise from outside runs to -z.
        const double rho = axes.rho_rad + expected;
        EXPECT_NEAR(std::sin(rho), 0, 0.15) << axes.rho_rad << ' ' << expected;
        ++checked;
    }
    EXPECT_GT(checked, 500u);
}

TEST(CaptureProject, BadInputIsNamed) {
    EXPECT_THROW((void)project_maps(blade(), {}, options()), InputError);
    ProjectedMap away = photographed(smooth_maps(), over(300, 60));
    away.camera = camera_looking_at({5000, 900, 0}, {5000, 0, 0}, {0, 0, 1}, false, 4, 60, 240);
    EXPECT_THROW((void)project_maps(blade(), {away}, options()), InputError);
    away.camera.width_px = 61;
    EXPECT_THROW((void)project_maps(blade(), {away}, options()), InputError);
}

}  // namespace
