// A fit's record as nested Python dicts of the same keys as in a material file.
#pragma once
#include <pybind11/pybind11.h>

#include "brdf/fit_record.hpp"

namespace togishi {

[[nodiscard]] pybind11::dict dict_from_fit_record(const FitRecord& record);

}  // namespace togishi
