// A scan on its chart: cuts, corners, levels of detail, and the maps of its detail.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "base/error.hpp"
#include "katana_stations.hpp"
#include "scanned/prepare.hpp"
#include "section_scan.hpp"

namespace togishi {
namespace {

double area(const TriangleMesh& m) {
    double sum = 0;
    for (const Triangle& t : m.triangles) {
        const glm::dvec3 a(m.positions[t[0]]);
        sum += 0.5 * glm::length(glm::cross(glm::dvec3(m.positions[t[1]]) - a,
                                            glm::dvec3(m.positions[t[2]]) - a));
    }
    return sum;
}

// Each edge has a triangle on either side, which turn the same way.
bool closed(const TriangleMesh& m) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle& t : m.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
        const auto twin = edges.find({edge.first.second, edge.first.first});
        return edge.second == 1 && twin != edges.end() && twin->second == 1;
    });
}

TriangleMesh triangles_of(const BladeMesh& blade) {
    TriangleMesh m;
    m.positions.assign(blade.positions_mm.begin(), blade.positions_mm.end());
    for (std::size_t c = 0; c + 2 < blade.corner_vertex.size(); c += 3) {
        const auto at = [&](std::size_t k) {
            return static_cast<std::uint32_t>(blade.corner_vertex[c + k]);
        };
        m.triangles.push_back({at(0), at(1), at(2)});
    }
    return m;
}

struct Blade {
    ScannedStations stations;
    ScannedChart chart;
    explicit Blade(std::string_view zukuri, bool tang = true)
        : stations(katana_stations(KatanaShape(katana_defaults(zukuri)), 1.0, tang)),
          chart(stations) {}
};

const Blade& katana() {
    static const Blade blade("shinogi");
    return blade;
}
const Blade& tanto() {
    static const Blade blade("hira");
    return blade;
}

TEST(ScannedMesh, IsCutAlongSeamsAndBordersOnly) {
    const Blade& blade = katana();
    const BladePose pose = tilted_pose({1e5, -3e4, 2e3});
    const TriangleMesh scan = section_scan(blade.stations, {500, 60, {}, pose});
    ASSERT_TRUE(closed(scan));
    const double scan_area = area(scan);
    const std::size_t triangles = scan.triangles.size();
    const ChartedMesh charted = chart_mesh(scan, pose, blade.chart);
    EXPECT_TRUE(closed(charted.mesh));
    EXPECT_NEAR(area(charted.mesh) / scan_area, 1, 1e-5);
    EXPECT_GT(charted.cut, 4000U);
    EXPECT_LT(charted.mesh.triangles.size(), triangles + 3 * charted.cut);

    // No piece lies on two sides of a border by more than a vertex may be off it.
    const BladeFrame& frame = blade.chart.frame();
    double across = 0;
    double of_part = 0;
    double total = 0;
    for (std::size_t f = 0; f < charted.mesh.triangles.size(); ++f) {
        const Triangle& t = charted.mesh.triangles[f];
        double low = 1e9;
        double high = -1e9;
        glm::dvec2 middle(0);
        for (const std::uint32_t v : t) {
            const double s = charted.s_mm[v];
            const double beyond = charted.t_mm[v] - frame.at(frame.shinogi_mm, s);
            low = std::min(low, beyond);
            high = std::max(high, beyond);
            middle += glm::dvec2(s, charted.t_mm[v]) / 3.0;
        }
        if (middle.x > 3) across = std::max(across, std::min(-low, high));
        const glm::dvec3 a(charted.mesh.positions[t[0]]);
        const double piece =
            0.5 * glm::length(glm::cross(glm::dvec3(charted.mesh.positions[t[1]]) - a,
                                         glm::dvec3(charted.mesh.positions[t[2]]) - a));
        total += piece;
        const Part part =
            frame.part_at(middle.x, std::min(middle.y, frame.at(frame.edge_mm, middle.x)));
        if (charted.region[f].part() == part) of_part += piece;
    }
    EXPECT_LT(across, 0.1);
    EXPECT_GT(of_part / total, 0.9999);
}

