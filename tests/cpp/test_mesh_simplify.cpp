#include <random>

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "mesh/clean.hpp"
#include "mesh/half_edges.hpp"
#include "mesh/holes.hpp"
#include "mesh/simplify.hpp"
#include "mesh_shapes.hpp"

namespace togishi {
namespace {

TEST(MeshDistance, OfSurfacesOfKnownDistance) {
    const TriangleMesh inner = shapes::ball(10, 24);
    TriangleMesh outer = shapes::ball(10.5, 24);
    EXPECT_LT(mesh_distance(inner, inner).largest, 1e-5);
    const MeshDistance d = mesh_distance(inner, outer, 5000);
    EXPECT_NEAR(d.largest, 0.5, 0.02);
    EXPECT_NEAR(d.rms, 0.5, 0.02);
    EXPECT_GE(d.largest, d.p99);
    // A spike shows in the way from its own surface only.
    outer = inner;
    outer.positions[7] *= 1.2F;
    const MeshDistance spike = mesh_distance(inner, outer, 5000);
    EXPECT_GT(spike.largest_back, 1.5);
    EXPECT_LT(spike.largest_there, 1.3);
    // Origins count.
    outer = inner;
    outer.origin = {1e5, 0, 0};
    EXPECT_NEAR(mesh_distance(inner, outer, 100).largest, 1e5, 25);
    EXPECT_THROW((void)mesh_distance(inner, TriangleMesh{}), InputError);
    EXPECT_THROW((void)mesh_distance(TriangleMesh{}, inner), InputError);
}

TEST(MeshDistance, NearestAgreesWithEveryTriangle) {
    const TriangleMesh mesh = shapes::ball(10, 6);
    const SurfaceTree tree(mesh);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> even(-15, 15);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 p(even(random), even(random), even(random));
        const auto found = tree.nearest(p, 100);
        float least = 100;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            TriangleMesh one;
            one.positions = mesh.positions;
            one.triangles = {mesh.triangles[t]};
            least = std::min(least, SurfaceTree(one).nearest(p, 100).distance);
        }
        EXPECT_FLOAT_EQ(found.distance, least);
        const Triangle& t = mesh.triangles[found.triangle];
        const glm::vec3 at = found.weights[0] * mesh.positions[t[0]] +
                             found.weights[1] * mesh.positions[t[1]] +
                             found.weights[2] * mesh.positions[t[2]];
        EXPECT_LT(glm::length(at - found.point), 1e-4F);
    }
}

void expect_closed(const TriangleMesh& mesh) {
    const HalfEdges edges = link_half_edges(mesh, true);
    EXPECT_TRUE(edges.crowded.empty());
    for (const std::uint32_t twin : edges.twin) EXPECT_NE(twin, no_half_edge);
}

