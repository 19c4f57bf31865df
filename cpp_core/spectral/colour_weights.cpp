#include "spectral/colour_weights.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "base/error.hpp"

namespace togishi {

namespace {

void require_visible(const Light& light, double y) {
    if (y > 0.0) return;
    throw InputError("light " + light.description().name, "luminance from 360 to 830 nm", "zero",
                     "a spectrum that the eye sees");
}

glm::dvec3 sum_of(const ColourWeights& weights) {
    auto sum = [](const std::vector<double>& v) {
        return std::accumulate(v.begin(), v.end(), 0.0);
    };
    return {sum(weights.x), sum(weights.y), sum(weights.z)};
}

// Shares each 1 nm product of power and colour-matching function out between the two samples of the
// grid around it, in proportion to its distance from them; what lies beyond the grid goes to its
// end.
ColourWeights shared_out(const std::vector<double>& power,
                         const std::array<std::vector<double>, 3>& functions, const Grid& grid) {
    ColourWeights weights{grid, std::vector<double>(grid.count), std::vector<double>(grid.count),
                          std::vector<double>(grid.count), glm::dvec3(0.0)};
    for (std::size_t i = 0; i < grid_full.count; ++i) {
        const double nm = grid_full.wavelength_nm(i);
        if (power[i] == 0.0) continue;
        const double position =
            (std::clamp(nm, grid.first_nm, grid.last_nm()) - grid.first_nm) / grid.step_nm;
        const auto left = std::min(static_cast<std::size_t>(position), grid.count - 2);
        const double to_right = power[i] * (position - static_cast<double>(left));
        const double to_left = power[i] - to_right;
        weights.x[left] += to_left * functions[0][i];
        weights.y[left] += to_left * functions[1][i];
        weights.z[left] += to_left * functions[2][i];
        weights.x[left + 1] += to_right * functions[0][i];
        weights.y[left + 1] += to_right * functions[1][i];
        weights.z[left + 1] += to_right * functions[2][i];
    }
    return weights;
}

}  // namespace

glm::dvec3 ColourWeights::xyz(std::span<const double> reflectance) const {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < grid.count; ++i)
        sum += reflectance[i] * glm::dvec3(x[i], y[i], z[i]);
    return sum;
}

ColourWeights colour_weights(const Light& light, const Observer& observer, const Grid& grid) {
    auto power = light.sample(grid_full);
    // Scaled to a peak of 1 first, so that neither 1e-80 nor 1e80 leaves the range of the sums.
    const double peak = *std::max_element(power.begin(), power.end());
    require_visible(light, peak);
    for (double& p : power) p /= peak;

    auto weights = shared_out(power, observer.on_full(), grid);
    const double luminance = sum_of(weights).y;
    require_visible(light, luminance);
    for (auto* column : {&weights.x, &weights.y, &weights.z}) {
        for (double& w : *column) w /= luminance;
    }
    weights.white = sum_of(weights);
    return weights;
}

}  // namespace togishi
