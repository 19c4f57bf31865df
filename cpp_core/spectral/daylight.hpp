// CIE daylight of any correlated colour temperature.
#pragma once
#include <string>
#include <string_view>

#include "spectral/light.hpp"

namespace togishi {

inline constexpr std::string_view daylight_components_path = "lights/daylight_components.csv";
inline constexpr double daylight_min_cct_k = 4000.0;
inline constexpr double daylight_max_cct_k = 25000.0;

/// S0 + M1 S1 + M2 S2 at 5 nm, 300 to 830 nm, with M1 and M2 rounded to three decimals as the CIE
/// prescribes (CIE 015:2018, 4.1.2). cct_k within the limits above; the temperature is taken as it
/// is, on today's scale: D65 is daylight of 6500 * 1.4388/1.4380 = 6504 K.
[[nodiscard]] TableSpectrum daylight(double cct_k);

[[nodiscard]] std::string daylight_source();
[[nodiscard]] std::string daylight_licence();

}  // namespace togishi
