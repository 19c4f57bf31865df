// Rays through the tree that the GPU searches: the shared search against every triangle in turn.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "base/error.hpp"
#include "brdf/tracing.hpp"
#include "mesh/ray_tree.hpp"
#include "mesh_shapes.hpp"

namespace {

using namespace togishi;

// A mesh with its tree in one row of texels, as the add-on lays it out.
struct Traced {
    TriangleMesh mesh;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec4> texels;
    int nodes = 0;

    explicit Traced(TriangleMesh m) : mesh(std::move(m)), normals(mesh.positions) {
        for (glm::vec3& n : normals) n = glm::length(n) > 0 ? n : glm::vec3(0, 0, 1);
        std::vector<std::uint16_t> groups(mesh.triangles.size());
        for (std::size_t t = 0; t < groups.size(); ++t)
            groups[t] = static_cast<std::uint16_t>(t % 7);
        const RayTree tree = ray_tree(mesh, normals, groups);
        texels = tree.nodes;
        nodes = static_cast<int>(tree.nodes.size());
        texels.insert(texels.end(), tree.triangles.begin(), tree.triangles.end());
    }
};

#define TG_TEST_TRACE(name, ns, real, vec)                                                   \
    ns::TreeHit name(const Traced& t, const glm::dvec3& origin, const glm::dvec3& direction, \
                     double reach, bool any) {                                               \
        tree_texels = t.texels.data();                                                       \
        return ns::ray_meets_tree({0, t.nodes / 2, t.nodes}, vec(origin), vec(direction),    \
                                  static_cast<real>(reach), any);                            \
    }
TG_TEST_TRACE(trace32, f32, float, glm::vec3)
TG_TEST_TRACE(trace64, f64, double, glm::dvec3)

// The nearest triangle, each solved for by itself; nothing where the ray passes an edge so near
// that rounding decides.
struct Plain {
    double distance = std::numeric_limits<double>::infinity();
    bool doubtful = false;
};

Plain by_every_triangle(const TriangleMesh& mesh, const glm::dvec3& origin,
                        const glm::dvec3& direction) {
    Plain best;
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
        const glm::dmat3 m(b - a, c - a, -direction);
        if (std::abs(glm::determinant(m)) < 1e-12) continue;
        const glm::dvec3 s = glm::inverse(m) * (origin - a);
        const double inside = std::min({s.x, s.y, 1 - s.x - s.y});
        if (std::abs(inside) < 1e-4 && s.z > 0) best.doubtful = true;
        if (inside >= 0 && s.z > 0) best.distance = std::min(best.distance, s.z);
    }
    return best;
}

TriangleMesh cloud(int count, unsigned seed) {
    std::mt19937 draw(seed);
    std::uniform_real_distribution<float> place(-1, 1), size(-0.2F, 0.2F);
    TriangleMesh mesh;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 a(place(draw), place(draw), place(draw));
        const auto n = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(a);
        for (int k = 0; k < 2; ++k)
            mesh.positions.push_back(a + glm::vec3(size(draw), size(draw), size(draw)));
        mesh.triangles.push_back({n, n + 1, n + 2});
    }
    return mesh;
}

TEST(RayTree, FindsWhatASearchOfEveryTriangleFinds) {
    std::mt19937 draw(5);
    std::uniform_real_distribution<double> place(-2, 2);
    for (const int count : {1, 4, 5, 33, 400}) {
        const Traced t(cloud(count, 10U + static_cast<unsigned>(count)));
        int hits = 0;
        for (int i = 0; i < 3000; ++i) {
            const glm::dvec3 origin(place(draw), place(draw), place(draw));
            const glm::dvec3 direction =
                glm::dvec3(place(draw), place(draw), place(draw)) * 0.3 - origin;
            const Plain plain = by_every_triangle(t.mesh, origin, direction);
            if (plain.doubtful) continue;
            const auto in_double = trace64(t, origin, direction, 100, false);
            const auto in_float = trace32(t, origin, direction, 100, false);
            if (std::isinf(plain.distance)) {
                EXPECT_EQ(in_double.triangle, -1);
                EXPECT_EQ(in_float.triangle, -1);
                continue;
            }
            ++hits;
            EXPECT_NEAR(in_double.distance, plain.distance, 1e-6);
            EXPECT_NEAR(in_float.distance, plain.distance, 2e-3 * (1 + plain.distance));
            // Something lies before a reach beyond the hit, nothing before a nearer one.
            EXPECT_GE(trace32(t, origin, direction, plain.distance * 1.01, true).triangle, 0);
            EXPECT_EQ(trace64(t, origin, direction, plain.distance * 0.999, true).triangle, -1);
        }
        EXPECT_GT(hits, count / 4);
    }
}

