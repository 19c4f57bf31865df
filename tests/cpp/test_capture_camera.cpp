// Cameras from landmarks: exact marks give the camera back, blurred ones its error, and landmarks
// that tell no camera are refused.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "capture/camera_pose.hpp"
#include "capture/camera_surface.hpp"
#include "capture/silhouette.hpp"
#include "capture/simulate.hpp"

namespace {

using namespace togishi;

const KatanaMesh& blade() {
    static const KatanaMesh mesh = make_katana(katana_defaults(), 0.05);
    return mesh;
}

std::vector<Landmark> marks(const Camera& camera, const std::vector<std::string>& names,
                            double noise_px, std::uint64_t seed = 1) {
    RandomNormal random(seed);
    std::vector<Landmark> out;
    for (const std::string& name : names) {
        const glm::dvec3 point = blade_landmark(blade(), name);
        const auto pixel = camera.project(point);
        EXPECT_TRUE(pixel);
        out.push_back(
            {name, point, *pixel + noise_px * glm::dvec2(random.normal(), random.normal())});
    }
    return out;
}

const std::vector<std::string> outline{"tip", "ha_machi", "mune_machi", "yokote_ridge",
                                       "yokote_edge"};
const std::vector<std::string> omote{"tip",
                                     "ha_machi",
                                     "mune_machi",
                                     "yokote_ridge",
                                     "yokote_edge",
                                     "omote_machi_shinogi",
                                     "omote_yokote_shinogi",
                                     "omote_machi_corner",
                                     "omote_yokote_corner"};

// Largest distance in pixels between where two cameras see the omote's landmarks.
double apart(const Camera& a, const Camera& b) {
    double most = 0;
    for (const std::string& name : omote) {
        const glm::dvec3 point = blade_landmark(blade(), name);
        most = std::max(most, glm::length(*a.project(point) - *b.project(point)));
    }
    return most;
}

TEST(CaptureCamera, AnOrthographicPhotographIsFoundFromItsOutline) {
    for (const glm::dvec3 eye : {glm::dvec3(350, 900, -20), glm::dvec3(300, 900, 200)}) {
        for (const glm::dvec3 up : {glm::dvec3(0, 0, 1), glm::dvec3(-1, 0, 0.2)}) {
            const Camera camera = camera_looking_at(eye, {350, 0, -20}, up, false, 4, 3200, 400);
            const CameraFit exact =
                fit_orthographic_camera(marks(camera, omote, 0), 3200, 400, {0, 1, 0});
            EXPECT_LT(apart(exact.camera, camera), 1e-4);
            EXPECT_LT(exact.rms_mm, 1e-5);
            EXPECT_NEAR(glm::dot(exact.camera.forward(), camera.forward()), 1, 1e-6);
            const CameraFit marked =
                fit_orthographic_camera(marks(camera, omote, 0.5), 3200, 400, {0, 1, 0});
            EXPECT_LT(apart(marked.camera, camera), 2.5);
            EXPECT_GT(marked.rms_mm, 0.02);
            EXPECT_LT(marked.rms_mm, 0.3);
        }
    }
}

TEST(CaptureCamera, APinholeIsFoundWithItsFocalLength) {
    const Camera camera =
        camera_looking_at({250, 900, 150}, {350, 0, -20}, {0, 0.1, 1}, true, 4000, 4000, 1000);
    const CameraFit exact = fit_pinhole_camera(marks(camera, omote, 0), 4000, 1000);
    EXPECT_LT(apart(exact.camera, camera), 1e-3);
    EXPECT_NEAR(exact.camera.scale, camera.scale, 1e-3 * camera.scale);
    EXPECT_LT(glm::length(exact.camera.position_mm - camera.position_mm), 1);
    const CameraFit marked = fit_pinhole_camera(marks(camera, omote, 0.5), 4000, 1000);
    EXPECT_LT(apart(marked.camera, camera), 3);
    EXPECT_LT(marked.rms_mm, 0.3);
}

TEST(CaptureCamera, DegenerateLandmarksAreRefusedWithTheReason) {
    const Camera camera =
        camera_looking_at({350, 900, -20}, {350, 0, -20}, {0, 0, 1}, false, 4, 3200, 400);
    const auto reason = [&](const std::vector<Landmark>& given, bool pinhole) {
        try {
            if (pinhole) {
                (void)fit_pinhole_camera(given, 3200, 400);
            } else {
                (void)fit_orthographic_camera(given, 3200, 400, {0, 1, 0});
            }
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(reason(marks(camera, {"tip", "ha_machi"}, 0), false).find("number"),
              std::string::npos);
    std::vector<Landmark> line;
    for (const double x : {0.0, 100.0, 300.0, 500.0, 600.0, 700.0})
        line.push_back({"p" + std::to_string(int(x)), {x, 0, 0}, *camera.project({x, 0, 0})});
    EXPECT_NE(reason(line, false).find("on a line"), std::string::npos);
    std::vector<Landmark> plane = marks(camera, outline, 0);
    plane.push_back({"edge", {300, 0, -40}, *camera.project({300, 0, -40})});
    for (Landmark& one : plane) one.point_mm.y = 0;
    EXPECT_NE(reason(plane, true).find("plane"), std::string::npos);
    std::vector<Landmark> twice = marks(camera, omote, 0);
    twice.push_back(twice.front());
    EXPECT_NE(reason(twice, false).find("same place"), std::string::npos);
    std::vector<Landmark> wrong = marks(camera, omote, 0);
    wrong[3].pixel.y += 80;
    EXPECT_NE(reason(wrong, false).find("mm off"), std::string::npos);
    wrong[3].pixel.y = NAN;
    EXPECT_NE(reason(wrong, false).find("finite"), std::string::npos);
    EXPECT_THROW((void)blade_landmark(blade(), "habaki"), InputError);
}

// A dark blade before a bright ground, or the other way round, blurred, with noise.
std::vector<float> outlined(const Camera& camera, double ground, double steel) {
    std::vector<double> value = picture_against_light(blade(), camera);
    for (std::size_t i = 0; i < value.size(); ++i) {
        const auto x = static_cast<double>(i % static_cast<std::size_t>(camera.width_px));
        // Uneven, as steel under a lamp is.
        value[i] = value[i] * ground + (1 - value[i]) * steel * (0.8 + 0.2 * std::sin(0.03 * x));
    }
    SensorOptions sensor;
    sensor.blur_px = 0.8;
    return expose(value, camera.width_px, camera.height_px, sensor, 0);
}

// A pose that is some mm and tenths of a degree off.
Camera disturbed(Camera camera, double mm, double deg) {
    const Camera straight = camera;
    const double a = deg * 3.14159265358979323846 / 180;
    camera.right = glm::normalize(straight.right + a * straight.down - a * straight.forward());
    camera.down = straight.down + a * straight.forward();
    camera.down = glm::normalize(camera.down - camera.right * glm::dot(camera.right, camera.down));
    camera.scale *= 1.003;
    if (camera.pinhole) {
        // Turned about the blade's middle, not about the eye.
        const glm::dvec3 middle(370, 0, -20);
        camera.position_mm = middle -
                             glm::length(straight.position_mm - middle) * camera.forward() +
                             mm * straight.down;
    } else {
        camera.centre_px += camera.scale * glm::dvec2(mm, -mm);
    }
    return camera;
}

TEST(CaptureCamera, TheOutlineCorrectsAPoseThatIsOff) {
    const Camera side =
        camera_looking_at({370, 900, 40}, {370, 0, -20}, {0, 0, 1}, false, 1.5, 1200, 160);
    const Camera eye =
        camera_looking_at({330, 1500, 100}, {370, 0, -20}, {0, 0, 1}, true, 2250, 1200, 160);
    for (const Camera& camera : {side, eye}) {
        const Camera off = disturbed(camera, 1.5, 0.3);
        ASSERT_GT(apart(off, camera), 2.0);
        for (const bool against_light : {true, false}) {
            const std::vector<float> picture =
                outlined(camera, against_light ? 0.9 : 0.05, against_light ? 0.1 : 0.6);
            const SilhouetteFit fit =
                refine_on_silhouette(blade(), off, picture, {}, SilhouetteOptions{});
            EXPECT_LT(apart(fit.camera, camera), 0.45);  // 0.3 mm
            EXPECT_LT(fit.rms_mm, 0.15);
            EXPECT_LE(fit.rms_mm, fit.p90_mm);
            EXPECT_GT(fit.before_rms_mm, 3 * fit.rms_mm);
            EXPECT_GT(fit.points, fit.outline * 9 / 10);
        }
    }
}

TEST(CaptureCamera, BlurredMarksAreCorrectedByTheOutline) {
    const Camera camera =
        camera_looking_at({370, 900, 340}, {370, 0, -20}, {0, 0, 1}, false, 1.5, 1200, 160);
    const std::vector<float> picture = outlined(camera, 0.9, 0.1);
    for (const std::uint64_t seed : {5U, 6U}) {
        const std::vector<Landmark> given = marks(camera, omote, 0.4, seed);
        const CameraFit marked = fit_orthographic_camera(given, 1200, 160, {0, 1, 0});
        const SilhouetteFit fit =
            refine_on_silhouette(blade(), marked.camera, picture, given, SilhouetteOptions{});
        EXPECT_LT(apart(fit.camera, camera), apart(marked.camera, camera));
        // The way that the blade faces, which its light depends on most.
        EXPECT_LT(glm::length(fit.camera.forward() - camera.forward()),
                  0.6 * glm::length(marked.camera.forward() - camera.forward()));
    }
}

TEST(CaptureCamera, AnOutlineThatIsNotThereIsRefused) {
    const Camera camera =
        camera_looking_at({370, 900, 40}, {370, 0, -20}, {0, 0, 1}, false, 1.5, 1200, 160);
    const std::size_t n = 1200u * 160u;
    const auto reason = [&](const Camera& with, const std::vector<float>& picture) {
        try {
            (void)refine_on_silhouette(blade(), with, picture, {}, SilhouetteOptions{});
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(reason(camera, std::vector<float>(n, 0.4F)).find("plain ground"), std::string::npos);
    EXPECT_NE(reason(camera, std::vector<float>(n - 1, 0.4F)).find("as the camera"),
              std::string::npos);
    Camera away = camera;
    away.position_mm.z += 2000;
    EXPECT_NE(reason(away, std::vector<float>(n, 0.4F)).find("outside the picture"),
              std::string::npos);
    // Twenty millimetres off: farther than is looked.
    EXPECT_NE(reason(disturbed(camera, 20, 0), outlined(camera, 0.9, 0.1)).find("within"),
              std::string::npos);
}

}  // namespace
