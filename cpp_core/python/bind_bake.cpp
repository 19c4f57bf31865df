#include "python/module.hpp"

namespace togishi {

void bind_bake(pybind11::module_& m) { (void)m; }

}  // namespace togishi
