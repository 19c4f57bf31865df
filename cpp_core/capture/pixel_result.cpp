#include "capture/pixel_result.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;

constexpr std::size_t packed(int i, int j) {
    const int at = i * max_unknowns - i * (i - 1) / 2 + (j - i);
    return static_cast<std::size_t>(at);
}

using SharedSlope = std::array<double, shared_unknowns>;

double variance(const SharedError& shared, const SharedSlope& slope) {
    double sum = 0;
    for (std::size_t a = 0; a < slope.size(); ++a)
        for (std::size_t b = 0; b < slope.size(); ++b)
            sum += slope[a] * slope[b] * shared.covariance[a * slope.size() + b];
    return std::max(0.0, sum);
}

// What a pixel inherits of the lights' common error: variances.
struct Inherited {
    double normal_deg2 = 0;  // of both components
    double ln_mu_t = 0, ln_mu_b = 0, rho_rad2 = 0;
};

// A map 1 + L of the half vectors makes of the ellipse S = mu_t^2 tt' + mu_b^2 bb' the ellipse
// S + LS + SL'. Its axes grow by L_tt and L_bb, and turn by (mu_b^2 L_tb + mu_t^2 L_bt)/(mu_t^2 -
// mu_b^2): a rotation by itself, a shear by coth(2r) times itself.
Inherited inherited(const SharedError& shared, const glm::dvec3& normal, double cos_2rho,
                    double sin_2rho, double shape) {
    Inherited v;
    if (!(shared.covariance[0] > 0)) return v;
    const double z = glm::dot(normal, shared.normal);
    const double x = glm::dot(normal, shared.tangent), y = glm::dot(normal, shared.bitangent);
    const double length = std::hypot(x, y);
    const double deg = length > 0 ? std::atan2(length, z) / (length * rad_per_deg) : 0;
    v.normal_deg2 = variance(shared, {1, 0, x * deg, y * deg, 0, 0}) +
                    variance(shared, {0, 1, 0, 0, x * deg, y * deg});
    // cos^2, sin^2 and their product.
    const double cc = 0.5 * (1 + cos_2rho), ss = 0.5 * (1 - cos_2rho), cs = 0.5 * sin_2rho;
    v.ln_mu_t = variance(shared, {0, 0, cc, cs, cs, ss});
    v.ln_mu_b = variance(shared, {0, 0, ss, -cs, -cs, cc});
    const double k = std::exp(4 * std::max(shape, 1e-3));  // mu_t^2/mu_b^2
    const double tb = 1 / (k - 1), bt = k * tb;
    v.rho_rad2 = variance(
        shared, {0, 0, -cs * (tb + bt), tb * cc - bt * ss, bt * cc - tb * ss, cs * (tb + bt)});
    return v;
}

}  // namespace

