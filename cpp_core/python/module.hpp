#pragma once
#include <pybind11/pybind11.h>

namespace togishi {

void bind_spectral(pybind11::module_& m);
void bind_material(pybind11::module_& m);
void bind_bake(pybind11::module_& m);
void bind_trace(pybind11::module_& m);
void bind_property_maps(pybind11::module_& m);
void bind_blade(pybind11::module_& m);
void bind_steel(pybind11::module_& m);
void bind_fit(pybind11::module_& m);
void bind_plot(pybind11::module_& m);
void bind_capture_diffuse(pybind11::module_& m);
void bind_capture_lights(pybind11::module_& m);
void bind_capture_project(pybind11::module_& m);
void bind_scan(pybind11::module_& m);
void bind_reference(pybind11::module_& m);
void bind_formulas(pybind11::module_& m);

}  // namespace togishi