void check_corners(const BladeMesh& mesh) {
    ASSERT_EQ(mesh.corner_normal.size(), mesh.corner_vertex.size());
    double worst = 0;
    for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
        const glm::vec3& n = mesh.corner_normal[c];
        const glm::vec3& t = mesh.corner_tangent[c];
        worst = std::max({worst, std::abs(double(glm::length(n)) - 1),
                          std::abs(double(glm::length(t)) - 1), std::abs(double(glm::dot(n, t)))});
    }
    EXPECT_LT(worst, 1e-5);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        if (mesh.face_part[f] == Part::nakago || mesh.face_part[f] == Part::other) continue;
        const auto c = static_cast<std::size_t>(mesh.face_start[f]);
        const auto v = static_cast<std::size_t>(mesh.corner_vertex[c]);
        // The walls of the machi; the tip, which a scan rounds off.
        if (mesh.s_mm[v] < 4 || double(mesh.s_mm[v]) > mesh.frame.nagasa_mm - 3) continue;
        float low = 1;
        float high = 0;
        glm::vec3 normal(0);
        for (std::size_t k = c; k < c + 3; ++k) {
            low = std::min(low, mesh.corner_uv[k].y);
            high = std::max(high, mesh.corner_uv[k].y);
            normal += mesh.corner_normal[k];
            EXPECT_GT(mesh.corner_tangent[k].x, 0.5F);
        }
        EXPECT_TRUE(high <= 0.5F + 1e-6F || low >= 0.5F - 1e-6F) << low << " " << high;
        if (mesh.face_part[f] == Part::ji) {
            EXPECT_EQ(normal.y > 0, high <= 0.5F);
        }
    }
}

TEST(ScannedMesh, CornersAreThoseOfAGeneratedBlade) {
    const Blade& blade = katana();
    const TriangleMesh scan = section_scan(blade.stations, {600, 80, {}, {}});
    const ChartedMesh charted = chart_mesh(scan, {}, blade.chart);
    const BladeMesh mesh = blade_mesh(charted, blade.chart);
    check_corners(mesh);
    // Normals break at the shinogi and nowhere inside the ji.
    std::map<std::int32_t, std::vector<glm::vec3>> at_vertex;
    for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c)
        at_vertex[mesh.corner_vertex[c]].push_back(mesh.corner_normal[c]);
    std::size_t broken = 0;
    for (const auto& [v, normals] : at_vertex) {
        const auto i = static_cast<std::size_t>(v);
        const double s = mesh.s_mm[i];
        if (s < 20 || s > 650) continue;
        float least = 1;
        for (const glm::vec3& n : normals) least = std::min(least, glm::dot(n, normals[0]));
        const double from_shinogi = mesh.t_mm[i] - mesh.frame.at(mesh.frame.shinogi_mm, s);
        const double to_edge = mesh.frame.at(mesh.frame.edge_mm, s) - mesh.t_mm[i];
        if (std::abs(from_shinogi) < 1e-3 && least < std::cos(0.02F)) ++broken;
        if (from_shinogi > 1 && to_edge > 1) {
            EXPECT_GT(least, 1 - 1e-6F);
        }
    }
    EXPECT_GT(broken, 500U);
}

