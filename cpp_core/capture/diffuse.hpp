// Where a blade is ji and where hamon, and how rough, from photographs under diffuse light.
//
// A pixel's radiance is C = (1 - w) C_f(mu_ji) + w C_t(mu_ha), each integrated over the source at
// the pixel's own geometry (capture/diffuse_response.hpp); w is what the two share.
//
// | photographs | unknowns | how |
// |-------------|----------|-----|
// | one         | w        | the lobes are those of the material; how far they may vary over the
// blade widens sigma | | two or more | w, mu    | ln mu of both lobes beside w, each with the
// material's as a prior; a half width counts as measured only where the photographs alone determine
// it | | no geometry | w        | two reference areas, all ji and all hamon: w by the straight line
// between their radiances |
//
// Where the blade was polished with hadori it is a third lobe: C = (1 - w) ((1 - h) C_ji + h
// C_hadori) + w C_ha. Two photographs or more; its half width is the material's within the spread.
//
// Nothing is invented: a pixel that cannot be told has a mask that says why, and still the prior's
// value, so that a map has no holes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "brdf/material.hpp"
#include "brdf/property_maps.hpp"
#include "capture/camera_surface.hpp"
#include "capture/diffuse_response.hpp"

namespace togishi {

/// Why a pixel's value is not to be trusted: bits. 0: all measured.
enum DiffuseMask : std::uint8_t {
    mask_unseen = 1,       ///< no surface, no light, or a part that was not asked for
    mask_clipped = 2,      ///< at full scale in one photograph or more
    mask_flat_w = 4,       ///< ji and hamon (or hadori) look alike here: shares unknown
    mask_flat_mu = 8,      ///< radiance does not tell the leading lobe's half width
    mask_ambiguous = 16,   ///< two different answers fit the photographs
    mask_misfit = 32,      ///< nothing fits: dirt, a scratch, wrong geometry
    mask_not_finite = 64,  ///< a picture held NaN or infinity here
    mask_border = 128      ///< beside the outline or another part, whose light is blurred into it
};
inline constexpr std::array<std::pair<std::uint8_t, std::string_view>, 8> diffuse_mask_names{
    {{mask_unseen, "unseen"},
     {mask_clipped, "clipped"},
     {mask_flat_w, "flat_w"},
     {mask_flat_mu, "flat_mu"},
     {mask_ambiguous, "ambiguous"},
     {mask_misfit, "misfit"},
     {mask_not_finite, "not_finite"},
     {mask_border, "border"}}};
/// What makes w, and what makes mu, untold.
inline constexpr std::uint8_t mask_no_w = mask_unseen | mask_clipped | mask_flat_w |
                                          mask_ambiguous | mask_misfit | mask_not_finite |
                                          mask_border;
inline constexpr std::uint8_t mask_no_mu = mask_no_w | mask_flat_mu;

/// One photograph, already linear, dark and flat frames taken out: radiance over the source's own.
struct DiffusePhotograph {
    std::vector<float> radiance;  ///< one a pixel
    std::vector<float> sigma;     ///< its standard deviation, > 0
    std::vector<std::uint8_t> clipped;
    DiffuseSource source;
};

struct DiffuseOptions {
    std::string metal{"iron_johnson_christy"};
    std::string light = "D65";
    MaterialLobe ji{0.95, 0.7, 90, -1};
    MaterialLobe ha{5.3, 4.7, 90, -1};
    std::optional<MaterialLobe> hadori;  ///< a third lobe
    /// Standard deviation of ln mu over the blade: the prior of a fit, or of the nuisance where the
    /// lobes are taken as known.
    double spread = 0.15;
    double known_spread = 0.1;
    double model_error = 0.004;     ///< of the full scale of a radiance: geometry, the integral
    double max_sigma_w = 0.1;       ///< above it w is masked
    double max_sigma_ln_mu = 0.12;  ///< above it, by the photographs alone, mu is masked
    double border_px = 1;           ///< pixels this near to the outline or another part are masked
    double max_misfit = 9;          ///< chi squared per photograph above which nothing fits
    unsigned threads = 0;
};

struct DiffuseResult {
    std::size_t width = 0, height = 0;
    /// Row-major from the upper left.
    std::vector<float> w, sigma_w, ji_ln_mu_deg, sigma_ji, ha_ln_mu_deg, sigma_ha, chi2;
    std::vector<float> h, sigma_h;  ///< hadori's share of the rest; 0 without options.hadori
    std::vector<std::uint8_t> mask;
    bool mu_measured = false;  ///< two photographs or more
    std::string calibration;   ///< for the map's record
    std::vector<std::string> notes;

    /// Pixels that are seen, and how many of them have any of these bits.
    [[nodiscard]] std::size_t seen() const;
    [[nodiscard]] std::size_t masked(std::uint8_t bits) const;
};

/// Pixels that are evaluated, 1 or 0: all that is seen; of a blade ji and ha, since shinogi-ji,
/// mune and kissaki are polished to lobes of their own.
[[nodiscard]] std::vector<std::uint8_t> evaluated_pixels(const SurfaceView& view);

/// Called with the share done; false cancels.
using DiffuseProgress = std::function<bool(double)>;
struct DiffuseCancelled {};

/// Throws InputError: no photograph, sizes that do not agree, options out of range, and a set-up
/// that can tell neither w nor mu at any pixel (an even hemisphere). DiffuseCancelled.
[[nodiscard]] DiffuseResult solve_diffuse(const SurfaceView& view,
                                          const std::vector<DiffusePhotograph>& photographs,
                                          const DiffuseOptions& options,
                                          const DiffuseProgress& progress = {});

/// An area of the picture whose surface is known.
struct ReferenceArea {
    int x = 0, y = 0, width = 0, height = 0;  ///< pixels, from the upper left
    bool ha = false;                          ///< all hamon, else all ji
    double mu_deg = 0;                        ///< its half width, from a fit: for the record
};

/// With geometry but of unknown exposure: what a photograph's radiances are to be multiplied by, so
/// that the reference areas show what the model says of their lobes (mu_deg, or the material's).
/// Throws InputError as solve_by_references, for areas that are clipped or not seen.
[[nodiscard]] double reference_gain(const SurfaceView& view, const DiffusePhotograph& photograph,
                                    const std::vector<ReferenceArea>& references,
                                    const DiffuseOptions& options);

/// Without geometry: w by the line between the mean radiances of two reference areas. The radiances
/// may have any scale. Throws InputError: not one of each kind, an area outside the picture, two
/// areas that look alike (nearer than 5 standard deviations of a pixel).
[[nodiscard]] DiffuseResult solve_by_references(std::size_t width, std::size_t height,
                                                const std::vector<DiffusePhotograph>& photographs,
                                                const std::vector<ReferenceArea>& references,
                                                const DiffuseOptions& options);

/// Standard deviation of a picture's noise against its value, from the picture itself: variance =
/// gain value + read^2, by what neighbours differ; texture counts as noise.
struct PictureNoise {
    double gain = 0;
    double read = 0;
    double quantum = 0;  ///< one level of the camera's bits
    [[nodiscard]] double sigma(double value) const;
};
[[nodiscard]] PictureNoise estimate_noise(const std::vector<float>& picture, std::size_t width,
                                          std::size_t height);

/// The map of a result, in the picture's own chart (v = 1 its upper border): both lobes, w, h = 0
/// and the part by w.
[[nodiscard]] PropertyMaps diffuse_maps(const DiffuseResult& result, const DiffuseOptions& options);

}  // namespace togishi
