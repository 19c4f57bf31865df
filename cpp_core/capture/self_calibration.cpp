#include "capture/self_calibration.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "base/parallel.hpp"
#include "capture/pixel_result.hpp"

namespace togishi {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double outlying_sigma = 5;
// Sums are formed in as many parts whatever the number of threads, so that they round alike.
constexpr std::size_t parts = 8;

// One pixel's samples: what its unknowns cannot explain is what the lights must.
struct Eliminated {
    std::vector<int> lit;  // lights whose half vector the pixel feels
    Matrix of_unknowns;    // (lit, unknowns): slopes
    Matrix explained;      // (lit, unknowns): slopes times covariance
    Vector residual;       // (lit), without what the unknowns explain
    bool usable = false;
};

Eliminated eliminate(const std::vector<float>& residual, const std::vector<float>& by_unknown,
                     std::size_t count, int unknowns, std::size_t lane) {
    Eliminated e;
    const auto rows = static_cast<Eigen::Index>(count);
    Matrix j(rows, unknowns);
    Vector r(rows);
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        r(row) = residual[i * block_pixels + lane];
        const bool drop = !(std::abs(r(row)) < outlying_sigma);
        if (drop) r(row) = 0;
        for (int a = 0; a < unknowns; ++a) {
            const auto at = (static_cast<std::size_t>(a) * count + i) * block_pixels + lane;
            j(row, a) = drop ? 0.0 : by_unknown[at];
        }
    }
    Matrix normal = j.transpose() * j;
    // A share that the pixel does not see at all would leave the matrix singular.
    for (int a = 0; a < unknowns; ++a) normal(a, a) += 1e-9 * (1 + normal(a, a));
    const Matrix covariance = normal.llt().solve(Matrix::Identity(unknowns, unknowns));
    if (!covariance.allFinite()) return e;
    const Vector left = r - j * (covariance * (j.transpose() * r));
    constexpr double felt = 1e-3;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (std::abs(j(row, tilt_u)) + std::abs(j(row, tilt_v)) > felt)
            e.lit.push_back(static_cast<int>(i));
    }
    e.of_unknowns.resize(static_cast<Eigen::Index>(e.lit.size()), unknowns);
    e.residual.resize(static_cast<Eigen::Index>(e.lit.size()));
    for (std::size_t k = 0; k < e.lit.size(); ++k) {
        e.of_unknowns.row(static_cast<Eigen::Index>(k)) = j.row(e.lit[k]);
        e.residual(static_cast<Eigen::Index>(k)) = left(e.lit[k]);
    }
    e.explained = e.of_unknowns * covariance;
    e.usable = true;
    return e;
}

// Adds a pixel to the lights' normal equations.
void add(const Eliminated& e, Matrix& a, Vector& g) {
    const auto n = static_cast<Eigen::Index>(e.lit.size());
    const Matrix shared = e.explained * e.of_unknowns.transpose();
    for (Eigen::Index k = 0; k < n; ++k) {
        // The slope over the half vector is minus that over the tilt.
        const double ku = -e.of_unknowns(k, tilt_u), kv = -e.of_unknowns(k, tilt_v);
        const Eigen::Index at = 2 * e.lit[static_cast<std::size_t>(k)];
        g(at) += ku * e.residual(k);
        g(at + 1) += kv * e.residual(k);
        for (Eigen::Index m = 0; m < n; ++m) {
            const double mu = -e.of_unknowns(m, tilt_u), mv = -e.of_unknowns(m, tilt_v);
            const double left = (k == m ? 1.0 : 0.0) - shared(k, m);
            const Eigen::Index to = 2 * e.lit[static_cast<std::size_t>(m)];
            a(at, to) += left * ku * mu;
            a(at, to + 1) += left * ku * mv;
            a(at + 1, to) += left * kv * mu;
            a(at + 1, to + 1) += left * kv * mv;
        }
    }
}

// The lights' remaining error in two parts. A common map of the half vectors, h -> h + shift + L h,
// changes no residual: each pixel's tilt and shape take it up, whatever its lobe. So the prior
// alone holds it, and every pixel inherits it. What is left differs from light to light like noise.
struct Remaining {
    double independent_deg = 0;  // per axis
    SharedError shared;
};

