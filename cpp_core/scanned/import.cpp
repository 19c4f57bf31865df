#include "scanned/import.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace togishi {
namespace {

constexpr double after_clean = 0.15;
constexpr double after_analysis = 0.4;

void check(const ImportOptions& options) {
    const auto fail = [](const char* field, double found, const char* allowed) {
        throw InputError("scan", field, std::to_string(found), allowed);
    };
    const double unit = options.mm_per_unit;
    if (!(unit >= 0 && unit <= 1e6)) fail("mm_per_unit", unit, "0 (by the length) to 1e6");
    const double closed = options.close_holes_mm;
    if (!(closed >= 0 && closed <= 1e4)) fail("close_holes_mm", closed, "0 to 10000 mm");
    const double error = options.prepare.error_mm;
    if (!(error >= 0 && error <= 100)) fail("error_mm", error, "0 (by the noise) to 100 mm");
    const PaintedParts& painted = options.painted;
    if (painted.part.size() != painted.mesh.triangles.size()) {
        throw InputError(
            "scan", "painted", std::to_string(painted.part.size()) + " parts",
            "one for each of " + std::to_string(painted.mesh.triangles.size()) + " triangles");
    }
}

std::string unit_sentence(const ImportedScan& scan, double extent, bool given) {
    const std::string length = whole_number(extent * scan.mm_per_unit) + " mm long.";
    if (given) {
        std::string text = "Unit as given: ";
        const auto known = std::find_if(length_units.begin(), length_units.end(), [&](auto unit) {
            return millimetres_in(unit) == scan.mm_per_unit;
        });
        text += known == length_units.end() ? std::to_string(scan.mm_per_unit) + " mm"
                                            : std::string(name_of(*known));
        return text + "; " + length;
    }
    std::string text = "Taken to be in " + std::string(name_of(scan.unit.unit)) + ": " + length;
    if (!scan.unit.ambiguous) return text;
    if (!scan.unit.candidates[0].plausible) return text + " No sword is that long in any unit.";
    for (std::size_t i = 1; i < scan.unit.candidates.size(); ++i) {
        const UnitCandidate& other = scan.unit.candidates[i];
        if (!other.plausible) continue;
        text += " In " + std::string(name_of(other.unit)) + " it would be " +
                whole_number(other.length_mm) + " mm.";
    }
    return text;
}

void scale(TriangleMesh& mesh, MeshPieces& pieces, double mm) {
    if (mm == 1) return;
    mesh.origin *= mm;
    for (glm::vec3& p : mesh.positions) p = glm::vec3(glm::dvec3(p) * mm);
    for (MeshPiece& piece : pieces.pieces) {
        piece.area_mm2 *= mm * mm;
        piece.low *= mm;
        piece.high *= mm;
    }
}

RecordStep clean_step(const CleanReport& c) {
    RecordStep step{"clean", {}, {}, {}};
    for (const auto& [name, count] :
         {std::pair{"triangles before", c.triangles_before},
          std::pair{"triangles after", c.triangles_after},
          std::pair{"welded vertices", c.welded_vertices},
          std::pair{"unused vertices", c.unused_vertices},
          std::pair{"degenerate triangles", c.degenerate_triangles},
          std::pair{"triangles split at them", c.split_at_degenerate},
          std::pair{"duplicate triangles", c.duplicate_triangles},
          std::pair{"non-manifold edges", c.non_manifold_edges},
          std::pair{"non-manifold vertices", c.non_manifold_vertices},
          std::pair{"vertices split off", c.vertices_split_off},
          std::pair{"flipped triangles", c.flipped_triangles},
          std::pair{"reversed pieces", c.reversed_pieces},
          std::pair{"sheets left as they were", c.undecided_pieces},
          std::pair{"edges cut where no winding agrees", c.one_sided_edges}})
        step.figures.push_back({name, static_cast<double>(count), ""});
    return step;
}

RecordStep align_step(const ImportedScan& scan, const PoseCorrection& correction) {
    const BladePose& pose = scan.analysis.pose;
    RecordStep step{"align",
                    {{"swap_ends", correction.swap_ends},
                     {"swap_edge_and_back", correction.swap_edge_and_back}},
                    {},
                    {scan.analysis.text}};
    constexpr std::array<const char*, 3> axes{"x", "y", "z"};
    for (int i = 0; correction.machi_mm && i < 3; ++i) {
        step.parameters.emplace_back(
            std::string("given machi ") + axes[static_cast<std::size_t>(i)] + " (mm)",
            (*correction.machi_mm)[i]);
    }
    if (correction.kissaki_mm)
        step.parameters.emplace_back("given kissaki (mm)", *correction.kissaki_mm);
    for (int i = 0; i < 3; ++i)
        step.figures.push_back(
            {std::string("machi ") + axes[static_cast<std::size_t>(i)], pose.origin_mm[i], "mm"});
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            step.figures.push_back(
                {"rotation " + std::to_string(row + 1) + std::to_string(column + 1),
                 pose.rotation[column][row], ""});
        }
    }
    return step;
}

}  // namespace

ImportedScan import_scan(TriangleMesh scan, const ImportOptions& options,
                         const ImportProgress& progress) {
    check(options);
    ImportedScan result;
    StepClock clock(result.time);
    const auto report = [&](double share) {
        if (progress && !progress(share)) throw PrepareCancelled{};
    };
    result.clean = clean(scan);
    clock.end("clean");
    report(after_clean);
    MeshPieces pieces = find_pieces(scan);
    const double extent = pieces.pieces.empty() ? 0 : pieces.pieces.front().extent();
    if (!(extent > 0)) {
        throw InputError("scan", "surface", "none that is left after cleaning",
                         "triangles that have an area");
    }
    result.unit = guess_unit(extent, pieces.pieces.front().rough_width());
    const bool given = options.mm_per_unit > 0;
    result.mm_per_unit = given ? options.mm_per_unit : millimetres_in(result.unit.unit);
    result.unit_text = unit_sentence(result, extent, given);
    scale(scan, pieces, result.mm_per_unit);
    clock.end("pieces");
    result.steps.push_back({"unit",
                            {{"given", given}},
                            {{"mm per unit", result.mm_per_unit, "mm"},
                             {"longest extent", extent * result.mm_per_unit, "mm"}},
                            {result.unit_text}});
    result.steps.push_back(clean_step(result.clean));
    ScanAnalysisOptions analysis = options.analysis;
    if (options.machi) analysis.correction.machi_mm = result.mm_per_unit * *options.machi;
    result.analysis = analyse_scan(scan, pieces, analysis);
    clock.end("measure");
    report(after_analysis);
    result.steps.push_back(align_step(result, analysis.correction));
    finish_import(result, std::move(scan), pieces, options, [&](double share) {
        return !progress || progress(after_analysis + (1 - after_analysis) * share);
    });
    return result;
}

}  // namespace togishi
