// The rough pose of a scanned blade: axis, back and tip, over generated scans.
#include <gtest/gtest.h>

#include "scanned/coarse_pose.hpp"
#include "simulate_scan_mesh.hpp"

namespace togishi {
namespace {

struct Found {
    double tip = 0;   // cosine between the found and the true direction of the tip
    double back = 0;  // ... and of the back
    CoarsePose pose;
};

Found find(const ScanMesh& scan, const PoseCorrection& correction = {}) {
    Found found;
    found.pose = find_coarse_pose(scan.mesh, find_pieces(scan.mesh), correction);
    const glm::dmat3 axes = glm::transpose(found.pose.rotation);
    found.tip = glm::dot(axes[0], scan.rotation[0]);
    found.back = glm::dot(axes[2], scan.rotation[2]);
    return found;
}

TEST(ScanPose, TipAndBackAreFoundInAnyPose) {
    for (std::size_t i = 0; i < scan_shapes.size(); ++i) {
        for (std::uint64_t variant = 0; variant < 2; ++variant) {
            ScanMeshOptions options;
            options.triangles = 20000;
            options.seed = 10 * i + variant + 1;
            options.noise_mm = variant == 0 ? 0.02 : 0.1;
            options.offset_mm = 1e5;
            options.habaki = i % 2 == 0;
            options.tang = (i + variant) % 3 != 0;
            options.stand = variant == 1;
            options.edge_holes = 4;
            const Found found = find(simulate_scan_mesh(scan_shape(scan_shapes.at(i)), options));
            EXPECT_GT(found.tip, 0.99) << scan_shapes.at(i) << ' ' << variant;
            EXPECT_GT(found.back, 0.99) << scan_shapes.at(i) << ' ' << variant;
            EXPECT_NEAR(glm::determinant(found.pose.rotation), 1, 1e-9);
            EXPECT_TRUE(found.pose.point);
        }
    }
}

TEST(ScanPose, StandAndScaleBarAreKeptAside) {
    ScanMeshOptions options;
    options.triangles = 20000;
    options.stand = true;
    const ScanMesh scan = simulate_scan_mesh(scan_shape("tanto"), options);
    const MeshPieces pieces = find_pieces(scan.mesh);
    const CoarsePose pose = find_coarse_pose(scan.mesh, pieces);
    for (std::size_t f = 0; f < scan.part.size(); ++f)
        ASSERT_EQ(pose.body[pieces.of[f]] != 0, scan.part[f] != Part::other);
}

TEST(ScanPose, MachiIsFoundAndMissedWhereThereIsNoTang) {
    ScanMeshOptions options;
    options.triangles = 20000;
    const ScanMesh scan = simulate_scan_mesh(scan_shape("wakizashi"), options);
    const CoarsePose pose = find(scan).pose;
    ASSERT_TRUE(pose.tang);
    EXPECT_NEAR((pose.rotation * (scan.origin - pose.origin)).x, pose.machi_x, 4);
    options.tang = false;
    EXPECT_FALSE(find(simulate_scan_mesh(scan_shape("wakizashi"), options)).pose.tang);
}

TEST(ScanPose, TheUsersWordTurnsIt) {
    ScanMeshOptions options;
    options.triangles = 20000;
    const ScanMesh scan = simulate_scan_mesh(scan_shape("shobu"), options);
    PoseCorrection correction;
    correction.swap_ends = true;
    EXPECT_LT(find(scan, correction).tip, -0.99);
    correction = {};
    correction.swap_edge_and_back = true;
    EXPECT_LT(find(scan, correction).back, -0.99);
}

}  // namespace
}  // namespace togishi
