#include "steel/nie.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "steel/noise.hpp"

namespace togishi {
namespace {

// Two populations: dust at the limit of the eye, and ara-nie.
struct Population {
    double cell_mm;
    float share;
};
constexpr std::array<Population, 2> populations{{{0.1, 0.7F}, {0.21, 0.3F}}};
constexpr float pi = 3.14159265F;

}  // namespace

NieSample nie_grains(double s, double y, float amount, float footprint_s, float footprint_y,
                     std::uint32_t seed) {
    NieSample out;
    if (amount <= 0.0F) return out;
    for (const Population& population : populations) {
        ++seed;
        const auto cell = static_cast<float>(population.cell_mm);
        // Grain radius .1 to .38 of the cell; mean area over the cell's area.
        constexpr float mean_area = pi * (0.38F * 0.38F + 0.38F * 0.1F + 0.1F * 0.1F) / 3.0F;
        const float chance = std::min(1.0F, amount * population.share / mean_area);
        // Beyond this footprint single grains cannot be told: their mean remains.
        const float blend = smooth_step(0.7F, 1.6F, std::max(footprint_s, footprint_y) / cell);
        const float mean = chance * mean_area;
        out.cover += blend * mean;
        out.ln_mu += blend * mean * -0.04F;
        if (blend >= 1.0F) continue;
        const double x = s / population.cell_mm;
        const double z = y / population.cell_mm;
        const auto ix = static_cast<std::int32_t>(std::floor(x));
        const auto iz = static_cast<std::int32_t>(std::floor(z));
        for (std::int32_t j = -1; j <= 1; ++j) {
            for (std::int32_t i = -1; i <= 1; ++i) {
                const std::uint32_t h = hash_lattice(ix + i, iz + j, seed);
                if (unit_from_hash(h) >= chance) continue;
                const std::uint32_t h2 = hash_lattice(ix + i, iz + j, seed ^ 0x5BD1E995U);
                const float cx = static_cast<float>(ix + i) + unit_from_hash(h2 << 12);
                const float cz = static_cast<float>(iz + j) + unit_from_hash(h2);
                const float radius = 0.1F + 0.28F * unit_from_hash(h * 0x9E3779B1U);
                // A soft disc, widened by the footprint and dimmed so that its area stays.
                const float sx2 =
                    radius * radius * 0.5F + footprint_s * footprint_s / (12.0F * cell * cell);
                const float sz2 =
                    radius * radius * 0.5F + footprint_y * footprint_y / (12.0F * cell * cell);
                const auto dx = static_cast<float>(x) - cx;
                const auto dz = static_cast<float>(z) - cz;
                const float peak = radius * radius * 0.5F / std::sqrt(sx2 * sz2);
                const float part =
                    (1.0F - blend) * peak * std::exp(-0.5F * (dx * dx / sx2 + dz * dz / sz2));
                out.cover += part;
                // Each grain's own facets: some glint nearer the mirror direction.
                out.ln_mu += part * (0.14F - 0.36F * unit_from_hash(h2 * 0x85EBCA77U));
            }
        }
    }
    out.cover = std::min(out.cover, 1.0F);
    out.ln_mu = std::clamp(out.ln_mu, -0.6F, 0.3F);
    return out;
}

}  // namespace togishi
