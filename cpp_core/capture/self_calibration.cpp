#include "capture/self_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.hpp"
#include "capture/pixel_result.hpp"

namespace togishi {
namespace {

// Sums of one light over pixels: J'J (3) and J'r (2).
using Sums = std::array<double, 5>;

}  // namespace

Calibration self_calibrate(RegionLights& lights, const SampleBlocks& samples,
                           const PixelKernelOptions& options, int rounds, unsigned threads) {
    const std::size_t count = lights.u_deg.size();
    const PixelKernel& kernel = pixel_kernel();
    PixelKernelOptions o = options;
    const double prior = 1 / std::max(1e-12, double{options.sigma_h_deg} * options.sigma_h_deg);
    Calibration found;
    found.offset_deg.assign(count, glm::dvec2(0));
    const std::vector<float> u0 = lights.u_deg, v0 = lights.v_deg;
    // Sums per block, added in the blocks' order: the same bits for any number of threads.
    std::vector<Sums> sums(samples.blocks * count);
    std::vector<std::size_t> good(samples.blocks);
    double left = options.sigma_h_deg;
    for (int round = 0; round < rounds; ++round) {
        const PixelLights view = lights.view();
        parallel_for(
            samples.blocks, 4,
            [&](std::size_t begin, std::size_t end) {
                std::vector<float> scratch(2 * count * block_pixels);
                std::vector<float> residual(count * block_pixels), by_u(residual), by_v(residual);
                PixelBlock block;
                for (std::size_t b = begin; b < end; ++b) {
                    const PixelSamples pixels = samples.block(b, count);
                    kernel.fit(view, pixels, o, scratch.data(), block);
                    kernel.slopes(view, pixels, o, block,
                                  {residual.data(), by_u.data(), by_v.data()});
                    std::array<bool, block_pixels> usable{};
                    good[b] = 0;
                    for (std::size_t lane = 0; lane < block_pixels; ++lane) {
                        const int flags = pixel_result(block, lane, lights, o).flags;
                        usable[lane] = (flags & unusable_flags) == 0;
                        good[b] += usable[lane] ? 1 : 0;
                    }
                    for (std::size_t i = 0; i < count; ++i) {
                        Sums s{};
                        for (std::size_t lane = 0; lane < block_pixels; ++lane) {
                            const std::size_t at = i * block_pixels + lane;
                            const double r = residual[at], u = by_u[at], v = by_v[at];
                            constexpr double outlying = 5;
                            if (!usable[lane] || !(std::abs(r) < outlying)) continue;
                            s[0] += u * u;
                            s[1] += u * v;
                            s[2] += v * v;
                            s[3] += u * r;
                            s[4] += v * r;
                        }
                        sums[b * count + i] = s;
                    }
                }
            },
            threads);
        found.pixels = 0;
        for (const std::size_t n : good) found.pixels += n;
        double variance = 0;
        for (std::size_t i = 0; i < count; ++i) {
            Sums s{};
            for (std::size_t b = 0; b < samples.blocks; ++b)
                for (std::size_t k = 0; k < s.size(); ++k) s[k] += sums[b * count + i][k];
            const double xx = s[0] + prior, yy = s[2] + prior, xy = s[1];
            const glm::dvec2 g(s[3] + prior * found.offset_deg[i].x,
                               s[4] + prior * found.offset_deg[i].y);
            const double det = xx * yy - xy * xy;
            glm::dvec2 step(-(yy * g.x - xy * g.y) / det, -(xx * g.y - xy * g.x) / det);
            const double length = glm::length(step), most = 2 * options.sigma_h_deg;
            if (length > most) step *= most / length;
            found.offset_deg[i] += step;
            variance += 0.5 * (xx + yy) / det;
        }
        // A common turn of all half vectors is the normals' to explain.
        glm::dvec2 mean(0);
        for (const glm::dvec2& d : found.offset_deg) mean += d / static_cast<double>(count);
        found.rms_deg = 0;
        for (std::size_t i = 0; i < count; ++i) {
            found.offset_deg[i] -= mean;
            found.rms_deg += glm::dot(found.offset_deg[i], found.offset_deg[i]);
            lights.u_deg[i] = static_cast<float>(u0[i] + found.offset_deg[i].x);
            lights.v_deg[i] = static_cast<float>(v0[i] + found.offset_deg[i].y);
        }
        found.rms_deg = std::sqrt(found.rms_deg / static_cast<double>(count));
        // The posterior's own width, and a floor for what two numbers per light cannot say.
        left = std::sqrt(variance / static_cast<double>(count));
        constexpr double floor_share = 0.1;
        left = std::clamp(left, floor_share * options.sigma_h_deg, double{options.sigma_h_deg});
        o.sigma_h_deg = static_cast<float>(round == 0 ? 0.5 * (left + options.sigma_h_deg) : left);
        found.rounds = round + 1;
    }
    found.sigma_h_deg = left;
    return found;
}

}  // namespace togishi
