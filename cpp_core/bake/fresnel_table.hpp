// The exact 1-D table of a metal under a light: what the shaders look F times E up in.
//
// | axis | texel i of `size` holds | mapping |
// |------|-------------------------|---------|
// | 0    | linear RGB of F(n, k, theta) times the light at Y = 1 | cos(theta) = (i/(size - 1))^2 |
//
// The mapping is fresnel_table_cosine of shaders/shared/table.glsl. Texel 0 is grazing light: F =
// 1, the light's own colour. Values may be negative where the light lies outside the RGB space's
// gamut.
#pragma once
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "spectral/colour_space.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/metal.hpp"

namespace togishi {

inline constexpr std::size_t default_table_size = 64;
inline constexpr std::size_t min_table_size = 2;
inline constexpr std::size_t max_table_size = 4096;

/// F of one metal at every row of a table and the 61 wavelengths: all that does not depend on the
/// light.
class MetalReflectance {
  public:
    /// size: rows, min_table_size to max_table_size. Throws InputError.
    MetalReflectance(const RefractiveIndex& on_61, std::size_t size);

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::span<const double> row(std::size_t i) const {
        return {reflectance_.data() + i * grid_61.count, grid_61.count};
    }

  private:
    std::size_t size_;
    std::vector<double> reflectance_;
};

/// (size, 3) linear RGB, row by row. weights on grid_61; rgb_from_xyz as colour_space.hpp gives it.
[[nodiscard]] std::vector<float> fresnel_table(const MetalReflectance& metal,
                                               const ColourWeights& weights,
                                               const glm::dmat3& rgb_from_xyz);

/// What names a table: all as find_metal, find_light, find_observer, find_colour_space and
/// find_adaptation take them.
struct FresnelTableRequest {
    std::string_view metal = default_metal;
    std::string_view light = default_light;
    std::string_view observer = default_observer;
    std::string_view space = default_colour_space;
    std::size_t size = default_table_size;
    std::string_view adaptation = "none";
};

/// The table by name. A metal's reflectance is kept between calls (the last 16 pairs of metal and
/// size), so that a light's new spectrum costs only the weighing. Thread-safe. Throws InputError.
[[nodiscard]] std::vector<float> fresnel_table(const FresnelTableRequest& request);

}  // namespace togishi
