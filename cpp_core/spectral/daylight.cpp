#include "spectral/daylight.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "spectral/embedded_data.hpp"

namespace togishi {

namespace {

const TableFile& components() {
    static const TableFile table = [] {
        for (const auto& file : embedded_files()) {
            if (file.path == daylight_components_path) {
                return parse_table(file.text, "data/" + std::string(file.path),
                                   "daylight_components", 4, TableMetadata::required);
            }
        }
        throw std::logic_error("data/lights/daylight_components.csv was not built in");
    }();
    return table;
}

double round3(double value) {
    return std::round(value * 1000.0) / 1000.0;
}

}  // namespace

TableSpectrum daylight(double cct_k) {
    // CIE 015:2018, equations 4.5 to 4.10.
    const double t = 1000.0 / cct_k;
    const double x = cct_k <= 7000.0 ? ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
                                     : ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040;
    const double y = (-3.000 * x + 2.870) * x - 0.275;
    const double m = 0.0241 + 0.2562 * x - 0.7341 * y;
    const double m1 = round3((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
    const double m2 = round3((0.0300 - 31.4424 * x + 30.0717 * y) / m);

    const auto& c = components().columns;
    TableSpectrum spectrum{c[0], c[1]};
    for (std::size_t i = 0; i < spectrum.power.size(); ++i) {
        // Below 330 nm, far outside the visible, the sum can fall under zero.
        spectrum.power[i] = std::max(0.0, c[1][i] + m1 * c[2][i] + m2 * c[3][i]);
    }
    return spectrum;
}

std::string daylight_source() {
    return std::string(components().value("source"));
}
std::string daylight_licence() {
    return std::string(components().value("licence"));
}

}  // namespace togishi