TEST(ScannedMesh, LabelsCountAwayFromTheChartsBorders) {
    const Blade& blade = tanto();
    TriangleMesh scan = section_scan(blade.stations, {260, 40, {}, {}});
    std::vector<Part> labels;
    for (const Triangle& t : scan.triangles) {
        const glm::dvec3 p = scan.origin + glm::dvec3(scan.positions[t[0]]) / 1.0;
        const ChartPlace place = blade.chart.place(p);
        const BladeFrame& frame = blade.chart.frame();
        Part part =
            frame.part_at(place.s_mm, std::min(place.t_mm, frame.at(frame.edge_mm, place.s_mm)));
        if (place.s_mm > 100 && place.s_mm < 110 && place.t_mm > 6 && place.t_mm < 10)
            part = Part::ha;  // painted over
        if (place.s_mm > 150 && place.s_mm < 160) part = Part::other;
        labels.push_back(part);
    }
    const ChartedMesh charted = chart_mesh(scan, {}, blade.chart, labels);
    EXPECT_TRUE(closed(charted.mesh));
    std::size_t painted = 0;
    std::size_t other = 0;
    for (std::size_t f = 0; f < charted.region.size(); ++f) {
        const Triangle& t = charted.mesh.triangles[f];
        const double s = (charted.s_mm[t[0]] + charted.s_mm[t[1]] + charted.s_mm[t[2]]) / 3.0;
        const double v = (charted.t_mm[t[0]] + charted.t_mm[t[1]] + charted.t_mm[t[2]]) / 3.0;
        if (s > 101 && s < 109 && v > 7 && v < 9) {
            EXPECT_EQ(charted.region[f].part(), Part::ha);
            ++painted;
        }
        if (s > 151 && s < 159) {
            EXPECT_EQ(charted.region[f].part(), Part::other);
            ++other;
        }
    }
    EXPECT_GT(painted, 20U);
    EXPECT_GT(other, 200U);
    EXPECT_THROW((void)chart_mesh(scan, {}, blade.chart, std::vector<Part>(3)), InputError);
}

PrepareOptions small_options() {
    PrepareOptions o;
    o.detail.width = 1024;
    o.samples = 5000;
    return o;
}

TEST(PreparedBlade, KeepsTheStatedDistanceInEveryLevel) {
    const Blade& blade = tanto();
    const BladePose pose = tilted_pose({-400, 250, 90});
    TriangleMesh scan = section_scan(blade.stations, {300, 60, {}, pose});
    const std::size_t triangles = scan.triangles.size();
    const double scan_area = area(scan);
    double share = 0;
    const PreparedBlade prepared =
        prepare_blade(std::move(scan), pose, blade.stations, {}, small_options(), [&](double done) {
            EXPECT_GT(done, share);
            share = done;
            return true;
        });
    EXPECT_EQ(share, 1);
    ASSERT_EQ(prepared.levels.size(), 3U);
    EXPECT_EQ(prepared.scan_triangles, triangles);
    std::size_t before = triangles;
    for (const PreparedLevel& level : prepared.levels) {
        EXPECT_LE(level.distance.largest, level.error_mm);
        EXPECT_LT(level.mesh.face_count(), before);
        before = level.mesh.face_count();
        double sum = 0;
        for (std::size_t f = 0; f < level.mesh.face_count(); ++f) {
            auto at = [&](std::size_t k) {
                return level.mesh
                    .positions_mm[static_cast<std::size_t>(level.mesh.corner_vertex[3 * f + k])];
            };
            sum += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
        }
        EXPECT_NEAR(sum / scan_area, 1, level.error_mm < 0.5 ? 0.01 : 0.05);
    }
    EXPECT_LT(prepared.levels[0].mesh.face_count(), triangles / 3);
    check_corners(prepared.levels[0].mesh);
    EXPECT_LE(prepared.stretch_99_percent, 3);
    EXPECT_GT(prepared.stretch_99_percent, 0);
    EXPECT_EQ(prepared.stretch_most_percent, uv_stretch_percent(prepared.levels[0].mesh));
    EXPECT_GT(prepared.stretch_most_percent, prepared.stretch_99_percent);
}

