#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "mesh/clean.hpp"
#include "mesh/half_edges.hpp"
#include "mesh/holes.hpp"
#include "mesh/pieces.hpp"
#include "mesh/unit_guess.hpp"
#include "mesh_shapes.hpp"

namespace togishi {
namespace {

/// Every edge has one or two triangles, wound alike; every vertex one fan and a triangle.
void expect_manifold(const TriangleMesh& mesh) {
    const HalfEdges edges = link_half_edges(mesh, true);
    EXPECT_TRUE(edges.crowded.empty());
    EXPECT_EQ(edges.duplicates, 0U);
    TriangleMesh again = mesh;
    const CleanReport report = clean(again);
    EXPECT_EQ(report.non_manifold_vertices + report.vertices_split_off, 0U);
    EXPECT_EQ(report.flipped_triangles + report.reversed_pieces, 0U);
    EXPECT_EQ(report.degenerate_triangles, 0U);
    EXPECT_EQ(again.triangles, mesh.triangles);
}

/// Manifold as far as welding does not join again what was parted.
void expect_parted(const TriangleMesh& mesh) {
    EXPECT_TRUE(link_half_edges(mesh, true).crowded.empty());
}

TEST(MeshClean, LeavesACleanMeshAlone) {
    TriangleMesh mesh = shapes::cube(10, {1, 2, 3}, 4);
    const TriangleMesh before = mesh;
    const CleanReport report = clean(mesh);
    EXPECT_EQ(mesh.triangles, before.triangles);
    EXPECT_EQ(mesh.positions, before.positions);
    EXPECT_EQ(report.triangles_after, report.triangles_before);
    EXPECT_TRUE(find_holes(mesh).empty());
}

TEST(MeshClean, WeldsTriangleSoup) {
    const TriangleMesh cube = shapes::cube(10, {}, 6);
    TriangleMesh soup;
    for (const Triangle& t : cube.triangles) {
        for (const std::uint32_t v : t) {
            soup.positions.push_back(cube.positions[v]);
            soup.colours.push_back({static_cast<std::uint8_t>(v), 0, 0, 255});
        }
        const auto n = static_cast<std::uint32_t>(soup.positions.size());
        soup.triangles.push_back({n - 3, n - 2, n - 1});
    }
    const CleanReport report = clean(soup);
    EXPECT_EQ(soup.positions.size(), cube.positions.size());
    EXPECT_EQ(soup.colours.size(), cube.positions.size());
    EXPECT_EQ(report.welded_vertices, 3 * cube.triangles.size() - cube.positions.size());
    EXPECT_NEAR(shapes::volume(soup), 1000, 1e-3);
    expect_manifold(soup);
}

TEST(MeshClean, WeldsWithinADistance) {
    TriangleMesh mesh = shapes::cube(10, {}, 2);
    TriangleMesh other = mesh;
    for (glm::vec3& p : other.positions) p += glm::vec3(0.005F, -0.005F, 0.005F);
    shapes::append(mesh, other);
    TriangleMesh apart = mesh;
    EXPECT_EQ(clean(apart).welded_vertices, 0U);
    const CleanReport report = clean(mesh, {.weld_distance = 0.01});
    EXPECT_EQ(report.welded_vertices, other.positions.size());
    EXPECT_EQ(report.duplicate_triangles, other.triangles.size());
    EXPECT_THROW((void)clean(mesh, {.weld_distance = -1}), InputError);
}

TEST(MeshClean, TakesDuplicatesOutInAnyWinding) {
    TriangleMesh mesh = shapes::cube(10, {}, 3);
    const std::size_t count = mesh.triangles.size();
    const Triangle t = mesh.triangles[5];
    mesh.triangles.push_back({t[1], t[2], t[0]});
    mesh.triangles.push_back({t[2], t[1], t[0]});
    mesh.triangles.push_back({t[0], t[0], t[1]});
    const CleanReport report = clean(mesh);
    EXPECT_EQ(report.duplicate_triangles, 2U);
    EXPECT_EQ(report.degenerate_triangles, 1U);
    EXPECT_EQ(mesh.triangles.size(), count);
    expect_manifold(mesh);
}

TEST(MeshClean, AFlatTriangleLeavesNoGap) {
    // A corner on its neighbour's edge, bridged by a triangle without area.
    TriangleMesh mesh = shapes::cube(10, {}, 1);
    const Triangle t = mesh.triangles[0];
    const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(0.5F * (mesh.positions[t[0]] + mesh.positions[t[1]]));
    mesh.triangles[0] = {t[0], middle, t[2]};
    mesh.triangles.push_back({middle, t[1], t[2]});
    mesh.triangles.push_back({t[0], t[1], middle});
    const CleanReport report = clean(mesh);
    EXPECT_EQ(report.degenerate_triangles, 1U);
    EXPECT_EQ(report.split_at_degenerate, 1U);
    EXPECT_TRUE(find_holes(mesh).empty());
    EXPECT_NEAR(shapes::volume(mesh), 1000, 1e-3);
    expect_manifold(mesh);
}

TEST(MeshClean, TurnsWindings) {
    std::mt19937 random(7);
    TriangleMesh mesh = shapes::ball(10, 8);
    for (Triangle& t : mesh.triangles) {
        if (random() % 3 == 0) std::swap(t[0], t[1]);
    }
    TriangleMesh inside_out = shapes::cube(5, {30, 0, 0}, 3);
    for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
    shapes::append(mesh, inside_out);
    const CleanReport report = clean(mesh);
    EXPECT_GT(report.flipped_triangles, 0U);
    EXPECT_EQ(report.reversed_pieces, 1U);
    EXPECT_NEAR(shapes::volume(mesh), 4.0 / 3 * 3.14159265 * 1000 + 125, 150);
    expect_manifold(mesh);
}

TEST(MeshClean, PartsWhatMeetsInAnEdgeOrAPoint) {
    // Two cubes that share an edge, a third that shares a corner, a fin on the first.
    TriangleMesh mesh = shapes::cube(10, {0, 0, 0}, 2);
    shapes::append(mesh, shapes::cube(10, {10, 10, 0}, 2));
    shapes::append(mesh, shapes::cube(10, {-10, -10, -10}, 2));
    TriangleMesh fin;
    fin.positions = {{0, 5, 10}, {5, 5, 10}, {2, 5, 15}};
    fin.triangles = {{0, 1, 2}};
    shapes::append(mesh, fin);
    const CleanReport report = clean(mesh);
    EXPECT_EQ(report.non_manifold_edges, 3U);  // two halves of the shared edge, one of the fin
    EXPECT_GT(report.vertices_split_off, 0U);
    expect_parted(mesh);
    const auto pieces = sort_into_pieces(mesh);
    ASSERT_EQ(pieces.size(), 4U);
    for (std::size_t i = 0; i < 3; ++i) {
        const TriangleMesh piece = take_piece(mesh, pieces[i]);
        EXPECT_NEAR(shapes::volume(piece), 1000, 1e-2);
        expect_manifold(piece);
    }
}

TEST(MeshClean, CutsAMoebiusStrip) {
    TriangleMesh mesh;
    const int n = 24;
    for (int i = 0; i < n; ++i) {
        const double a = 2 * 3.14159265358979 * i / n;
        for (const double side : {-1.0, 1.0}) {
            const double r = 10 + side * std::cos(a / 2);
            mesh.positions.emplace_back(r * std::cos(a), r * std::sin(a), side * std::sin(a / 2));
        }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = a + 1;
        const bool last = i + 1 == n;
        const std::uint32_t c = last ? 1 : a + 2, d = last ? 0 : a + 3;
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
    }
    const CleanReport report = clean(mesh);
    EXPECT_EQ(report.one_sided_edges, 1U);
    expect_parted(mesh);
    EXPECT_EQ(find_holes(mesh).size(), 1U);
}

TEST(MeshClean, SurvivesRandomTriangles) {
    std::mt19937 random(1);
    for (int round = 0; round < 300; ++round) {
        TriangleMesh mesh;
        const auto below = [&](std::uint32_t n) {
            return static_cast<std::uint32_t>(random() % n);
        };
        const std::uint32_t points = 4 + below(12), count = 1 + below(60);
        for (std::uint32_t i = 0; i < points; ++i) {
            // On a coarse grid: coinciding points, lines, every kind of crowd.
            mesh.positions.emplace_back(below(3), below(3), below(3));
        }
        for (std::uint32_t i = 0; i < count; ++i)
            mesh.triangles.push_back({below(points), below(points), below(points)});
        const CleanReport report = clean(mesh);
        expect_parted(mesh);
        EXPECT_EQ(report.triangles_after, mesh.triangles.size());
        std::size_t border = 0, in_holes = 0;
        for (const std::uint32_t twin : link_half_edges(mesh, true).twin)
            border += twin == no_half_edge ? 1 : 0;
        for (const Hole& hole : find_holes(mesh)) in_holes += hole.vertices.size();
        EXPECT_EQ(border, in_holes);
        std::size_t in_pieces = 0;
        for (const Piece& piece : sort_into_pieces(mesh)) in_pieces += piece.triangle_count;
        EXPECT_EQ(in_pieces, mesh.triangles.size());
    }
}

TEST(MeshPieces, AreKeptAsideWithSizeAndPlace) {
    TriangleMesh mesh = shapes::cube(1, {50, 0, 0});  // a scale bar
    shapes::append(mesh, shapes::ball(10, 4));
    mesh.origin = {1e5, -1e5, 3};
    (void)clean(mesh);
    const auto pieces = sort_into_pieces(mesh);
    ASSERT_EQ(pieces.size(), 2U);
    EXPECT_NEAR(pieces[0].diagonal(), std::sqrt(3.0) * 20, 0.1);
    EXPECT_NEAR(pieces[1].area, 6, 1e-6);
    EXPECT_NEAR(pieces[1].centre().x, 1e5 + 50.5, 1e-9);
    EXPECT_EQ(take_piece(mesh, pieces[1]).triangles.size(), 12U);
    EXPECT_NEAR(shapes::volume(take_piece(mesh, pieces[1])), 1, 1e-3);
}

TEST(MeshHoles, AreListedAndClosedWhereAsked) {
    TriangleMesh mesh = shapes::cube(10, {}, 5);
    mesh.origin = {1000, 0, 0};
    // The squares about the middle of the side x = 0, and one of the side x = 10.
    std::erase_if(mesh.triangles, [&](const Triangle& t) {
        const glm::vec3 m =
            (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3.0F;
        return (m.x < 0.01F && std::abs(m.y - 5) < 3 && std::abs(m.z - 5) < 3) ||
               (m.x > 9.99F && m.y < 2 && m.z < 2);
    });
    (void)clean(mesh);
    auto holes = find_holes(mesh);
    ASSERT_EQ(holes.size(), 2U);
    EXPECT_NEAR(holes[0].length, 24, 1e-5);
    EXPECT_NEAR(holes[0].size, std::sqrt(72.0), 1e-5);
    EXPECT_NEAR(holes[0].centre.x, 1000, 1e-5);
    EXPECT_NEAR(holes[1].length, 8, 1e-5);
    const std::size_t before = mesh.triangles.size();
    const HoleClosing done = close_holes(mesh, {holes[1]});
    EXPECT_EQ(done.closed, 1U);
    EXPECT_EQ(mesh.triangles.size(), before + done.triangles_made);
    holes = find_holes(mesh);
    ASSERT_EQ(holes.size(), 1U);
    EXPECT_NEAR(holes[0].length, 24, 1e-5);
    (void)close_holes(mesh, holes);
    EXPECT_TRUE(find_holes(mesh).empty());
    EXPECT_NEAR(shapes::volume(mesh), 1000, 1e-3);
    expect_manifold(mesh);
}

TEST(UnitGuess, NamesTheLikeliestAndTheOthers) {
    EXPECT_EQ(guess_unit(720).unit, LengthUnit::mm);
    EXPECT_EQ(guess_unit(72).unit, LengthUnit::cm);
    EXPECT_EQ(guess_unit(0.72).unit, LengthUnit::m);
    EXPECT_EQ(guess_unit(13).unit, LengthUnit::inch);
    EXPECT_FALSE(guess_unit(720).ambiguous);
    const UnitGuess either = guess_unit(29.5);  // a tanto in cm, a katana in inches
    EXPECT_TRUE(either.ambiguous);
    EXPECT_TRUE(either.candidates[1].plausible);
    EXPECT_NEAR(either.candidates[0].likelihood + either.candidates[1].likelihood, 1, 1e-9);
    EXPECT_EQ(guess_unit(36, 2.2).unit, LengthUnit::cm);  // by its width
    EXPECT_EQ(guess_unit(36, 1.1).unit, LengthUnit::inch);
    const UnitGuess none = guess_unit(5e5);
    EXPECT_TRUE(none.ambiguous);
    EXPECT_EQ(none.candidates[0].likelihood, 0);
    EXPECT_THROW((void)guess_unit(0), InputError);
    EXPECT_THROW((void)guess_unit(std::nan("")), InputError);
}

}  // namespace
}  // namespace togishi
