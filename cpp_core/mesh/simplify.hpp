// A lighter mesh within a stated distance, by meshoptimizer, and what its distance really is.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/distance.hpp"
#include "mesh/triangle_mesh.hpp"

namespace togishi {

struct SimplifyOptions {
    double error_mm = 0.05;  ///< largest distance between the two surfaces, either way; > 0
    /// V, 1: never moved nor removed; empty: none.
    std::span<const std::uint8_t> locked{};
    /// F, the triangle's part: borders between parts are kept as lines (their points may thin out
    /// along them); empty: one part.
    std::span<const std::uint8_t> part{};
    /// V x attribute_count, row by row: what should stay close too, as a normal or a colour.
    std::span<const float> attributes{};
    std::size_t attribute_count = 0;  ///< at most 16
    /// attribute_count: mm of distance that a difference of 1 is worth.
    std::span<const float> attribute_weights{};
    bool lock_border = false;  ///< the mesh's own borders keep all their points
    std::size_t at_least = 0;  ///< stop at this many triangles
    /// More than twice as many are cut into stretches of so many, which are worked on side by side.
    std::size_t stretch_triangles = 50'000;
    std::size_t samples = 200'000;  ///< points per side that the distance is measured at
};

struct SimplifiedMesh {
    TriangleMesh mesh;  ///< vertices are some of the original's, with its origin
    std::vector<std::uint32_t>
        source_vertex;               ///< V', the original's vertex: takes every attribute over
    std::vector<std::uint8_t> part;  ///< F', or empty where none was given
    MeshDistance distance;           ///< measured, to the original
    int attempts = 0;                ///< with tightened bounds, until the measured distance kept
};

/// `mesh`: cleaned, in mm. meshoptimizer's own error is an estimate by quadrics, which a sharp edge
/// exceeds several times: so every vertex is measured afterwards, those beyond the bound are
/// locked, and it is done again, until all keep it. Long meshes are cut into stretches across their
/// longest side, on all cores, then once more at other places, in few attempts each (of more than
/// three million triangles, most go without a measurement in the first turn); where the measured
/// distance then exceeds the bound, with a smaller one, four times at most: distance.largest says
/// what was reached. Results do not depend on the number of threads. Throws InputError for options
/// out of range or arrays of the wrong length.
[[nodiscard]] SimplifiedMesh simplify(const TriangleMesh& mesh, const SimplifyOptions& options);

/// Levels of detail: errors_mm rising; each is made from the one before, its distance measured to
/// `mesh`; source_vertex is the vertex of `mesh`. options.error_mm is not used.
[[nodiscard]] std::vector<SimplifiedMesh> levels_of_detail(const TriangleMesh& mesh,
                                                           std::span<const double> errors_mm,
                                                           const SimplifyOptions& options);

}  // namespace togishi