TEST(RayTree, TellsGroupAndSmoothNormal) {
    const Traced t(shapes::ball(2, 20));
    std::mt19937 draw(3);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 out = glm::normalize(glm::dvec3(normal(draw), normal(draw), normal(draw)));
        const auto hit = trace64(t, out * 5.0, -out, 100, false);
        ASSERT_GE(hit.triangle, 0);
        EXPECT_NEAR(hit.distance, 3, 0.01);
        EXPECT_GT(glm::dot(glm::normalize(f64::tree_normal(hit)), out), 0.9999);
        EXPECT_GE(f64::tree_group(hit), 0);
        EXPECT_LT(f64::tree_group(hit), 7);
    }
}

// A cloth is flat, lies along the axes, and rays run within planes of its box.
TEST(RayTree, FlatSurfacesAndRaysAlongAxesAreFound) {
    TriangleMesh cloth;
    for (const float z : {0.0F, 1.0e5F}) {
        cloth.positions = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
        cloth.triangles = {{0, 1, 2}, {0, 2, 3}};
        const Traced t(cloth);
        for (const double x : {-0.75, 0.25, 0.5}) {
            EXPECT_GE(trace32(t, {x, 0.1, z + 5.0}, {0, 0, -1}, 100, true).triangle, 0);
            EXPECT_GE(trace32(t, {x, 0.1, z - 5.0}, {0, 0, 1}, 100, true).triangle, 0);
            EXPECT_EQ(trace32(t, {x, 0.1, z + 5.0}, {0, 0, 1}, 100, true).triangle, -1);
            EXPECT_EQ(trace32(t, {x, 0.1, z + 5.0}, {1, 0, 0}, 100, true).triangle, -1);
            EXPECT_EQ(trace32(t, {x, 5, z + 5.0}, {0, 0, -1}, 100, true).triangle, -1);
        }
    }
}

TEST(RayTree, DirectionsSurviveTheirPacking) {
    std::mt19937 draw(8);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec3 n = glm::normalize(glm::vec3(normal(draw), normal(draw), normal(draw)));
        EXPECT_GT(glm::dot(f64::unpack_unit(pack_unit(n)), glm::dvec3(n)), std::cos(1.2e-3));
    }
    for (const glm::vec3 bad : {glm::vec3(0), glm::vec3(std::numeric_limits<float>::quiet_NaN())}) {
        EXPECT_NEAR(glm::length(f64::unpack_unit(pack_unit(bad))), 1, 1e-12);
    }
}

TEST(RayTree, DegenerateMeshesAreSearched) {
    EXPECT_TRUE(ray_tree({}, {}, {}).nodes.empty());
    TriangleMesh point;
    point.positions = {{1, 1, 1}};
    point.triangles.assign(100, {0, 0, 0});
    const Traced t(point);
    EXPECT_EQ(trace32(t, {1, 1, 5}, {0, 0, -1}, 100, false).triangle, -1);
}

TEST(RayTree, RefusesWhatDoesNotBelongTogether) {
    const TriangleMesh mesh = shapes::cube(1);
    const std::vector<glm::vec3> normals(mesh.positions.size(), {0, 0, 1});
    const std::vector<std::uint16_t> groups(mesh.triangles.size());
    EXPECT_THROW((void)ray_tree(mesh, std::span(normals).first(3), groups), InputError);
    EXPECT_THROW((void)ray_tree(mesh, normals, std::span(groups).first(3)), InputError);
    TriangleMesh wrong = mesh;
    wrong.triangles[0][0] = 99;
    EXPECT_THROW((void)ray_tree(wrong, normals, groups), InputError);
}

}  // namespace
