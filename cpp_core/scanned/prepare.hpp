// A scanned blade made ready for pictures: charted, lighter, with its detail in maps.
#pragma once
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "mesh/simplify.hpp"
#include "scanned/chart_mesh.hpp"
#include "scanned/detail.hpp"
#include "scanned/settle.hpp"
#include "scanned/step_clock.hpp"

namespace togishi {

struct PrepareOptions {
    double error_mm = 0.05;   ///< largest distance of the first level from the scan, either way
    std::size_t levels = 3;   ///< of detail, 1 to 6
    double level_factor = 4;  ///< by which the distance grows from level to level, above 1
    ChartOptions chart;
    bool maps = true;  ///< what the finest level has lost, as maps
    DetailOptions detail;
    std::size_t samples = 200'000;  ///< points per side that distances are measured at
};

struct PreparedLevel {
    BladeMesh mesh;
    double error_mm = 0;    ///< what was asked for
    MeshDistance distance;  ///< what it is, measured against the whole scan
};

struct PreparedBlade {
    std::vector<PreparedLevel> levels;  ///< the finest first
    DetailMaps detail;                  ///< against the finest; empty without maps
    std::size_t scan_triangles = 0;
    std::size_t cut_triangles = 0;  ///< of the scan, along seams and borders
    SettledCount settled;           ///< of the finest level
    /// Of the finest level from machi to tip: what 99 % of the area does not pass
    /// (uv_stretch_of_area_percent), and the largest (uv_stretch_percent): of what could not
    /// be settled, as a chip of the edge.
    double stretch_99_percent = 0, stretch_most_percent = 0;
    std::map<std::string, StepTime>
        time;  ///< per step: chart, cut, simplify, settle, detail, corners
};

/// Called between steps with the share done; false cancels.
using PrepareProgress = std::function<bool(double)>;
struct PrepareCancelled {};

/// scan: cleaned, in mm, without what is no blade; it is used up. labels: as chart_mesh. Throws
/// InputError as its steps do; PrepareCancelled.
[[nodiscard]] PreparedBlade prepare_blade(TriangleMesh scan, const BladePose& pose,
                                          const ScannedStations& stations,
                                          std::span<const Part> labels,
                                          const PrepareOptions& options,
                                          const PrepareProgress& progress = {});

}  // namespace togishi
