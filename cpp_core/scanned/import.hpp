// From a scan to a blade that takes every material and map: all steps one after the other, and what
// each of them found.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/clean.hpp"
#include "mesh/holes.hpp"
#include "mesh/unit_guess.hpp"
#include "scanned/prepare.hpp"
#include "scanned/record.hpp"
#include "scanned/scan_analysis.hpp"

namespace togishi {

/// Faces that the user gave a part, in the scan's coordinates (mm), so that they outlive another
/// pose.
struct PaintedParts {
    TriangleMesh mesh;               ///< mm; all faces, or those about the painted ones
    std::vector<std::int32_t> part;  ///< per triangle; not_painted elsewhere
    static constexpr std::int32_t not_painted = -1;
};

struct ImportOptions {
    double mm_per_unit = 0;     ///< 0: guessed from the length
    double close_holes_mm = 0;  ///< holes whose border is no longer are closed
    ScanAnalysisOptions
        analysis;  ///< with the user's corrections of the pose; machi_mm is not used
    /// PoseCorrection::machi_mm, in the unit of the scan's file.
    std::optional<glm::dvec3> machi;
    /// error_mm 0: 0.05, or eight times the scan's noise where that is more.
    PrepareOptions prepare = [] {
        PrepareOptions automatic;
        automatic.error_mm = 0;
        return automatic;
    }();
    PaintedParts painted;
};

/// A piece that is no part of the blade, in blade coordinates, mm; the smallest are one together.
struct AsidePiece {
    TriangleMesh mesh;
    std::string text;  ///< how large it is
};

struct ImportedScan {
    UnitGuess unit;
    double mm_per_unit = 1;
    std::string unit_text;  ///< what was taken, and what else would do
    CleanReport clean;
    std::size_t holes = 0;  ///< of the blade's pieces
    double longest_hole_mm = 0;
    HoleClosing closing;
    ScanAnalysis analysis;
    PreparedBlade blade;                ///< no levels where it is told to be no blade
    double error_mm = 0;                ///< of the finest level, as it was asked for
    std::vector<std::int32_t> painted;  ///< per face of the finest level; empty: none was given
    std::vector<AsidePiece> aside;
    std::map<std::string, StepTime> time;  ///< per step, with those of `blade`
    std::vector<RecordStep> steps;
    std::vector<std::string> inferred;

    [[nodiscard]] bool is_blade() const { return !blade.levels.empty(); }
};

/// Called with the share done; false cancels (PrepareCancelled).
using ImportProgress = std::function<bool(double)>;

/// scan: in the file's unit, as it was read; it is used up. Where it is no blade that can be told,
/// the verdict says so and nothing is prepared. Throws InputError as the steps do and for units,
/// distances and painted parts that are none.
[[nodiscard]] ImportedScan import_scan(TriangleMesh scan, const ImportOptions& options,
                                       const ImportProgress& progress = {});

/// The steps after the analysis (`result.analysis`) of a clean mesh in mm, which is used up.
void finish_import(ImportedScan& result, TriangleMesh mesh_mm, const MeshPieces& pieces,
                   const ImportOptions& options, const ImportProgress& progress = {});

/// What the import has to say in a record; files, object and time are the caller's.
[[nodiscard]] ScanRecord record_of(const ImportedScan& scan);

/// "nagasa_mm" as a table has it: "Nagasa".
[[nodiscard]] std::string measure_label(std::string_view name);

/// Where a dimension is drawn over the blade: points of a line, blade coordinates, mm. By the names
/// of ScanMeasure; only those that have a place.
[[nodiscard]] std::map<std::string, std::vector<glm::dvec3>> drawn_measures(
    const ScannedStations& stations);

}  // namespace togishi