// Noise turns narrow triangles out of the surface and across ridges, where the chart would stretch
// some of them several times: by 690 % here, were they left so.
TEST(PreparedBlade, SettlingTakesTheStretchOutOfANoisyScan) {
    const Blade& blade = tanto();
    TriangleMesh scan = section_scan(blade.stations, {1000, 180, {}, {}});
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, 0.02F);
    for (glm::vec3& p : scan.positions) p += glm::vec3(noise(random), noise(random), noise(random));
    PrepareOptions options = small_options();
    options.error_mm = 0.16;
    options.levels = 1;
    options.maps = false;
    const PreparedBlade prepared = prepare_blade(scan, {}, blade.stations, {}, options);
    const PreparedLevel& level = prepared.levels[0];
    EXPECT_LE(prepared.stretch_most_percent, 3);
    EXPECT_LE(prepared.stretch_99_percent, 2);
    EXPECT_GT(prepared.settled.moved, 100U);
    EXPECT_GT(prepared.settled.slid, 10U);
    EXPECT_LT(prepared.settled.left_mm2, 0.01 * prepared.settled.stretched_mm2);
    EXPECT_LE(level.distance.largest, options.error_mm);
    // Collapses pinch such a surface together along an edge here and there.
    EXPECT_TRUE(closed(triangles_of(level.mesh)));
}

// Grains that stand out by more than the bound from the surface that all the rest is settled on.
TEST(PreparedBlade, SettlingGivesWayTowardsGrains) {
    const Blade& blade = tanto();
    TriangleMesh scan = section_scan(blade.stations, {1000, 180, {}, {}});
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, 0.02F);
    std::vector<glm::vec3> grains;
    for (std::size_t v = 0; v < scan.positions.size(); ++v) {
        glm::vec3& p = scan.positions[v];
        const ChartPlace place = blade.chart.place(scan.origin + glm::dvec3(p));
        const bool grain = v % 9973 == 0 && place.s_mm > 20 && place.s_mm < 200 && place.t_mm > 6 &&
                           place.t_mm < 18;
        if (grain) {
            p.y += place.omote() ? 0.175F : -0.175F;
            grains.emplace_back(scan.origin + glm::dvec3(p));
            continue;
        }
        p += glm::vec3(noise(random), noise(random), noise(random));
    }
    ASSERT_GT(grains.size(), 1U);
    PrepareOptions options = small_options();
    options.error_mm = 0.16;
    options.levels = 1;
    options.samples = 100'000;  // every vertex is looked at
    options.maps = false;
    const PreparedBlade prepared = prepare_blade(scan, {}, blade.stations, {}, options);
    EXPECT_LE(prepared.stretch_most_percent, 15);
    EXPECT_LE(prepared.stretch_99_percent, 2);
    EXPECT_LE(prepared.levels[0].distance.largest, options.error_mm);
    const TriangleMesh light = triangles_of(prepared.levels[0].mesh);
    const SurfaceTree tree(light);
    for (const glm::vec3& p : grains)
        EXPECT_LE(tree.nearest(p, SurfaceTree::Search{}).distance, 0.1601F) << p.x;
}

// One place that may not be touched does not keep the rest from being settled.
TEST(PreparedBlade, SettlingIsHeldBackWhereItIsToldTo) {
    const Blade& blade = tanto();
    TriangleMesh scan = section_scan(blade.stations, {500, 90, {}, {}});
    std::mt19937 random(3);
    std::normal_distribution<float> noise(0, 0.02F);
    for (glm::vec3& p : scan.positions) p += glm::vec3(noise(random), noise(random), noise(random));
    ChartedMesh mesh = chart_mesh(std::move(scan), {}, blade.chart);
    const TriangleMesh before = mesh.mesh;
    const SurfaceTree tree(before);
    std::vector<float> bound(before.positions.size());
    std::set<std::array<float, 3>> kept;
    for (std::size_t v = 0; v < bound.size(); ++v) {
        const glm::vec3& p = before.positions[v];
        bound[v] = p.x > 120 ? 0 : 0.15F;
        if (p.x > 120) kept.insert({p.x, p.y, p.z});
    }
    SettleOptions options;
    options.error_mm = 0.15;
    options.vertex_error_mm = bound;
    const SettledCount count = settle(mesh, blade.chart, tree, options);
    EXPECT_GT(count.moved, 100U);
    std::size_t there = 0;
    for (const glm::vec3& p : mesh.mesh.positions) {
        if (p.x < 121) continue;
        EXPECT_TRUE(kept.contains({p.x, p.y, p.z})) << p.x;
        ++there;
    }
    EXPECT_GT(there, 1000U);
    EXPECT_TRUE(closed(mesh.mesh));
}

