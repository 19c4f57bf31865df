// Katana parameters as Python hands them over, for every binding that takes them.
#pragma once
#include <pybind11/pybind11.h>

#include "blade/frame.hpp"
#include "blade/katana_parameters.hpp"

namespace togishi {

/// A mapping with the keys of katana_defaults; missing ones take the default of its zukuri. Throws
/// InputError for unknown keys, wrong types and unknown names; dimensions are checked by
/// make_katana and make_blade_frame.
KatanaParameters katana_from_python(const pybind11::handle& mapping);

/// The chart of a blade: of a generated one from its dimensions, or a scanned one's, which is a
/// mapping
/// {"frame": {...}} as frame_to_python makes it. Throws InputError as katana_from_python,
/// check_katana and check_frame do.
BladeFrame frame_from_python(const pybind11::handle& mapping);
/// {"frame": {...}} of plain numbers and lists, for JSON. Curves are rounded to 1e-6.
pybind11::dict frame_to_python(const BladeFrame& frame);

}  // namespace togishi
