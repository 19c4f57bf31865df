#include "capture/camera_pose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Dense>

#include "base/error.hpp"
#include "capture/camera_step.hpp"

namespace togishi {
namespace {

std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

// Centre and spread of the landmarks; refuses what no camera could be told by.
struct Cloud {
    glm::dvec3 centre{0};
    Eigen::Vector3d spread;  // standard deviations along the principal axes, the least first
    Eigen::Matrix3d axes;
};

Cloud checked(const std::vector<Landmark>& landmarks, std::size_t least) {
    if (landmarks.size() < least) {
        throw InputError("landmarks", "number", std::to_string(landmarks.size()),
                         std::to_string(least) + " or more");
    }
    Cloud cloud;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
        const Landmark& a = landmarks[i];
        for (const double v : {a.point_mm.x, a.point_mm.y, a.point_mm.z, a.pixel.x, a.pixel.y}) {
            if (!(std::abs(v) < 1e7))
                throw InputError("landmarks", a.name, number(v), "finite mm and pixels");
        }
        for (std::size_t k = 0; k < i; ++k) {
            const Landmark& b = landmarks[k];
            if (glm::length(a.point_mm - b.point_mm) < 1e-3)
                throw InputError("landmarks", a.name, "the same place as " + b.name,
                                 "another place on the blade");
            if (glm::length(a.pixel - b.pixel) < 1e-3)
                throw InputError("landmarks", a.name, "the same pixel as " + b.name,
                                 "another pixel");
        }
        cloud.centre += a.point_mm / static_cast<double>(landmarks.size());
    }
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Landmark& one : landmarks) {
        const glm::dvec3 d = one.point_mm - cloud.centre;
        const Eigen::Vector3d v(d.x, d.y, d.z);
        second += v * v.transpose() / static_cast<double>(landmarks.size());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(second);
    cloud.spread = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    cloud.axes = eigen.eigenvectors();
    // 1 mm off a line of 700 mm leaves the roll about it to 1 pixel's luck.
    if (!(cloud.spread[1] > 4e-3 * cloud.spread[2])) {
        throw InputError("landmarks", "places", "on a line",
                         "places that are not on a line: both edge and back, not the edge alone");
    }
    return cloud;
}

void residuals(CameraFit& fit, const std::vector<Landmark>& landmarks, double max_residual_mm) {
    double sum = 0;
    std::size_t worst = 0;
    for (const Landmark& one : landmarks) {
        const auto pixel = fit.camera.project(one.point_mm);
        if (!pixel) {
            throw InputError("landmarks", one.name, "behind the camera",
                             "marks that one camera can see");
        }
        const double px = glm::length(*pixel - one.pixel);
        const double per_mm = fit.camera.pinhole
                                  ? fit.camera.scale / fit.camera.depth_mm(one.point_mm)
                                  : fit.camera.scale;
        fit.residual_px.push_back(px);
        fit.residual_mm.push_back(px / per_mm);
        sum += fit.residual_mm.back() * fit.residual_mm.back();
        if (fit.residual_mm.back() > fit.residual_mm[worst]) worst = fit.residual_mm.size() - 1;
    }
    fit.rms_mm = std::sqrt(sum / static_cast<double>(landmarks.size()));
    if (fit.residual_mm[worst] > max_residual_mm) {
        throw InputError("landmarks", landmarks[worst].name,
                         number(fit.residual_mm[worst]) + " mm off",
                         "within " + number(max_residual_mm) +
                             " mm of where the others put it: a wrong mark, or a blade of other "
                             "dimensions");
    }
}

// Least squares of the pixels over rotation, place and scale.
void refine(Camera& camera, const std::vector<Landmark>& landmarks) {
    fit_camera(camera, [&](const Camera& with) {
        Eigen::VectorXd r(static_cast<Eigen::Index>(2 * landmarks.size()));
        for (std::size_t k = 0; k < landmarks.size(); ++k) {
            const auto pixel = with.project(landmarks[k].point_mm);
            const glm::dvec2 d = pixel ? *pixel - landmarks[k].pixel : glm::dvec2(1e6);
            r[static_cast<Eigen::Index>(2 * k)] = d.x;
            r[static_cast<Eigen::Index>(2 * k + 1)] = d.y;
        }
        return r;
    });
}

double squared_error(const Camera& camera, const std::vector<Landmark>& landmarks) {
    double sum = 0;
    for (const Landmark& one : landmarks) {
        const auto pixel = camera.project(one.point_mm);
        const glm::dvec2 d = pixel ? *pixel - one.pixel : glm::dvec2(1e6);
        sum += glm::dot(d, d);
    }
    return sum;
}

}  // namespace

