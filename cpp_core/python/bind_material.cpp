#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <sstream>
#include <string>

#include "base/error.hpp"
#include "brdf/material.hpp"
#include "python/material_dict.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {

void bind_material(py::module_& m) {
    m.def(
        "materials", [] { return builtin_materials(); },
        "Names of the built-in materials, the default first; load_material takes them.");
    m.def(
        "load_material",
        [](const std::string& path) {
            Material material;
            {
                const py::gil_scoped_release release;
                material = load_material(path);
            }
            return dict_from_material(material);
        },
        py::arg("path"),
        "A blade material (a TOML file, or a built-in name), every field checked.");
    m.def(
        "default_material", [] { return dict_from_material(default_material()); },
        "A well-polished katana: data/materials/polished_katana.toml.");
    m.def(
        "material_to_toml",
        [](const py::object& material) { return material_to_toml(material_from_dict(material)); },
        py::arg("material"), "TOML text of a material dict, every field checked.");
}

}  // namespace togishi
