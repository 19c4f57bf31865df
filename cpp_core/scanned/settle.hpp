// Triangles of a lighter mesh that the scan's noise has turned out of the blade's surface, laid
// back into it, so that the chart keeps their lengths.
#pragma once
#include <cstddef>

#include "mesh/distance.hpp"
#include "scanned/chart.hpp"
#include "scanned/chart_mesh.hpp"

namespace togishi {

struct SettleOptions {
    /// A triangle whose lengths the chart changes by more than this share is settled.
    double most_stretch = 0.02;
    /// How far from the scan what is settled may lie; what would have to go farther (a chip of the
    /// edge, a dent) stays as the scan shows it.
    double error_mm = 0.05;
    int most_rounds = 30;
};

struct SettledCount {
    std::size_t moved = 0;      ///< vertices, onto the smooth surface
    std::size_t flipped = 0;    ///< edges
    std::size_t collapsed = 0;  ///< edges
    std::size_t left = 0;       ///< triangles that are stretched by more than was asked for
};

/// Vertices of such triangles go to their place on the chart's smooth surface, those between two
/// strips onto the ridge; what is stretched even there (slivers) has an edge flipped or collapsed.
/// Borders of regions stay lines, seams stay closed. Nakago and what is no blade stay as they are.
/// scan: that the mesh was made from, with the same origin.
SettledCount settle(ChartedMesh& mesh, const ScannedChart& chart, const SurfaceTree& scan,
                    const SettleOptions& options);

}  // namespace togishi