CameraFit fit_orthographic_camera(const std::vector<Landmark>& landmarks, int width_px,
                                  int height_px, const glm::dvec3& facing, double max_residual_mm) {
    const Cloud cloud = checked(landmarks, 4);
    if (!(glm::length(facing) > 1e-9))
        throw InputError("landmarks", "facing", "of length 0", "a direction to the camera");
    const glm::dvec3 to = glm::normalize(facing);
    glm::dvec2 middle(0);
    for (const Landmark& one : landmarks) middle += one.pixel / double(landmarks.size());
    double spread_px = 0;
    for (const Landmark& one : landmarks) spread_px += glm::length(one.pixel - middle);
    double spread_mm = 0;
    for (const Landmark& one : landmarks) spread_mm += glm::length(one.point_mm - cloud.centre);
    // Starts: from `facing`, turned about it in steps; a least-squares fit is convex enough
    // between.
    CameraFit best;
    double best_error = INFINITY;
    const glm::dvec3 other = std::abs(to.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    const glm::dvec3 e = glm::normalize(glm::cross(other, to)), f = glm::cross(to, e);
    for (int k = 0; k < 12; ++k) {
        const double angle = k * 3.14159265358979323846 / 6;
        Camera camera;
        camera.width_px = width_px;
        camera.height_px = height_px;
        camera.position_mm = cloud.centre;
        camera.centre_px = middle;
        camera.scale = std::max(spread_px / std::max(spread_mm, 1e-9), 1e-6);
        camera.right = std::cos(angle) * e + std::sin(angle) * f;
        // forward = right x down looks against `facing`.
        camera.down = glm::normalize(glm::cross(-to, camera.right));
        refine(camera, landmarks);
        if (glm::dot(-camera.forward(), to) < 0.5) continue;
        const double error = squared_error(camera, landmarks);
        if (error < best_error) {
            best_error = error;
            best.camera = camera;
        }
    }
    if (!std::isfinite(best_error)) {
        throw InputError("landmarks", "marks", "fit no camera within 60 degrees of the given side",
                         "marks of the side that faces the camera");
    }
    check_camera(best.camera, "landmarks");
    residuals(best, landmarks, max_residual_mm);
    return best;
}

CameraFit fit_pinhole_camera(const std::vector<Landmark>& landmarks, int width_px, int height_px,
                             double max_residual_mm) {
    const Cloud cloud = checked(landmarks, 6);
    if (!(cloud.spread[0] > 1e-3 * cloud.spread[2])) {
        throw InputError("landmarks", "places", "in one plane",
                         "places at different depths (the shinogi and both edges do), or an "
                         "orthographic camera");
    }
    // Direct linear transformation, whitened: a blade is long and thin.
    const auto n = static_cast<Eigen::Index>(landmarks.size());
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * n, 12);
    const Eigen::Matrix3d whiten =
        cloud.spread.cwiseInverse().asDiagonal() * cloud.axes.transpose();
    const double half = 0.5 * std::max(width_px, height_px);
    for (Eigen::Index k = 0; k < n; ++k) {
        const Landmark& one = landmarks[static_cast<std::size_t>(k)];
        const glm::dvec3 d = one.point_mm - cloud.centre;
        Eigen::Vector4d p;
        p << whiten * Eigen::Vector3d(d.x, d.y, d.z), 1;
        const double u = (one.pixel.x - 0.5 * width_px) / half,
                     v = (one.pixel.y - 0.5 * height_px) / half;
        a.row(2 * k).segment<4>(0) = p.transpose();
        a.row(2 * k).segment<4>(8) = -u * p.transpose();
        a.row(2 * k + 1).segment<4>(4) = p.transpose();
        a.row(2 * k + 1).segment<4>(8) = -v * p.transpose();
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeFullV);
    const Eigen::VectorXd h = svd.matrixV().col(11);
    Eigen::Matrix<double, 3, 4> projection;
    for (int row = 0; row < 3; ++row) projection.row(row) = h.segment<4>(4 * row).transpose();
    Eigen::Matrix3d m = projection.leftCols<3>() * whiten;
    Eigen::Vector3d t = projection.col(3);
    if (m.determinant() < 0) {
        m = -m;
        t = -t;
    }
    CameraFit fit;
    Camera& camera = fit.camera;
    camera.pinhole = true;
    camera.width_px = width_px;
    camera.height_px = height_px;
    camera.centre_px = glm::dvec2(width_px, height_px) * 0.5;
    const Eigen::Vector3d eye = -m.colPivHouseholderQr().solve(t);
    camera.position_mm = cloud.centre + glm::dvec3(eye.x(), eye.y(), eye.z());
    const Eigen::Vector3d forward = m.row(2).transpose().normalized();
    const Eigen::Vector3d r0 = m.row(0).transpose(),
                          right = (r0 - forward * forward.dot(r0)).normalized();
    camera.right = {right.x(), right.y(), right.z()};
    camera.down =
        glm::normalize(glm::cross(glm::dvec3(forward.x(), forward.y(), forward.z()), camera.right));
    camera.scale = half * (r0 - forward * forward.dot(r0)).norm() / m.row(2).norm();
    if (!std::isfinite(camera.scale) || !(camera.scale > 0)) {
        throw InputError("landmarks", "places", "give no camera",
                         "six or more, well spread over the blade and at different depths");
    }
    refine(camera, landmarks);
    check_camera(camera, "landmarks");
    residuals(fit, landmarks, max_residual_mm);
    return fit;
}

