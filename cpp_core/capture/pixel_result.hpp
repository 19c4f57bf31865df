// A fitted pixel in the terms of the maps: normal, stored lobe, weights, and what each is worth.
#pragma once
#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "capture/light_stack.hpp"
#include "capture/pixel_kernel.hpp"

namespace togishi {

/// Why a pixel is not to be relied on; several may hold.
enum PixelFlag : std::uint8_t {
    flag_uncertain = 1,  ///< sigma of ln mu above 0.15
    flag_misfit = 2,     ///< reduced chi^2 above 9
    flag_few = 4,        ///< fewer than 6 unclipped samples above 4 sigma in the lobe
    flag_bounded = 8,    ///< an unknown at its bound
    flag_rejected = 16,  ///< more than 15 % of the samples rejected as shadowed or outlying
    flag_inferred = 32,  ///< lobe taken from the prior that was asked for
    flag_missing = 64    ///< NaN or no samples
};

/// Flags whose pixels say nothing about the lobe by themselves.
inline constexpr int unusable_flags =
    flag_uncertain | flag_misfit | flag_few | flag_bounded | flag_rejected | flag_missing;

struct PixelResult {
    glm::vec3 normal;         ///< unit length; x right, y up, z towards the camera
    float ln_mu_deg, e1, e2;  ///< stored lobe, in the frame tangent_frame(normal, x)
    float weight;             ///< chi or beta as measured, per unit of irradiance
    float diffuse;            ///< albedo of the diffuse part
    float pedestal, haze;     ///< signal; share of the second lobe
    float sigma_ln_mu;        ///< of the less certain half width
    float sigma_ln_mu_t, sigma_ln_mu_b, sigma_rho_deg, sigma_normal_deg, sigma_ln_weight;
    float chi2_reduced;
    float used, clipped, rejected;  ///< samples
    int flags;
};

inline constexpr int shared_unknowns = 6;

/// What all pixels of a stack share and none can see for itself: after self-calibration the half
/// vectors h = (u, v) about `normal` may still be off by shift + L h, which every pixel's tilt and
/// shape take up without a residual.
struct SharedError {
    glm::dvec3 normal{0, 0, 1}, tangent{1, 0, 0}, bitangent{0, 1, 0};
    /// Of (shift_u, shift_v in degrees, L_uu, L_uv, L_vu, L_vv), row by row.
    std::array<double, shared_unknowns * shared_unknowns> covariance{};
};

/// Lane `lane` of a fitted block, fitted about `region`. unknowns: of the fit, 7 to 9.
[[nodiscard]] PixelResult pixel_result(const PixelBlock& block, std::size_t lane,
                                       const RegionLights& region,
                                       const PixelKernelOptions& options,
                                       const SharedError& shared = {});

}  // namespace togishi
