// Triangles of a lighter mesh that the scan's noise has turned out of the blade's surface, laid
// back into it, so that the chart keeps their lengths.
#pragma once
#include <cstddef>
#include <span>

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
    /// The same for each vertex and what it touches, where less is allowed; empty: error_mm.
    std::span<const float> vertex_error_mm{};
    /// How far out of the smooth surface each vertex is laid; empty: onto it.
    std::span<const float> vertex_shift_mm{};
    int most_rounds = 30;
};

struct SettledCount {
    std::size_t moved = 0;      ///< vertices, onto the smooth surface
    std::size_t flipped = 0;    ///< edges
    std::size_t collapsed = 0;  ///< edges
    std::size_t slid = 0;       ///< times that a vertex went to another place of the surface
    std::size_t left = 0;       ///< triangles that are stretched by more than was asked for
    double stretched_mm2 = 0;   ///< area of such triangles before
    double left_mm2 = 0;        ///< ... and of those that are left
};

/// Vertices of such triangles go to their place on the chart's smooth surface, those between two
/// strips onto the ridge; what is stretched even there (slivers) has an edge flipped or collapsed.
/// Borders of regions stay lines, seams stay closed. Nakago and what is no blade stay as they are.
/// scan: that the mesh was made from, with the same origin.
SettledCount settle(ChartedMesh& mesh, const ScannedChart& chart, const SurfaceTree& scan,
                    const SettleOptions& options);

/// The same, measured: where a point of the scan or of the mesh comes to lie farther than error_mm
/// from the other, it is done again with less allowed about that place. False, and the mesh as it
/// was, where even that does not keep the distance or where it leaves more stretched than it was.
bool settle_within(ChartedMesh& mesh, const ScannedChart& chart, const TriangleMesh& scan,
                   double error_mm, std::size_t samples, SettledCount& count,
                   MeshDistance& distance);

}  // namespace togishi