namespace {

struct NamedLandmark {
    const char* name;
    std::int32_t (*vertex)(const KatanaLandmarks&);
};
constexpr std::array<NamedLandmark, 13> named{{
    {"tip", [](const KatanaLandmarks& l) { return l.tip; }},
    {"ha_machi", [](const KatanaLandmarks& l) { return l.machi_edge; }},
    {"mune_machi", [](const KatanaLandmarks& l) { return l.machi_ridge; }},
    {"yokote_ridge", [](const KatanaLandmarks& l) { return l.yokote_ridge; }},
    {"yokote_edge", [](const KatanaLandmarks& l) { return l.yokote_edge; }},
    {"omote_machi_shinogi", [](const KatanaLandmarks& l) { return l.machi_shinogi[0]; }},
    {"ura_machi_shinogi", [](const KatanaLandmarks& l) { return l.machi_shinogi[1]; }},
    {"omote_yokote_shinogi", [](const KatanaLandmarks& l) { return l.yokote_shinogi[0]; }},
    {"ura_yokote_shinogi", [](const KatanaLandmarks& l) { return l.yokote_shinogi[1]; }},
    {"omote_machi_corner", [](const KatanaLandmarks& l) { return l.machi_corner[0]; }},
    {"ura_machi_corner", [](const KatanaLandmarks& l) { return l.machi_corner[1]; }},
    {"omote_yokote_corner", [](const KatanaLandmarks& l) { return l.yokote_corner[0]; }},
    {"ura_yokote_corner", [](const KatanaLandmarks& l) { return l.yokote_corner[1]; }},
}};

}  // namespace

std::vector<std::string> blade_landmark_names() {
    std::vector<std::string> names;
    names.reserve(named.size());
    for (const NamedLandmark& one : named) names.emplace_back(one.name);
    return names;
}

glm::dvec3 blade_landmark(const KatanaMesh& mesh, const std::string& name) {
    std::string all;
    for (const NamedLandmark& one : named) {
        if (name == one.name)
            return mesh.positions_mm[static_cast<std::size_t>(one.vertex(mesh.landmarks))];
        all += (all.empty() ? "" : ", ") + std::string(one.name);
    }
    throw InputError("landmarks", "name", name, all);
}

}  // namespace togishi
