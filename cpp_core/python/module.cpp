// The Python module togishi_core. One binding file per header; this one only gathers them.
#include "python/module.hpp"

#include "base/error.hpp"

PYBIND11_MODULE(togishi_core, m) {
    m.doc() =
        "Togishi's core: spectra, reflection tables, blades, steel patterns and the reference, on "
        "numpy arrays.";
    m.attr("__version__") = TOGISHI_VERSION;
    pybind11::register_exception<togishi::InputError>(m, "InputError", PyExc_ValueError);
    togishi::bind_spectral(m);
    togishi::bind_material(m);
    togishi::bind_bake(m);
    togishi::bind_trace(m);
    togishi::bind_property_maps(m);
    togishi::bind_blade(m);
    togishi::bind_steel(m);
    togishi::bind_fit(m);
    togishi::bind_plot(m);
    togishi::bind_capture_diffuse(m);
    togishi::bind_capture_lights(m);
    togishi::bind_capture_project(m);
    togishi::bind_scan(m);
    togishi::bind_reference(m);
    togishi::bind_formulas(m);
}
