// Katana parameters as Python hands them over, for every binding that takes them.
#pragma once
#include <pybind11/pybind11.h>

#include "blade/katana_parameters.hpp"

namespace togishi {

/// A mapping with the keys of katana_defaults; missing ones take the default of its zukuri. Throws
/// InputError for unknown keys, wrong types and unknown names; dimensions are checked by
/// make_katana and make_blade_frame.
KatanaParameters katana_from_python(const pybind11::handle& mapping);

}  // namespace togishi
