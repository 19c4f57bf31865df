#include "spectral/colour_weights.hpp"

#include <algorithm>
#include <string>

#include "base/error.hpp"

namespace togishi {

namespace {

constexpr double smallest_share = 1e-12;

using Functions = std::array<std::vector<double>, 3>;

glm::dvec3 weighed_sum(const std::vector<double>& power, const Functions& functions,
                       double step_nm) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < power.size(); ++i) {
        sum += power[i] * glm::dvec3(functions[0][i], functions[1][i], functions[2][i]);
    }
    return sum * step_nm;
}

// Observers hold their functions on the two grids that every light asks for.
Functions functions_on(const Observer& observer, const Grid& grid) {
    if (grid == grid_61) return observer.on_61();
    if (grid == grid_full) return observer.on_full();
    return observer.at(grid);
}

ColourWeights weigh(const std::vector<double>& power, const Functions& functions, const Grid& grid,
                    const glm::dvec3& scale) {
    ColourWeights weights;
    weights.grid = grid;
    auto column = [&](int c) {
        std::vector<double> values(grid.count);
        for (std::size_t i = 0; i < grid.count; ++i) {
            values[i] =
                power[i] * functions[static_cast<std::size_t>(c)][i] * grid.step_nm * scale[c];
        }
        return values;
    };
    weights.x = column(0);
    weights.y = column(1);
    weights.z = column(2);
    weights.white = weighed_sum(power, functions, grid.step_nm) * scale;
    return weights;
}

// Scaled to a peak of 1, so that neither 1e-80 nor 1e80 W leaves the range of the sums.
std::vector<double> normalised(std::vector<double> power, double peak) {
    for (double& p : power) p /= peak;
    return power;
}

void require_visible(const Light& light, double y) {
    if (y > 0.0) return;
    throw InputError("light " + light.description().name, "luminance from 400 to 700 nm", "zero",
                     "a spectrum that the eye sees");
}

}  // namespace

glm::dvec3 ColourWeights::xyz(std::span<const double> reflectance) const {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < grid.count; ++i)
        sum += reflectance[i] * glm::dvec3(x[i], y[i], z[i]);
    return sum;
}

ColourWeights colour_weights(const Light& light, const Observer& observer, const Grid& grid) {
    const auto raw_full = light.sample(grid_full);
    const double peak = *std::max_element(raw_full.begin(), raw_full.end());
    require_visible(light, peak);
    const auto full = normalised(raw_full, peak);
    const auto power = grid == grid_full ? full : normalised(light.sample(grid), peak);
    const auto functions = functions_on(observer, grid);

    const glm::dvec3 w_full = weighed_sum(full, observer.on_full(), grid_full.step_nm);
    const glm::dvec3 w_grid = weighed_sum(power, functions, grid.step_nm);
    require_visible(light, w_full.y);
    require_visible(light, w_grid.y);
    const double smallest = smallest_share * std::max({w_grid.x, w_grid.y, w_grid.z});
    glm::dvec3 scale(1.0 / w_full.y);
    for (int c = 0; c < 3; ++c) {
        if (w_grid[c] > smallest) scale[c] *= w_full[c] / w_grid[c];
    }
    return weigh(power, functions, grid, scale);
}

ColourWeights colour_weights_uncorrected(const Light& light, const Observer& observer,
                                         const Grid& grid) {
    const auto raw = light.sample(grid);
    const double peak = *std::max_element(raw.begin(), raw.end());
    require_visible(light, peak);
    const auto power = normalised(raw, peak);
    const auto functions = functions_on(observer, grid);
    const double y = weighed_sum(power, functions, grid.step_nm).y;
    require_visible(light, y);
    return weigh(power, functions, grid, glm::dvec3(1.0 / y));
}

}  // namespace togishi