TEST(Simplify, KeepsItsDistanceAndEdges) {
    TriangleMesh mesh = shapes::cube(20, {}, 16);
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0, 0.01F);
    for (glm::vec3& p : mesh.positions) p += glm::vec3(noise(random), noise(random), noise(random));
    mesh.colours.resize(mesh.positions.size(), Colour8{9, 9, 9, 9});
    std::size_t before = mesh.triangles.size();
    for (const double error_mm : {0.03, 0.1, 1.0}) {
        const SimplifiedMesh light = simplify(mesh, {.error_mm = error_mm, .samples = 20'000});
        EXPECT_LE(light.distance.largest, error_mm);
        EXPECT_LE(mesh_distance(mesh, light.mesh, 20000).largest, error_mm);
        EXPECT_LT(light.mesh.triangles.size(), before);
        before = light.mesh.triangles.size();
        expect_closed(light.mesh);
        EXPECT_EQ(light.mesh.colours.size(), light.mesh.positions.size());
        for (std::size_t v = 0; v < light.source_vertex.size(); ++v)
            EXPECT_EQ(light.mesh.positions[v], mesh.positions[light.source_vertex[v]]);
    }
    EXPECT_LT(before, 60U);
}

TEST(Simplify, KeepsLocksPartsAndBorders) {
    TriangleMesh mesh = shapes::cube(20, {}, 16);
    std::vector<std::uint8_t> part(mesh.triangles.size()), locked(mesh.positions.size(), 0);
    double area = 0;
    const auto area_of = [](const TriangleMesh& m, const Triangle& t) {
        return 0.5 * glm::length(glm::cross(m.positions[t[1]] - m.positions[t[0]],
                                            m.positions[t[2]] - m.positions[t[0]]));
    };
    for (std::size_t t = 0; t < part.size(); ++t) {
        const auto& c = mesh.triangles[t];
        part[t] = mesh.positions[c[0]].x + mesh.positions[c[1]].x + mesh.positions[c[2]].x < 22.5F;
        if (part[t] == 1) area += area_of(mesh, c);
    }
    for (std::size_t v = 0; v < 50; ++v) locked[v] = 1;
    const SimplifiedMesh light = simplify(mesh, {.error_mm = 0.5, .locked = locked, .part = part});
    EXPECT_LT(light.mesh.triangles.size(), 300U);
    expect_closed(light.mesh);
    double left = 0;
    ASSERT_EQ(light.part.size(), light.mesh.triangles.size());
    for (std::size_t t = 0; t < light.part.size(); ++t) {
        if (light.part[t] == 1) left += area_of(light.mesh, light.mesh.triangles[t]);
    }
    EXPECT_NEAR(left, area, 0.01 * area);  // the border stayed where it was
    std::size_t kept = 0;
    for (const std::uint32_t v : light.source_vertex) kept += v < 50 ? 1 : 0;
    EXPECT_EQ(kept, 50U);
}

TEST(Simplify, StretchesFitTogether) {
    // A bar with a sharp edge, long enough to be cut ten times over.
    TriangleMesh mesh = shapes::cube(10, {}, 40);
    for (glm::vec3& p : mesh.positions) {
        p.x *= 10;
        p.y *= 0.05F + 0.03F * p.z;
    }
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0, 0.005F);
    for (glm::vec3& p : mesh.positions) p += glm::vec3(noise(random), noise(random), noise(random));
    std::vector<std::uint8_t> part(mesh.triangles.size(), 0);
    for (std::size_t t = 0; t < part.size(); ++t)
        part[t] = mesh.positions[mesh.triangles[t][0]].x > 33 ? 1 : 0;
    const SimplifyOptions options{
        .error_mm = 0.1, .part = part, .stretch_triangles = 2000, .samples = 50'000};
    const SimplifiedMesh light = simplify(mesh, options);
    EXPECT_LE(light.distance.largest, 0.1);
    EXPECT_LT(light.mesh.triangles.size(), mesh.triangles.size() / 3);
    // An edge may be in both of two stretches, but nothing gapes.
    TriangleMesh parted = light.mesh;
    (void)clean(parted);
    EXPECT_TRUE(find_holes(parted).empty());
    ASSERT_EQ(light.part.size(), light.mesh.triangles.size());
    for (std::size_t v = 0; v < light.source_vertex.size(); ++v)
        EXPECT_EQ(light.mesh.positions[v], mesh.positions[light.source_vertex[v]]);
    EXPECT_EQ(simplify(mesh, options).mesh.triangles, light.mesh.triangles);
}

TEST(Simplify, LevelsOfDetail) {
    const TriangleMesh mesh = shapes::ball(10, 16);
    const std::vector<double> errors{0.05, 0.2, 0.8};
    const auto levels = levels_of_detail(mesh, errors, {.samples = 10'000});
    ASSERT_EQ(levels.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LE(levels[i].distance.largest, errors[i] + 1e-6);
        if (i > 0) {
            EXPECT_LT(levels[i].mesh.triangles.size(), levels[i - 1].mesh.triangles.size());
        }
        for (std::size_t v = 0; v < levels[i].source_vertex.size(); ++v)
            EXPECT_EQ(levels[i].mesh.positions[v], mesh.positions[levels[i].source_vertex[v]]);
    }
    const std::vector<double> falling{0.2, 0.1};
    EXPECT_THROW((void)levels_of_detail(mesh, falling, {}), InputError);
}

TEST(Simplify, RefusesWhatDoesNotFit) {
    const TriangleMesh mesh = shapes::cube(1);
    const std::vector<std::uint8_t> few(3, 0);
    EXPECT_THROW((void)simplify(mesh, {.error_mm = 0}), InputError);
    EXPECT_THROW((void)simplify(mesh, {.locked = few}), InputError);
    EXPECT_THROW((void)simplify(mesh, {.part = few}), InputError);
    EXPECT_THROW((void)simplify(mesh, {.attribute_count = 2}), InputError);
    EXPECT_THROW((void)simplify(TriangleMesh{}, {}), InputError);
}

}  // namespace
}  // namespace togishi
