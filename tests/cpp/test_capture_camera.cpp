// Cameras from landmarks: exact marks give the camera back, blurred ones its error, and landmarks
// that tell no camera are refused.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "capture/camera_pose.hpp"
#include "scan/random_normal.hpp"

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

}  // namespace
