// From a scan's mesh to a blade with its chart, record and what was kept aside.
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "scanned/import.hpp"
#include "simulate_scan_mesh.hpp"

namespace togishi {
namespace {

ImportOptions small_options() {
    ImportOptions o;
    o.analysis.replicates = 2;
    o.analysis.samples = 40000;
    o.prepare.error_mm = 0.3;
    o.prepare.levels = 1;
    o.prepare.samples = 2000;
    o.prepare.detail.width = 256;
    return o;
}

ScanMesh tanto_on_stand() {
    ScanMeshOptions o;
    o.triangles = 15000;
    o.offset_mm = 1e5;
    o.mm_per_unit = 10;
    o.stand = true;
    return simulate_scan_mesh(scan_shape("tanto"), o);
}

double measured(const ImportedScan& scan, const std::string& name) {
    for (const ScanMeasure& m : scan.analysis.measures) {
        if (m.name == name) return m.value;
    }
    ADD_FAILURE() << name << " was not measured";
    return 0;
}

TEST(ScanImport, BringsAMeasuredBladeInItsOwnCoordinates) {
    ScanMesh scan = tanto_on_stand();
    double share = 0;
    const ImportedScan found = import_scan(scan.mesh, small_options(), [&](double done) {
        EXPECT_GE(done, share);
        share = done;
        return true;
    });
    EXPECT_EQ(share, 1);
    EXPECT_EQ(found.mm_per_unit, 10);
    EXPECT_NE(found.unit_text.find("cm"), std::string::npos);
    ASSERT_TRUE(found.is_blade()) << found.analysis.text;
    EXPECT_NEAR(measured(found, "nagasa_mm"), scan.truth.at("nagasa_mm"), 0.3);
    EXPECT_NEAR(measured(found, "motohaba_mm"), scan.truth.at("motohaba_mm"), 0.15);
    // Two posts and a scale bar, whose sides hang together by no vertex: 18 pieces.
    EXPECT_EQ(found.aside.size(), 16U);
    EXPECT_NE(found.aside.back().text.find("3 small pieces"), std::string::npos);
    // Tip on the X axis, edge below.
    const BladeMesh& mesh = found.blade.levels[0].mesh;
    glm::dvec3 tip(0);
    for (const glm::dvec3& p : mesh.positions_mm) {
        if (p.x > tip.x) tip = p;
    }
    EXPECT_NEAR(tip.x, scan.truth.at("nagasa_mm"), 0.5);
    EXPECT_NEAR(tip.y, 0, 0.3);
    EXPECT_NEAR(tip.z, 0, 0.3);
    EXPECT_LE(found.blade.levels[0].distance.largest, 0.3);
    const auto drawn = drawn_measures(found.analysis.stations);
    const auto& nagasa = drawn.at("nagasa_mm");
    EXPECT_NEAR(glm::distance(nagasa[0], nagasa[1]), measured(found, "nagasa_mm"), 1);
    const auto& haba = drawn.at("motohaba_mm");
    EXPECT_NEAR(glm::distance(haba[0], haba[1]), measured(found, "motohaba_mm"), 1);

    const ScanRecord record = parse_record(record_json(record_of(found)), "record");
    EXPECT_EQ(record.dimensions.size(), found.analysis.measures.size());
    EXPECT_EQ(record.mm_per_unit, 10);
    std::vector<std::string> steps;
    for (const RecordStep& step : record.steps) steps.push_back(step.name);
    const std::vector<std::string> all{"unit",  "clean", "align",  "measure",
                                       "holes", "label", "prepare"};
    EXPECT_EQ(steps, all);
    EXPECT_FALSE(record.inferred.empty());
    // What settling did to the measured surface is told.
    const SettledCount& settled = found.blade.settled;
    EXPECT_GT(settled.moved, 0U);
    std::map<std::string, double> figures;
    for (const RecordFigure& f : record.steps.back().figures) figures[f.name] = f.value;
    EXPECT_EQ(figures.at("settled: vertices moved"), settled.moved);
    EXPECT_EQ(figures.at("settled: slid along the surface"), settled.slid);
    EXPECT_EQ(figures.at("settled: edges flipped"), settled.flipped);
    EXPECT_EQ(figures.at("settled: edges collapsed"), settled.collapsed);
    EXPECT_EQ(figures.at("settled: triangles left stretched"), settled.left);
    EXPECT_EQ(figures.at("settled: area stretched before"), settled.stretched_mm2);
    EXPECT_EQ(figures.at("settled: area left stretched"), settled.left_mm2);
}

TEST(ScanImport, PaintedPartsStayAndHolesAreClosedWhereAsked) {
    ScanMesh scan = tanto_on_stand();
    const auto in_hole = [&](const Triangle& t) {
        const glm::dvec3 p =
            glm::transpose(scan.rotation) *
            (scan.mesh.origin - scan.origin + glm::dvec3(scan.mesh.positions[t[0]]));
        return glm::distance(glm::dvec2(p.x, p.z) * 10.0, glm::dvec2(120, -12)) < 4 && p.y > 0;
    };
    std::erase_if(scan.mesh.triangles, in_hole);
    ImportOptions options = small_options();
    options.prepare.maps = false;
    options.analysis.replicates = 0;
    const ImportedScan before = import_scan(scan.mesh, options);
    ASSERT_TRUE(before.is_blade());
    EXPECT_EQ(before.holes, 1U);
    EXPECT_EQ(before.closing.closed, 0U);
    EXPECT_TRUE(before.blade.detail.normal.empty());
    options.close_holes_mm = before.longest_hole_mm + 1;
    // A patch of the back's side near the middle, in the scan's own place.
    const BladePose& pose = before.analysis.pose;
    PaintedParts& painted = options.painted;
    for (const glm::dvec3& corner :
         {glm::dvec3(60, 3, 0), glm::dvec3(70, 3, 0), glm::dvec3(60, 3, -30)}) {
        const double y = 3.0;
        painted.mesh.positions.emplace_back(glm::transpose(pose.rotation) *
                                            glm::dvec3(corner.x, y, corner.z));
    }
    painted.mesh.origin = pose.origin_mm;
    painted.mesh.triangles = {{0, 1, 2}};
    painted.part = {static_cast<std::int32_t>(Part::other)};
    const ImportedScan after = import_scan(scan.mesh, options);
    EXPECT_EQ(after.closing.closed, 1U);
    ASSERT_EQ(after.painted.size(), after.blade.levels[0].mesh.face_count());
    std::size_t faces = 0;
    for (std::size_t f = 0; f < after.painted.size(); ++f) {
        if (after.painted[f] == PaintedParts::not_painted) continue;
        EXPECT_EQ(after.blade.levels[0].mesh.face_part[f], Part::other);
        ++faces;
    }
    EXPECT_GT(faces, 0U);
}

TEST(ScanImport, SaysWhatIsNoBladeAndRefusesNonsense) {
    TriangleMesh cube;
    cube.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                      {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const ImportedScan found = import_scan(cube, {});
    EXPECT_EQ(found.analysis.verdict, ScanVerdict::no_blade);
    EXPECT_FALSE(found.is_blade());
    EXPECT_FALSE(found.analysis.text.empty());

    const auto refused = [&](auto&& spoil) {
        ImportOptions options;
        spoil(options);
        EXPECT_THROW((void)import_scan(cube, options), InputError);
    };
    refused([](ImportOptions& o) { o.mm_per_unit = -1; });
    refused([](ImportOptions& o) { o.close_holes_mm = NAN; });
    refused([](ImportOptions& o) { o.prepare.error_mm = -0.1; });
    refused([](ImportOptions& o) { o.painted.part = {1}; });
    EXPECT_THROW((void)import_scan({}, {}), InputError);
    EXPECT_THROW((void)import_scan(cube, {}, [](double) { return false; }), PrepareCancelled);
}

TEST(ScanImport, NamesOfMeasures) {
    EXPECT_EQ(measure_label("moto_shinogi_haba_mm"), "Moto shinogi haba");
    EXPECT_EQ(measure_label("nagasa_mm"), "Nagasa");
}

}  // namespace
}  // namespace togishi