TEST(PreparedBlade, SettlingKeepsAMeshClosed) {
    const Blade& blade = tanto();
    TriangleMesh scan = section_scan(blade.stations, {500, 90, {}, {}});
    std::mt19937 random(2);
    std::normal_distribution<float> noise(0, 0.02F);
    for (glm::vec3& p : scan.positions) p += glm::vec3(noise(random), noise(random), noise(random));
    ChartedMesh mesh = chart_mesh(std::move(scan), {}, blade.chart);
    ASSERT_TRUE(closed(mesh.mesh));
    const TriangleMesh before = mesh.mesh;
    const SurfaceTree tree(before);
    SettleOptions options;
    options.error_mm = 0.15;
    const SettledCount count = settle(mesh, blade.chart, tree, options);
    EXPECT_GT(count.moved, 100U);
    EXPECT_GT(count.flipped + count.collapsed, 100U);
    EXPECT_TRUE(closed(mesh.mesh));
    EXPECT_EQ(mesh.region.size(), mesh.mesh.triangles.size());
    EXPECT_EQ(mesh.s_mm.size(), mesh.mesh.positions.size());
}

TEST(PreparedBlade, WhatIsDeeperThanTheBoundIsNotLaidOntoTheSurface) {
    const Blade& blade = tanto();
    constexpr double depth = 0.6;
    auto dent = [&](double s, double t, bool omote) {
        const double r = std::hypot(s - 120, t - 10) / 4;
        return omote && r < 1 ? -depth * (1 - r * r) : 0.0;
    };
    PrepareOptions options = small_options();
    options.levels = 1;
    options.maps = false;
    const PreparedBlade prepared = prepare_blade(section_scan(blade.stations, {800, 160, dent, {}}),
                                                 {}, blade.stations, {}, options);
    double deepest = 0;
    for (const glm::dvec3& p : prepared.levels[0].mesh.positions_mm) {
        const ChartPlace place = blade.chart.place(p);
        if (std::abs(place.s_mm - 120) < 3) deepest = std::min(deepest, place.off_mm);
    }
    EXPECT_NEAR(deepest, -depth, 0.1);
    EXPECT_LE(prepared.levels[0].distance.largest, options.error_mm);
}

