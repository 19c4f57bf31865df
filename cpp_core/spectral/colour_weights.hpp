// From a spectrum to XYZ: what each wavelength of a grid adds to X, Y and Z under one light.
#pragma once
#include <array>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "spectral/grid.hpp"
#include "spectral/light.hpp"
#include "spectral/observer.hpp"

namespace togishi {

/// XYZ of a surface of reflectance R under the light = sum over i of R(i) * (x[i], y[i], z[i]).
struct ColourWeights {
    Grid grid;
    std::vector<double> x;
    std::vector<double> y;
    std::vector<double> z;
    glm::dvec3 white;  ///< XYZ of the light itself, the sum of all weights: Y = 1

    /// One reflectance per wavelength of the grid.
    [[nodiscard]] glm::dvec3 xyz(std::span<const double> reflectance) const;
};

/// The light at Y = 1 on a grid. The light's white is always that of 360 to 830 nm at 1 nm: on a
/// coarser grid each of X, Y and Z is multiplied by W_full/W_grid (design, section 1), so that
/// every grid agrees about the light itself. A component whose W_grid is zero, or below 1e-12 of
/// the largest, is left as it is. Throws InputError where the observer sees nothing of the light on
/// the grid.
[[nodiscard]] ColourWeights colour_weights(const Light& light, const Observer& observer,
                                           const Grid& grid = grid_61);

/// The same sum over the grid without the correction, scaled by its own Y: for measuring what the
/// correction gains.
[[nodiscard]] ColourWeights colour_weights_uncorrected(const Light& light, const Observer& observer,
                                                       const Grid& grid);

}  // namespace togishi
