// What a round source and a round detector blur: the readings are averages over both.
#pragma once
#include <vector>

namespace togishi {

/// A displacement of the line of sight, in rad, and its share of the average.
struct ApertureNode {
    double along, across, share;
};

/// Nodes for the sum of a displacement in each of two discs, by Gauss quadrature of the radius:
/// exact for polynomials of degree 4 rings - 1. Angles are full; both 0: one node at 0. rings: 1
/// to 16.
[[nodiscard]] std::vector<ApertureNode> aperture_nodes(double source_deg, double detector_deg,
                                                       int rings);

/// Rings that hold the average of a Gaussian lobe to 1e-4 of its peak (3e-5 up to a reach of 1),
/// where the aperture moves the half vector by up to `reach` of the lobe's half width.
[[nodiscard]] int aperture_rings(double reach);

}  // namespace togishi