// A groove and a bump along omote's and ura's ji, 0.03 mm deep, that the lighter mesh does not
// have.
TEST(PreparedBlade, MapsHoldWhatTheLighterMeshLost) {
    const Blade& blade = katana();
    constexpr double depth = 0.03;
    constexpr double from = 14;
    constexpr double width = 4;
    auto groove = [&](double s, double t, bool omote) {
        if (s < 200 || s > 300 || t < from || t > from + width) return 0.0;
        const double shape = 0.5 * (1 - std::cos(2 * std::numbers::pi * (t - from) / width));
        return (omote ? -depth : depth) * shape;
    };
    const ChartedMesh fine =
        chart_mesh(section_scan(blade.stations, {950, 260, groove, {}}), {}, blade.chart);
    const ChartedMesh plain =
        chart_mesh(section_scan(blade.stations, {500, 200, {}, {}}), {}, blade.chart);
    DetailOptions options;
    options.width = 2048;
    const DetailMaps maps = bake_detail(fine, plain, blade.chart.frame(), options);
    const BladeFrame& frame = blade.chart.frame();
    std::size_t compared = 0;
    double worst_mm = 0;
    double worst_slope = 0;
    double plain_mm = 0;
    for (std::size_t y = 0; y < maps.height; ++y) {
        for (std::size_t x = 0; x < maps.width; ++x) {
            const std::size_t i = y * maps.width + x;
            const double v = (static_cast<double>(y) + 0.5) / static_cast<double>(maps.height);
            const ChartPoint at =
                frame.locate((static_cast<double>(x) + 0.5) / static_cast<double>(maps.width), v);
            const bool omote = v < 0.5;
            if (at.s_mm < 205 || at.s_mm > 295 || at.from_ridge_mm < 13 || at.from_ridge_mm > 24)
                continue;
            ASSERT_EQ(maps.state[i], TexelState::measured);
            const double g = groove(250, at.from_ridge_mm, omote);
            worst_mm = std::max(worst_mm, std::abs(double(maps.displacement_mm[i]) - g));
            if (at.from_ridge_mm > 19)
                plain_mm = std::max(plain_mm, std::abs(double(maps.displacement_mm[i])));
            const double h = 0.01;
            const double slope = (groove(250, at.from_ridge_mm + h, omote) -
                                  groove(250, at.from_ridge_mm - h, omote)) /
                                 (2 * h);
            // Up in the picture is towards the ridge on omote, away from it on ura.
            worst_slope = std::max(worst_slope,
                                   std::abs(double(maps.normal[i].y) - (omote ? slope : -slope)));
            worst_slope = std::max(worst_slope, std::abs(double(maps.normal[i].x)));
            ++compared;
        }
    }
    EXPECT_GT(compared, 5000U);
    EXPECT_LT(worst_mm, 0.003);
    EXPECT_LT(plain_mm, 0.002);
    EXPECT_LT(worst_slope, 0.008) << "of 0.024 at the steepest";
}

TEST(PreparedBlade, HolesAreMarkedAndNothingTurnsDark) {
    const Blade& blade = tanto();
    TriangleMesh scan = section_scan(blade.stations, {400, 80, {}, {}});
    const Colour8 steel{180, 90, 30, 255};
    scan.colours.assign(scan.positions.size(), steel);
    std::erase_if(scan.triangles, [&](const Triangle& t) {
        const ChartPlace p = blade.chart.place(scan.origin + glm::dvec3(scan.positions[t[0]]));
        return p.s_mm > 100 && p.s_mm < 120 && p.t_mm > 8 && p.t_mm < 14 && p.omote();
    });
    const ChartedMesh charted = chart_mesh(scan, {}, blade.chart);
    DetailOptions options;
    options.width = 1024;
    const DetailMaps maps = bake_detail(charted, charted, blade.chart.frame(), options);
    const double texel_mm2 = blade.chart.frame().length_mm() / 1024.0 *
                             blade.chart.frame().chart_height_mm / static_cast<double>(maps.height);
    std::size_t holes = 0;
    std::size_t measured = 0;
    for (std::size_t i = 0; i < maps.state.size(); ++i) {
        if (maps.state[i] == TexelState::hole) {
            ++holes;
            EXPECT_EQ(maps.normal[i], glm::vec3(0, 0, 1));
            EXPECT_EQ(maps.displacement_mm[i], 0);
        }
        if (maps.state[i] != TexelState::outside) {
            EXPECT_EQ(maps.colour[i], steel);
        }
        if (maps.state[i] == TexelState::measured) {
            ++measured;
            const std::size_t row = i / maps.width;
            const double u = (static_cast<double>(i - row * maps.width) + 0.5) / 1024.0;
            const double v = (static_cast<double>(row) + 0.5) / static_cast<double>(maps.height);
            const ChartPoint at = blade.chart.frame().locate(u, v);
            if (at.part != Part::ji && at.part != Part::ha) continue;
            if (at.s_mm < 5 || at.s_mm > 220 || at.from_edge_mm < 2 || at.from_ridge_mm < 5)
                continue;
            EXPECT_GT(maps.normal[i].z, 0.999F);
            EXPECT_LT(std::abs(maps.displacement_mm[i]), 0.01F);
        }
    }
    EXPECT_NEAR(static_cast<double>(holes) * texel_mm2, 20 * 6, 25);
    EXPECT_NEAR(static_cast<double>(measured) * texel_mm2 / (area(scan)), 1, 0.03);
    // Beyond the edge the colour goes on by the margin.
    const std::size_t column = 700;
    std::size_t first = 0;
    while (maps.state[first * maps.width + column] == TexelState::outside) ++first;
    ASSERT_GT(first, 0U);
    EXPECT_EQ(maps.colour[(first - 1) * maps.width + column], steel);
}

