// The truth that everything else is measured against: the model's formulas in double precision,
// Fresnel at every wavelength for every light, and a plain sum. No tables, no approximation,
// nothing kept between points.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace togishi {

/// One value for all points, or one for each.
template <class T>
struct PerPoint {
    std::span<const T> values;  ///< size 1 or the number of points
    [[nodiscard]] const T& operator[](std::size_t point) const {
        return values[values.size() == 1 ? 0 : point];
    }
};

/// A lobe as stored: ln_mu_deg, e1, e2 (shaders/shared/lobe.glsl).
using StoredLobe = std::array<double, 3>;

enum class ReferenceGrid {
    samples_61,  ///< 400 to 700 nm, 5 nm, with the white correction: the model as defined
    full_1nm     ///< 360 to 830 nm, 1 nm: what the 61 samples are judged by
};

/// P points under K lights. Vectors need not be unit length.
struct ReferenceScene {
    std::string metal;
    std::vector<std::string> lights;              ///< spectra, as find_light takes them
    std::span<const std::int32_t> light_of;       ///< (K) index into lights
    std::span<const glm::dvec3> normal;           ///< (P)
    std::span<const glm::dvec3> tangent;          ///< (P)
    std::span<const glm::dvec3> view;             ///< (P) from the surface to the eye
    std::span<const glm::dvec3> light_direction;  ///< (P, K) from the surface to the light
    std::span<const double>
        irradiance;  ///< (P, K) on a surface facing the light, spectrum at Y = 1
    PerPoint<StoredLobe> lobe_ji, lobe_hadori, lobe_ha;
    PerPoint<double> w, h;  ///< shares of the hamon and, of the rest, of the hadori
    double chi = -1;        ///< negative weights: normalised
    double beta_hadori = -1;
    double beta_ha = -1;
    std::optional<std::pair<std::string, double>>
        world;  ///< spectrum and radiance of a uniform room
    std::string observer = "cie1931_2";
    ReferenceGrid grid = ReferenceGrid::samples_61;
};

/// XYZ of each point: radiance, relative to irradiance on the lights' own scale.
///
/// The room adds F(theta_r) times its radiance, whatever the lobes: light from everywhere has no
/// lobe to show. It counts where N.V > TG_MIN_COS. Defined results as in shaders/shared: dark where
/// light or eye is at or below the horizon, where a vector is zero, NaN or infinite; NaN in lobes
/// and shares as sanitise_lobe and sanitise_share say. Irradiance that is not positive and finite
/// adds nothing. Throws InputError for unknown names, sizes that do not agree, an index out of
/// range, and a metal that was not measured over the grid. Cost: some 3 us a point and light on one
/// core (two Fresnel terms at 61 wavelengths), threads: 0 = all.
[[nodiscard]] std::vector<glm::dvec3> reference_xyz(const ReferenceScene& scene,
                                                    unsigned threads = 0);

}  // namespace togishi
