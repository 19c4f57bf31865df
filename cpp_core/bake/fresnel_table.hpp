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
#include <cstdint>
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

/// How the rows of a table are made.
enum class TableRows : std::uint8_t {
    /// Up to exact_table_size: every row. Beyond: a polynomial in cos(theta), where it holds F to
    /// 1e-8, as it does for metals; every row where it does not (an index near 1 without
    /// absorption).
    fast,
    every_row,  ///< each row by its own sum
};

inline constexpr std::size_t exact_table_size = 64;
/// Chebyshev points of the polynomial, cos(theta) = 0 and 1 among them. The built-in metals' F is
/// within 3e-10 of it, which a float does not show.
inline constexpr std::size_t table_nodes = 28;

/// F of one metal at the 61 wavelengths: all that does not depend on the light.
class MetalReflectance {
  public:
    /// size: rows of the table, min_table_size to max_table_size. Throws InputError.
    MetalReflectance(const RefractiveIndex& on_61, std::size_t size,
                     TableRows rows = TableRows::fast);

    /// Rows of the table.
    [[nodiscard]] std::size_t size() const { return size_; }
    /// Where F is known: at each row of the table, or at the nodes of its polynomial.
    [[nodiscard]] std::size_t samples() const { return reflectance_.size() / grid_61.count; }
    [[nodiscard]] bool by_polynomial() const { return by_polynomial_; }
    /// i < samples(); the last is normal incidence.
    [[nodiscard]] std::span<const double> sample(std::size_t i) const {
        return {reflectance_.data() + i * grid_61.count, grid_61.count};
    }

  private:
    std::size_t size_;
    bool by_polynomial_;
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
