// What a scan shows: whether it is a blade, how it lies, its dimensions with their uncertainties
// and its cross-sections. docs/scan_import.md defines each dimension.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "blade/katana_parameters.hpp"
#include "scanned/blade_fit.hpp"
#include "scanned/coarse_pose.hpp"
#include "scanned/stations.hpp"

namespace togishi {

enum class ScanVerdict { blade, part_of_blade, several_blades, mounted, no_blade };
[[nodiscard]] std::string_view verdict_name(ScanVerdict verdict);

struct ScanMeasure {
    std::string name;  ///< as katana_measures names it: nagasa_mm, sori_mm, ...
    double value = 0;
    double sigma = 0;       ///< one standard deviation, from the scan's noise
    std::string unit;       ///< "mm"
    bool inferred = false;  ///< where the scan does not show it: note says why
    std::string note;
};

/// A width or thickness along the blade.
struct TaperPoint {
    double s_mm = 0;  ///< arc length from the machi
    double width_mm = 0, kasane_mm = 0, shinogi_haba_mm = 0, shinogi_kasane_mm = 0;
};

struct ScanAnalysis {
    ScanVerdict verdict = ScanVerdict::no_blade;
    std::string text;                 ///< what it sees, and what it asks, whole sentences
    std::vector<std::string> doubts;  ///< what a user should look at
    BladePose pose;
    ScannedStations stations;  ///< none where the verdict lets none be told
    std::vector<ScanMeasure> measures;
    std::vector<TaperPoint> taper;
    std::string mune_type;   ///< "iori", ...; empty: not known
    std::string zukuri;      ///< "shinogi", "shobu", "hira"
    double noise_mm = 0;     ///< of a vertex, across the surface
    std::vector<char> body;  ///< per piece of the mesh: the blade's own, or a fitting's on it
    /// Stretches that fittings cover, arc lengths from the machi.
    std::vector<std::pair<double, double>> fittings_mm;
};

struct ScanAnalysisOptions {
    PoseCorrection correction;
    int replicates =
        16;  ///< fits to the scan with its own noise once more, for the uncertainties; 0: none
    double samples = 250000;  ///< points that the fits use
};

/// Throws InputError where a correction is none that a blade could have.
[[nodiscard]] ScanAnalysis analyse_scan(const TriangleMesh& mesh_mm, const MeshPieces& pieces,
                                        const ScanAnalysisOptions& options = {});

}  // namespace togishi
