#include "capture/self_calibration.hpp"

#include <algorithm>
#include <array>
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
    Matrix covariance;     // of the pixel's unknowns
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
    e.covariance = normal.llt().solve(Matrix::Identity(unknowns, unknowns));
    if (!e.covariance.allFinite()) return e;
    const Vector left = r - j * (e.covariance * (j.transpose() * r));
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
    e.explained = e.of_unknowns * e.covariance;
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

// How far a pixel's tilt, widths and axes move with the lights' remaining error: variances.
struct Moved {
    double turn2 = 0, stretch2 = 0, shear2 = 0;
};

// `independent`: variance that the pixels' own weights already count.
Moved moved(const Eliminated& e, double e1, double e2, const Matrix& light_covariance,
            double independent) {
    const auto n = static_cast<Eigen::Index>(e.lit.size());
    // dx/dlight = covariance J' (slope over the light), with the sign of the normal equations.
    Matrix by_light(e.covariance.rows(), 2 * n), own(2 * n, 2 * n);
    for (Eigen::Index k = 0; k < n; ++k) {
        by_light.col(2 * k) = e.explained.row(k).transpose() * e.of_unknowns(k, tilt_u);
        by_light.col(2 * k + 1) = e.explained.row(k).transpose() * e.of_unknowns(k, tilt_v);
        for (Eigen::Index m = 0; m < n; ++m) {
            own.block(2 * k, 2 * m, 2, 2) =
                light_covariance.block(2 * e.lit[static_cast<std::size_t>(k)],
                                       2 * e.lit[static_cast<std::size_t>(m)], 2, 2);
        }
    }
    own.diagonal().array() -= independent;
    const Matrix x = by_light * own * by_light.transpose();
    const double r = std::max(std::hypot(e1, e2), 1e-3), c = e1 / r, sn = e2 / r;
    const double along = c * c * x(shape_e1, shape_e1) + 2 * c * sn * x(shape_e1, shape_e2) +
                         sn * sn * x(shape_e2, shape_e2);
    const double across = sn * sn * x(shape_e1, shape_e1) - 2 * c * sn * x(shape_e1, shape_e2) +
                          c * c * x(shape_e2, shape_e2);
    // What rotation and shear of this size together do: see pixel_result.cpp.
    const double coth = 1 / std::tanh(2 * r);
    return {0.5 * (x(tilt_u, tilt_u) + x(tilt_v, tilt_v)), x(ln_mu_deg, ln_mu_deg) + along,
            across / (2 * r * r * (1 + coth * coth))};
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
    Matrix covariance = Matrix::Identity(size, size) * sigma * sigma;
    // The last round moves nothing: it asks what the lights' remaining error does to the pixels.
    for (int round = 0; round <= rounds; ++round) {
        const bool last = round == rounds;
        const double sigma_left = found.sigma_h_deg;
        const PixelLights view = lights.view();
        std::vector<Matrix> a(parts, Matrix::Zero(last ? 0 : size, last ? 0 : size));
        std::vector<Vector> g(parts, Vector::Zero(size));
        std::vector<std::size_t> good(parts, 0);
        std::vector<Moved> sum(parts);
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
                        if (last) {
                            const Moved m = moved(e, double{block.x[shape_e1][lane]},
                                                  double{block.x[shape_e2][lane]}, covariance,
                                                  sigma_left * sigma_left);
                            sum[part].turn2 += m.turn2;
                            sum[part].stretch2 += m.stretch2;
                            sum[part].shear2 += m.shear2;
                        } else {
                            add(e, a[part], g[part]);
                        }
                    }
                }
            },
            threads);
        found.pixels = 0;
        for (const std::size_t n : good) found.pixels += n;
        if (last) {
            Moved all;
            for (const Moved& m : sum) {
                all.turn2 += m.turn2;
                all.stretch2 += m.stretch2;
                all.shear2 += m.shear2;
            }
            const auto n = static_cast<double>(std::max<std::size_t>(1, found.pixels));
            found.shared = {std::sqrt(std::max(0.0, all.turn2 / n)),
                            std::sqrt(std::max(0.0, all.stretch2 / n)),
                            std::sqrt(std::max(0.0, all.shear2 / n))};
            break;
        }
        Matrix normal = Matrix::Identity(size, size) * prior;
        Vector gradient = Vector::Zero(size);
        for (std::size_t part = 0; part < parts; ++part) {
            normal += a[part];
            gradient += g[part];
        }
        double independent = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<Eigen::Index>(2 * i);
            gradient(at) += prior * found.offset_deg[i].x;
            gradient(at + 1) += prior * found.offset_deg[i].y;
            independent += 0.5 / normal(at, at) + 0.5 / normal(at + 1, at + 1);
        }
        const auto factor = normal.llt();
        const Vector step = -factor.solve(gradient);
        covariance = factor.solve(Matrix::Identity(size, size));
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
        // What one light's error is apart from its neighbours': for the weights, with a floor for
        // what two numbers per light cannot say. Half the way first: the pixels were fitted to
        // lights that still stood wrong.
        constexpr double floor_share = 0.1;
        const double left = std::clamp(std::sqrt(independent / static_cast<double>(count)),
                                       floor_share * sigma, sigma);
        o.sigma_h_deg = static_cast<float>(round == 0 ? 0.5 * (left + sigma) : left);
        found.sigma_h_deg = left;
        found.rounds = round + 1;
    }
    return found;
}

}  // namespace togishi
