// Which part of the blade each triangle of a scan is.
#pragma once
#include <vector>

#include "blade/part.hpp"
#include "scanned/chart.hpp"
#include "scanned/scan_analysis.hpp"

namespace togishi {

/// Per triangle; Part::other for fittings, stand and whatever else is no blade. `chart` is made of
/// the analysis' stations; ha and boshi end at its nominal suguha, as no scan of the shape tells
/// the hamon.
[[nodiscard]] std::vector<Part> label_parts(const TriangleMesh& mesh_mm, const MeshPieces& pieces,
                                            const ScanAnalysis& analysis,
                                            const ScannedChart& chart);

}  // namespace togishi
