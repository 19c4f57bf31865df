// Property maps as Python dicts: channel name -> (H, W) float32 array, (1, 1) where constant.
#pragma once
#include <pybind11/pybind11.h>

#include "brdf/property_maps.hpp"

namespace togishi {

/// Throws InputError for unknown channels, arrays of other shapes, and maps of different sizes.
[[nodiscard]] PropertyMaps maps_from_dict(const pybind11::dict& maps);
/// The arrays take over the planes without a copy. Absent channels have no key.
[[nodiscard]] pybind11::dict dict_from_maps(PropertyMaps maps);

}  // namespace togishi
