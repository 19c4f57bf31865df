#include "fit/unseen_tilt.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace togishi {

Interval interval_with_drop(double sigma, double drop) {
    constexpr double held = 0.682689492137086;  // of a normal within one standard deviation
    // Either part alone, where the other is lost in it. P(z^2 < 1) is the same share.
    constexpr double lost = 1e-3;
    if (drop < lost * sigma) return {drop, sigma};
    if (sigma < lost * drop) return {0.5 * drop, 0.5 * drop};
    // The distribution's values at equal steps: P(z^2 < y) = erf(sqrt(y/2)), averaged over g.
    constexpr double furthest = 5;
    constexpr int normals = 120, steps = 1200;
    const double first = -furthest * sigma, last = 3 * drop + furthest * sigma;
    const double step = (last - first) / steps;
    std::vector<double> share(normals), below(steps + 1, 0.0);
    double total = 0;
    const auto normal = [](int i) { return furthest * ((2 * i + 1.0) / normals - 1); };
    for (int i = 0; i < normals; ++i) {
        share[static_cast<std::size_t>(i)] = std::exp(-0.5 * normal(i) * normal(i));
        total += share[static_cast<std::size_t>(i)];
    }
    for (int k = 0; k <= steps; ++k) {
        const double x = first + k * step;
        double sum = 0;
        for (int i = 0; i < normals; ++i) {
            const double y = (x - sigma * normal(i)) / drop;
            if (y > 0) sum += share[static_cast<std::size_t>(i)] * std::erf(std::sqrt(0.5 * y));
        }
        below[static_cast<std::size_t>(k)] = sum / total;
    }
    Interval shortest{0, std::numeric_limits<double>::infinity()};
    std::size_t to = 0;
    for (std::size_t from = 0; from < below.size(); ++from) {
        while (to < below.size() && below[to] - below[from] < held) ++to;
        if (to == 0 || to == below.size()) break;
        const double before = below[to - 1] - below[from], after = below[to] - below[from];
        const double low = first + static_cast<double>(from) * step;
        const double high =
            first + (static_cast<double>(to) - (after - held) / (after - before)) * step;
        if (0.5 * (high - low) < shortest.half) shortest = {0.5 * (low + high), 0.5 * (high - low)};
    }
    return shortest;
}

}  // namespace togishi
