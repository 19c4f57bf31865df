#include "fit/reflectance.hpp"

#include <algorithm>
#include <cmath>

#include "brdf/model.hpp"
#include "scan/scan_channel.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/metal.hpp"

namespace togishi {
namespace {

// Equal steps of the cosine: from -1 step to 1 + 1 step, so that a cubic has its four points
// everywhere.
constexpr int steps = 256;

}  // namespace

ReflectanceTable::ReflectanceTable(const std::string& metal, const std::string& light,
                                   const std::vector<ScanChannel>& channels) {
    const RefractiveIndex index = find_metal(metal)->at(grid_61);
    const std::size_t wavelengths = index.n.size();
    std::vector<std::vector<double>> shares;
    for (const ScanChannel& channel : channels) {
        const ChannelSpectrum spectrum = channel_spectrum(channel, light);
        const ColourWeights weights =
            colour_weights(*find_light(spectrum.light), *find_observer(default_observer), grid_61);
        std::vector<double> share(wavelengths);
        for (std::size_t i = 0; i < wavelengths; ++i) {
            share[i] = spectrum.xyz_weights.x * weights.x[i] +
                       spectrum.xyz_weights.y * weights.y[i] +
                       spectrum.xyz_weights.z * weights.z[i];
        }
        shares.push_back(std::move(share));
    }
    rows_.assign(channels.size(), std::vector<double>(steps + 3, 0.0));
    for (int i = 0; i <= steps; ++i) {
        for (std::size_t w = 0; w < wavelengths; ++w) {
            const double f =
                f64::fresnel_conductor(index.n[w], index.k[w], static_cast<double>(i) / steps);
            for (std::size_t c = 0; c < channels.size(); ++c)
                rows_[c][static_cast<std::size_t>(i) + 1] += shares[c][w] * f;
        }
    }
    for (auto& row : rows_) {
        // The ends are continued by the cubic through the four points beside them.
        const std::size_t n = row.size();
        row[0] = 4 * row[1] - 6 * row[2] + 4 * row[3] - row[4];
        row[n - 1] = 4 * row[n - 2] - 6 * row[n - 3] + 4 * row[n - 4] - row[n - 5];
    }
}

Reflectance ReflectanceTable::at(std::size_t channel, double cosine) const {
    const double x = std::clamp(cosine, 0.0, 1.0) * steps;
    const auto cell =
        static_cast<std::size_t>(std::min(static_cast<double>(steps - 1), std::floor(x)));
    const double t = x - static_cast<double>(cell);
    const double* p = rows_[channel].data() + cell;
    // Lagrange's cubic through the points at -1, 0, 1, 2.
    const double a = (-p[0] + 3 * p[1] - 3 * p[2] + p[3]) / 6;
    const double b = (p[0] - 2 * p[1] + p[2]) / 2;
    const double c = (-2 * p[0] - 3 * p[1] + 6 * p[2] - p[3]) / 6;
    return {p[1] + t * (c + t * (b + t * a)), (c + t * (2 * b + 3 * t * a)) * steps};
}

}  // namespace togishi