TEST(PreparedBlade, ResultsDoNotDependOnThreads) {
    const Blade& blade = tanto();
    const TriangleMesh scan = section_scan(blade.stations, {300, 60, {}, {}});
    auto bake = [&](unsigned threads) {
        const ChartedMesh charted = chart_mesh(scan, {}, blade.chart, {}, threads);
        DetailOptions options;
        options.width = 512;
        options.threads = threads;
        return bake_detail(charted, charted, blade.chart.frame(), options);
    };
    const DetailMaps one = bake(1);
    const DetailMaps three = bake(3);
    EXPECT_EQ(one.displacement_mm, three.displacement_mm);
    EXPECT_EQ(one.normal, three.normal);
}

TEST(PreparedBlade, TakesExtremes) {
    // Without a tang, hira-zukuri, a hole, triangles of no area, a piece far off.
    const Blade blade("hira", false);
    TriangleMesh scan = section_scan(blade.stations, {120, 24, {}, {}});
    scan.triangles.resize(scan.triangles.size() - 200);
    scan.triangles.push_back({5, 6, 6});
    scan.triangles.push_back({7, 7, 7});
    const auto n = static_cast<std::uint32_t>(scan.positions.size());
    for (const float x : {0.0F, 1.0F, 0.5F}) scan.positions.emplace_back(x, 300.0F, 40.0F * x);
    scan.triangles.push_back({n, n + 1, n + 2});
    PrepareOptions options = small_options();
    options.detail.width = 256;
    options.levels = 1;
    const PreparedBlade prepared = prepare_blade(scan, {}, blade.stations, {}, options);
    for (const glm::vec2& uv : prepared.levels[0].mesh.corner_uv)
        EXPECT_TRUE(std::isfinite(uv.x + uv.y));
    for (const glm::vec3& normal : prepared.detail.normal)
        EXPECT_NEAR(glm::length(normal), 1, 1e-4);

    // Four triangles.
    TriangleMesh tiny;
    tiny.positions = {{100, 2, -5}, {102, 2, -5}, {101, 2, -7}, {101, -2, -6}};
    tiny.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    EXPECT_NO_THROW((void)prepare_blade(tiny, {}, blade.stations, {}, options));

    auto refuses = [&](auto&& spoil) {
        PrepareOptions bad = options;
        spoil(bad);
        EXPECT_THROW((void)prepare_blade(tiny, {}, blade.stations, {}, bad), InputError);
    };
    refuses([](PrepareOptions& o) { o.levels = 0; });
    refuses([](PrepareOptions& o) { o.level_factor = 1; });
    refuses([](PrepareOptions& o) { o.detail.width = 3; });
    refuses([](PrepareOptions& o) { o.detail.height = 101; });
    refuses([](PrepareOptions& o) { o.error_mm = 0; });
    EXPECT_THROW(
        (void)prepare_blade(tiny, {}, blade.stations, {}, options, [](double) { return false; }),
        PrepareCancelled);
}

}  // namespace
}  // namespace togishi