PixelResult pixel_result(const PixelBlock& block, std::size_t lane, const RegionLights& region,
                         const PixelKernelOptions& o, const SharedError& shared) {
    const auto x = [&](std::size_t a) { return double{block.x[a][lane]}; };
    const auto cov = [&](int a, int b) { return double{block.covariance[packed(a, b)][lane]}; };
    PixelResult r{};
    const double p = x(tilt_u), q = x(tilt_v), phi = std::hypot(p, q) * rad_per_deg;
    // Along the geodesic from the region's normal, and the region's tangent carried with it.
    const glm::dvec3 along = phi > 0
                                 ? (p * region.tangent + q * region.bitangent) * (rad_per_deg / phi)
                                 : region.tangent;
    const glm::dvec3 normal = glm::normalize(std::cos(phi) * region.normal + std::sin(phi) * along);
    const double share = glm::dot(region.tangent, along);
    const glm::dvec3 carried =
        region.tangent + share * ((std::cos(phi) - 1) * along - std::sin(phi) * region.normal);
    const auto frame = f64::tangent_frame(normal, glm::dvec3(1, 0, 0));
    // Twice the angle from the pixel's own frame to the carried one.
    const double along_t = glm::dot(carried, frame.tangent);
    const double along_b = glm::dot(carried, frame.bitangent);
    const double length2 = along_t * along_t + along_b * along_b;
    const double cos_turn = (along_t * along_t - along_b * along_b) / length2;
    const double sin_turn = 2 * along_t * along_b / length2;
    const double e1 = x(shape_e1), e2 = x(shape_e2), shape = std::hypot(e1, e2);
    r.normal = glm::vec3(normal);
    r.ln_mu_deg = static_cast<float>(x(ln_mu_deg));
    r.e1 = static_cast<float>(e1 * cos_turn - e2 * sin_turn);
    r.e2 = static_cast<float>(e1 * sin_turn + e2 * cos_turn);
    r.weight = std::exp(block.x[ln_chi][lane]);
    r.diffuse = block.x[diffuse][lane];
    const std::size_t next = 7;
    r.pedestal = o.pedestal ? block.x[next][lane] : 0.0F;
    r.haze = o.haze ? block.x[o.pedestal ? next + 1 : next][lane] : 0.0F;

    r.used = block.used[lane];
    r.clipped = block.clipped[lane];
    r.rejected = block.rejected[lane];
    const int unknowns = unknowns_of(o);
    const double freedom = std::max(1.0, double{r.used} - unknowns);
    r.chi2_reduced = static_cast<float>(block.chi2[lane] / freedom);

    // Along and across the shape's own direction; a round lobe has none, and takes the larger.
    const double c = shape > 1e-6 ? e1 / shape : 1, s = shape > 1e-6 ? e2 / shape : 0;
    const double rr = c * c * cov(3, 3) + 2 * c * s * cov(3, 4) + s * s * cov(4, 4);
    const double tt = s * s * cov(3, 3) - 2 * c * s * cov(3, 4) + c * c * cov(4, 4);
    const double sr = c * cov(2, 3) + s * cov(2, 4);
    const auto root = [](double v) { return static_cast<float>(std::sqrt(std::max(v, 0.0))); };
    // What the fit cannot explain widens what it claims.
    const double widen = std::max(1.0, double{r.chi2_reduced});
    const Inherited common = inherited(shared, normal, c, s, shape);
    r.sigma_ln_mu_t = root(widen * (cov(2, 2) + rr + 2 * sr) + common.ln_mu_t);
    r.sigma_ln_mu_b = root(widen * (cov(2, 2) + rr - 2 * sr) + common.ln_mu_b);
    r.sigma_ln_mu = std::max(r.sigma_ln_mu_t, r.sigma_ln_mu_b);
    const double turn_variance =
        0.25 * widen * std::max(tt, 0.0) / std::max(shape * shape, 1e-12) + common.rho_rad2;
    r.sigma_rho_deg = static_cast<float>(std::min(90.0, std::sqrt(turn_variance) / rad_per_deg));
    r.sigma_normal_deg = root(widen * (cov(0, 0) + cov(1, 1)) + common.normal_deg2);
    r.sigma_ln_weight = root(widen * cov(5, 5));

    constexpr float most_sigma = 0.15F, most_chi2 = 9, least_samples = 6, most_rejected = 0.15F;
    if (!(r.sigma_ln_mu <= most_sigma)) r.flags |= flag_uncertain;
    if (!(r.chi2_reduced <= most_chi2)) r.flags |= flag_misfit;
    if (!(block.lobe_samples[lane] >= least_samples)) r.flags |= flag_few;
    // A lobe wider than the lights reach is the diffuse part's slope, or a narrow one that no light
    // hit.
    const bool beyond =
        std::exp(x(ln_mu_deg) + shape) > RegionLights::widest_of(region.reach_deg) ||
        std::hypot(p, q) > region.reach_deg;
    if (block.bounded[lane] > 0 || beyond) r.flags |= flag_bounded;
    if (r.rejected > most_rejected * (r.used + r.rejected)) r.flags |= flag_rejected;
    if (!(std::isfinite(r.ln_mu_deg) && std::isfinite(r.weight) && std::isfinite(r.e1) &&
          std::isfinite(r.e2) && std::isfinite(r.sigma_ln_mu)) ||
        r.used <= 0) {
        r.flags |= flag_missing;
    }
    if (o.prior_weight[0] > 0) r.flags |= flag_inferred;
    return r;
}

}  // namespace togishi
