// Blade materials as nested Python dicts of the same keys as the TOML files.
#pragma once
#include <pybind11/pybind11.h>

#include "brdf/material.hpp"

namespace togishi {

/// Every field is checked as in a file; errors name "material". Throws InputError.
[[nodiscard]] Material material_from_dict(const pybind11::object& material);
[[nodiscard]] pybind11::dict dict_from_material(const Material& material);

}  // namespace togishi