// covariance: of the lights' offsets; normal: its inverse, in which `prior` is what was known
// before. Lights that no pixel feels have the prior's error and nobody inherits it: they do not
// count.
Remaining remaining(const RegionLights& lights, const Matrix& normal, const Matrix& covariance,
                    double prior) {
    const auto size = normal.rows();
    Matrix map = Matrix::Zero(size, shared_unknowns);
    Vector told(size);
    for (Eigen::Index at = 0; at < size; at += 2) {
        const auto i = static_cast<std::size_t>(at / 2);
        told(at) = 1 - prior / normal(at, at);
        told(at + 1) = 1 - prior / normal(at + 1, at + 1);
        for (int axis = 0; axis < 2; ++axis) {
            map(at + axis, axis) = 1;
            map(at + axis, 2 + 2 * axis) = lights.u_deg[i];
            map(at + axis, 3 + 2 * axis) = lights.v_deg[i];
        }
    }
    Remaining found;
    found.independent_deg = 1 / std::sqrt(prior);
    const double all = told.sum();
    const auto factor = Matrix(map.transpose() * told.asDiagonal() * map).llt();
    if (!(all > 1) || factor.info() != Eigen::Success) return found;
    const Matrix fitted = factor.solve(map.transpose() * told.asDiagonal());
    const Matrix common = fitted * covariance * fitted.transpose();
    const Matrix rest = Matrix::Identity(size, size) - map * fitted;
    const Matrix left = rest * covariance * rest.transpose();
    if (!common.allFinite() || !left.allFinite()) return found;
    found.independent_deg = std::sqrt(std::max(0.0, left.diagonal().dot(told) / all));
    Eigen::Map<Matrix>(found.shared.covariance.data(), shared_unknowns, shared_unknowns) = common;
    found.shared.normal = lights.normal;
    found.shared.tangent = lights.tangent;
    found.shared.bitangent = lights.bitangent;
    return found;
}

}  // namespace

Calibration self_calibrate(RegionLights& lights, const SampleBlocks& samples,
                           const PixelKernelOptions& options, int rounds, unsigned threads) {
    const std::size_t count = lights.u_deg.size();
    const auto size = static_cast<Eigen::Index>(2 * count);
    const int unknowns = unknowns_of(options);
    const PixelKernel& kernel = pixel_kernel();
    PixelKernelOptions o = options;
    const double sigma = options.sigma_h_deg;
    const double prior = 1 / std::max(1e-12, sigma * sigma);
    Calibration found;
    found.offset_deg.assign(count, glm::dvec2(0));
    found.sigma_h_deg = sigma;
    const std::vector<float> u0 = lights.u_deg, v0 = lights.v_deg;
    for (int round = 0; round < rounds; ++round) {
        const PixelLights view = lights.view();
        std::vector<Matrix> a(parts, Matrix::Zero(size, size));
        std::vector<Vector> g(parts, Vector::Zero(size));
        std::vector<std::size_t> good(parts, 0);
        parallel_for(
            parts, 1,
            [&](std::size_t part, std::size_t) {
                std::vector<float> scratch(2 * count * block_pixels),
                    residual(count * block_pixels);
                std::vector<float> by_unknown(max_unknowns * count * block_pixels);
                PixelBlock block;
                const std::size_t first = part * samples.blocks / parts;
                const std::size_t end = (part + 1) * samples.blocks / parts;
                for (std::size_t b = first; b < end; ++b) {
                    const PixelSamples pixels = samples.block(b, count);
                    kernel.fit(view, pixels, o, scratch.data(), block);
                    kernel.slopes(view, pixels, o, block, {residual.data(), by_unknown.data()});
                    for (std::size_t lane = 0; lane < block_pixels; ++lane) {
                        if ((pixel_result(block, lane, lights, o).flags & unusable_flags) != 0)
                            continue;
                        const Eliminated e = eliminate(residual, by_unknown, count, unknowns, lane);
                        if (!e.usable) continue;
                        ++good[part];
                        add(e, a[part], g[part]);
                    }
                }
            },
            threads);
        found.pixels = 0;
        for (const std::size_t n : good) found.pixels += n;
        Matrix normal = Matrix::Identity(size, size) * prior;
        Vector gradient = Vector::Zero(size);
        for (std::size_t part = 0; part < parts; ++part) {
            normal += a[part];
            gradient += g[part];
        }
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<Eigen::Index>(2 * i);
            gradient(at) += prior * found.offset_deg[i].x;
            gradient(at + 1) += prior * found.offset_deg[i].y;
        }
        const auto factor = normal.llt();
        const Vector step = -factor.solve(gradient);
        const Matrix covariance = factor.solve(Matrix::Identity(size, size));
        found.rms_deg = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<Eigen::Index>(2 * i);
            glm::dvec2 move(step(at), step(at + 1));
            const double length = glm::length(move), most = 2 * sigma;
            if (length > most) move *= most / length;
            found.offset_deg[i] += move;
            found.rms_deg += glm::dot(found.offset_deg[i], found.offset_deg[i]);
            lights.u_deg[i] = static_cast<float>(u0[i] + found.offset_deg[i].x);
            lights.v_deg[i] = static_cast<float>(v0[i] + found.offset_deg[i].y);
        }
        found.rms_deg = std::sqrt(found.rms_deg / static_cast<double>(count));
        const Remaining still = remaining(lights, normal, covariance, prior);
        found.shared = still.shared;
        // With a floor, so that no weight is without limit. Half the way first: the pixels were
        // fitted to lights that still stood wrong.
        constexpr double floor_share = 0.02;
        const double left = std::clamp(still.independent_deg, floor_share * sigma, sigma);
        o.sigma_h_deg = static_cast<float>(round == 0 ? 0.5 * (left + sigma) : left);
        found.sigma_h_deg = left;
        found.rounds = round + 1;
    }
    return found;
}

}  // namespace togishi
