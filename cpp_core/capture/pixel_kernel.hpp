// The fit of 16 pixels side by side under many lights: what goes in and what comes out. Compiled
// once for each instruction set (pixel_kernel_*.cpp) from one source, pixel_kernel.inl, and chosen
// at run time. The same input gives the same bits, whatever stands in the neighbouring lanes; other
// instruction sets round differently (fused multiply-add).
//
// Model, with d = (u - p, v - q) in degrees, u, v the half vector's log-map about the region's
// normal:
//
//   I = gain chi (e^-E + haze e^(-E/k^2)) + diffuse rho_d + pedestal
//   E = A [C |d|^2 - K (e1 (dx^2 - dy^2) + 2 e2 dx dy)],  A = ln2 e^(-2s), C = cosh 2r, K =
//   sinh(2r)/r
//
// which is lobe_value of shaders/shared/lobe.glsl with (s, e1, e2) the stored lobe; the tests hold
// the two together.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace togishi {

inline constexpr int block_pixels = 16;
inline constexpr int max_unknowns = 9;

/// Order of the unknowns; pedestal and haze take the next free place (pedestal first).
enum Unknown : std::uint8_t { tilt_u, tilt_v, ln_mu_deg, shape_e1, shape_e2, ln_chi, diffuse };

enum class PixelEffort : std::uint8_t {
    moments,     ///< diffuse from the lower tail, moments of the half vectors
    log_linear,  ///< and weighted least squares of the logarithm
    full         ///< and reweighted Levenberg-Marquardt steps
};

struct PixelKernelOptions {
    PixelEffort effort = PixelEffort::full;
    bool pedestal = false;
    bool haze = false;
    float haze_width = 3;  ///< of the second lobe, times the first one's
    int passes = 2;
    int steps = 14;  ///< Levenberg steps a pass, at most
    /// Gaussian priors on (ln mu, e1, e2): mean and 1/sigma^2; 0: none.
    std::array<float, 3> prior_mean{}, prior_weight{};
    float noise_gain = 1e-4F;    ///< variance per signal
    float noise_floor2 = 1e-7F;  ///< variance in the dark, quantisation included
    float sigma_h_deg = 0.18F;   ///< error of a half vector, per axis
};

[[nodiscard]] constexpr int unknowns_of(const PixelKernelOptions& o) {
    return 7 + (o.pedestal ? 1 : 0) + (o.haze ? 1 : 0);
}

/// Lights as the pixels of a block see them. Arrays of `count`, or of count * 16 where each pixel
/// sees its own (near lights): stride 1 or 16.
struct PixelLights {
    int count = 0;
    int stride = 1;
    const float* u_deg = nullptr;
    const float* v_deg = nullptr;
    const float* gain = nullptr;     ///< of the lobe: irradiance, Fresnel, shadowing; 0: not lit
    const float* diffuse = nullptr;  ///< of the diffuse part
    const float* area = nullptr;     ///< (count) share of the half vectors' plane, deg^2
    float spacing_deg = 1;           ///< of half vectors near the normal
    float reach_deg = 30;            ///< of the farthest half vector
};

/// (count, 16) arrays. scale 0: no sample; > 0: variance = gain scale I + floor2 scale^2;
/// < 0: clipped, value is the least that it can have been.
struct PixelSamples {
    const float* value = nullptr;
    const float* scale = nullptr;
};

struct PixelBlock {
    using Lanes = std::array<float, block_pixels>;
    std::array<Lanes, max_unknowns> x;
    /// Upper triangle of the covariance, row by row over max_unknowns, rows of absent unknowns 0.
    std::array<Lanes, max_unknowns*(max_unknowns + 1) / 2> covariance;
    Lanes chi2;          ///< of the whitened residuals that were used
    Lanes used;          ///< samples, clipped ones that bind included
    Lanes clipped;       ///< samples that were clipped
    Lanes rejected;      ///< samples beyond 6 sigma
    Lanes lobe_samples;  ///< unclipped, lobe above 4 sigma of the photons' noise
    Lanes bounded;       ///< 1: an unknown stands at its bound
    Lanes steps;         ///< Levenberg steps taken
};

/// A fitted pixel's samples, whitened, for what pixels share: residual, (count, 16), and its slope
/// over each unknown, (unknown, count, 16). All 0 where a sample is clipped or not used. The slope
/// over a light's own half vector is minus that over the tilt.
struct PixelSlopes {
    float* residual = nullptr;
    float* by_unknown = nullptr;
};

/// `scratch`: (2 count, 16) floats.
using FitBlock = void (*)(const PixelLights&, const PixelSamples&, const PixelKernelOptions&,
                          float* scratch, PixelBlock&);
using BlockSlopes = void (*)(const PixelLights&, const PixelSamples&, const PixelKernelOptions&,
                             const PixelBlock&, const PixelSlopes&);

struct PixelKernel {
    const char* name;  ///< "baseline", "avx2"
    FitBlock fit;
    BlockSlopes slopes;
};

/// The widest that this processor runs, or the one that TOGISHI_SIMD names. Throws InputError for
/// a name that is unknown or that the processor cannot run.
[[nodiscard]] const PixelKernel& pixel_kernel();
/// "": the widest.
[[nodiscard]] const PixelKernel& pixel_kernel(const char* name);

}  // namespace togishi
