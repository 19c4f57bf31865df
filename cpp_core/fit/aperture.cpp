#include "fit/aperture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Dense>

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;

// Area that two discs share whose centres lie r apart.
double shared_area(double a, double b, double r) {
    if (r >= a + b) return 0;
    const double small = std::min(a, b);
    if (r <= std::abs(a - b)) return std::numbers::pi * small * small;
    const double x = (r * r + a * a - b * b) / (2 * r);
    const double y = r - x;
    const auto segment = [](double radius, double distance) {
        const double c = std::clamp(distance / radius, -1.0, 1.0);
        return radius * radius * (std::acos(c) - c * std::sqrt(1 - c * c));
    };
    return segment(a, x) + segment(b, y);
}

struct RadiusNode {
    double radius, share;
};

// Gauss nodes in s = r^2 for the density of the sum of the two displacements (Golub and Welsch,
// 1969), the recurrence by Stieltjes' procedure on a fine sum.
std::vector<RadiusNode> radius_nodes(double a, double b, int rings) {
    constexpr int steps = 2000;
    const double most = a + b;
    std::vector<double> s(steps), weight(steps);
    for (int i = 0; i < steps; ++i) {
        const double r = most * (i + 0.5) / steps;
        const auto at = static_cast<std::size_t>(i);
        s[at] = r * r / (most * most);
        // One disc alone has a constant density.
        weight[at] = r * (std::min(a, b) > 0 ? shared_area(a, b, r) : 1.0);
    }
    Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(rings, rings);
    std::vector<double> before(steps, 0.0), now(steps, 1.0);
    double norm_before = 1;
    for (int k = 0; k < rings; ++k) {
        double norm = 0, mean = 0;
        for (std::size_t i = 0; i < steps; ++i) {
            const double w = weight[i] * now[i] * now[i];
            norm += w;
            mean += w * s[i];
        }
        const double alpha = mean / norm;
        const double beta = k == 0 ? 0 : norm / norm_before;
        jacobi(k, k) = alpha;
        if (k > 0) jacobi(k, k - 1) = jacobi(k - 1, k) = std::sqrt(beta);
        for (std::size_t i = 0; i < steps; ++i) {
            const double next = (s[i] - alpha) * now[i] - beta * before[i];
            before[i] = now[i];
            now[i] = next;
        }
        norm_before = norm;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(jacobi);
    std::vector<RadiusNode> nodes;
    for (int k = 0; k < rings; ++k) {
        const double first = solved.eigenvectors()(0, k);
        nodes.push_back({most * std::sqrt(std::max(solved.eigenvalues()(k), 0.0)), first * first});
    }
    return nodes;
}

}  // namespace

std::vector<ApertureNode> aperture_nodes(double source_deg, double detector_deg, int rings) {
    if (source_deg <= 0 && detector_deg <= 0) return {{0, 0, 1}};
    const double a = std::tan(0.5 * std::max(source_deg, 0.0) * rad_per_deg);
    const double b = std::tan(0.5 * std::max(detector_deg, 0.0) * rad_per_deg);
    const int around = 4 * rings;
    std::vector<ApertureNode> nodes;
    int ring = 0;
    for (const RadiusNode& node : radius_nodes(a, b, rings)) {
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * (i + 0.5 * (ring % 2)) / around;
            nodes.push_back({node.radius * std::cos(angle), node.radius * std::sin(angle),
                             node.share / around});
        }
        ++ring;
    }
    return nodes;
}

int aperture_rings(double reach) {
    constexpr double reaches[] = {0.15, 0.6, 1.1, 1.7, 2.3, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0};
    int rings = 1;
    for (const double most : reaches) {
        if (reach <= most) return rings;
        ++rings;
    }
    return 16;
}

}  // namespace togishi
