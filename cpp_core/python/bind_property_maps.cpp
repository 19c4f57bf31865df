#include "python/module.hpp"

namespace togishi {

void bind_property_maps(pybind11::module_& m) { (void)m; }

}  // namespace togishi
