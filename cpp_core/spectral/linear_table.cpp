#include "spectral/linear_table.hpp"

#include <algorithm>
#include <cstddef>

namespace togishi {

std::vector<double> linear_at(std::span<const double> x, std::span<const double> y,
                              std::span<const double> wavelengths_nm) {
    std::vector<double> values(wavelengths_nm.size(), 0.0);
    std::size_t i = 0;
    for (std::size_t w = 0; w < wavelengths_nm.size(); ++w) {
        const double nm = wavelengths_nm[w];
        if (!(nm >= x.front() && nm <= x.back())) continue;
        while (i + 1 < x.size() && x[i + 1] <= nm) ++i;
        if (i + 1 == x.size()) {
            values[w] = y[i];
        } else {
            const double t = (nm - x[i]) / (x[i + 1] - x[i]);
            values[w] = (1.0 - t) * y[i] + t * y[i + 1];
        }
    }
    return values;
}

std::vector<double> linear_shared_out(std::span<const double> x, std::span<const double> y,
                                      const Grid& grid) {
    std::vector<double> values(grid.count, 0.0);
    for (std::size_t s = 0; s + 1 < x.size(); ++s) {
        const double begin = std::max(x[s], grid.first_nm);
        const double end = std::min(x[s + 1], grid.last_nm());
        auto polyline = [&](double nm) {
            const double t = (nm - x[s]) / (x[s + 1] - x[s]);
            return (1.0 - t) * y[s] + t * y[s + 1];
        };
        if (begin >= end) continue;
        // Cell by cell: within one, both the polyline and the hats are straight.
        double a = begin;
        for (auto cell = static_cast<std::size_t>((begin - grid.first_nm) / grid.step_nm);
             a < end && cell + 1 < grid.count; ++cell) {
            const double b = std::min(end, grid.wavelength_nm(cell + 1));
            const double ta = (a - grid.wavelength_nm(cell)) / grid.step_nm;
            const double tb = (b - grid.wavelength_nm(cell)) / grid.step_nm;
            const double pa = polyline(a);
            const double pb = polyline(b);
            const double width = (b - a) / grid.step_nm;
            const double right = width / 6.0 * (2.0 * pa * ta + pa * tb + pb * ta + 2.0 * pb * tb);
            values[cell + 1] += right;
            values[cell] += width * 0.5 * (pa + pb) - right;
            a = b;
        }
    }
    return values;
}

}  // namespace togishi
