// Photographs of a surface whose maps are known, by the reference evaluation.
//
// Every pixel's light is summed over the source in double precision with cpp_core/reference: the
// source is divided until no lobe of the pixel sees a piece as more than a share of its width, and
// each piece gets 3 x 3 Gauss-Legendre nodes. Then the picture is blurred, exposed, given shot and
// read noise, cut off at full scale and rounded to the camera's bits. Neither a shader nor a
// formula of a fit takes part.
#pragma once
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "brdf/property_maps.hpp"
#include "capture/camera_surface.hpp"
#include "capture/diffuse_source.hpp"
#include "reference/reference.hpp"

namespace togishi {

/// A point light: far away in one direction, or near at a place.
struct PointLight {
    glm::dvec3 direction{0, 1, 0};  ///< unit, from the surface to the light
    bool near = false;
    glm::dvec3 position_mm{0};
    /// Irradiance on a surface facing it, where far away; near: at `reference_mm` from it, falling
    /// with the square of the distance.
    double intensity = 1;
    double reference_mm = 1000;
};

using Illumination = std::variant<DiffuseSource, PointLight>;

/// What a pixel shows of its surface: a value per channel of MapChannel, absent ones 0.
struct PixelTruth {
    std::vector<float> values;  ///< (pixels, map_channel_count)
    [[nodiscard]] float at(std::size_t pixel, MapChannel c) const {
        return values[pixel * map_channel_count + static_cast<std::size_t>(c)];
    }
};

/// The maps' values where each pixel looks: bilinear, the part by the nearest texel. Pixels that
/// see nothing: 0.
[[nodiscard]] PixelTruth maps_in_view(const SurfaceView& view, const PropertyMaps& maps);

struct RadianceOptions {
    std::string metal;
    std::string light = "D65";
    StoredLobe hadori{1.1, 0, 0};  ///< the material's lobe of the hadori, which maps do not hold
    /// Largest piece of a source over a lobe's narrow half width; halving it shows what it costs.
    double piece = 1.8;
    unsigned threads = 0;
};

/// Luminance Y of each pixel, relative to the source's radiance (a point light's irradiance) on
/// its own scale, without blur and noise; 0 where nothing is seen. A property map's weights are
/// normalised. Throws InputError.
[[nodiscard]] std::vector<double> reference_radiance(const SurfaceView& view,
                                                     const PixelTruth& truth,
                                                     const Illumination& illumination,
                                                     const RadianceOptions& options);

/// Radiance of a white, perfectly diffusing card in the surface's place.
[[nodiscard]] std::vector<double> card_radiance(const SurfaceView& view,
                                                const Illumination& illumination);

/// A blade before an even light, the ground 1 and the blade 0, three by three rays a pixel: for
/// `expose`, as a picture of the outline.
[[nodiscard]] std::vector<double> picture_against_light(const BladeMesh& mesh,
                                                        const Camera& camera);

struct SensorOptions {
    double scale = 1;       ///< picture value per radiance; full scale is 1
    double blur_px = 0.6;   ///< standard deviation of the point spread function
    double snr = 100;       ///< signal over shot noise at full scale; 0: no shot noise
    double read = 3e-4;     ///< standard deviation of the read noise, share of full scale
    double dark = 0;        ///< offset of every pixel, share of full scale
    double vignetting = 0;  ///< loss of light in the picture's corners, share
    int bits = 12;          ///< 0: not rounded
    std::uint64_t seed = 1;
};

/// What the camera makes of it: values in [0, 1]. Pixels differ in their noise, whatever the number
/// of threads, and so do photographs with different `frame`.
[[nodiscard]] std::vector<float> expose(const std::vector<double>& radiance, int width, int height,
                                        const SensorOptions& options, std::uint64_t frame);

/// Gaussian blur within the picture, edges repeated.
void blur_picture(std::vector<double>& picture, int width, int height, double sigma_px);

/// Maps of a plate for tests: the hamon's share rises along u from 0 to 1 and back in steps and
/// slopes, half widths vary along v and in patches by `variation` (standard deviation of ln mu).
[[nodiscard]] PropertyMaps plate_maps(std::size_t width, std::size_t height, double mu_ji_deg,
                                      double mu_ha_deg, double variation, std::uint64_t seed);

}  // namespace togishi
