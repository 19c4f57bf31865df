// blade/katana_mesh.hpp, blade/katana_parameters.hpp
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>

#include "base/error.hpp"
#include "blade/katana_file.hpp"
#include "blade/katana_mesh.hpp"
#include "python/blade_mesh_views.hpp"
#include "python/blade_parameters.hpp"
#include "python/module.hpp"
#include "spectral/embedded_data.hpp"

namespace py = pybind11;

namespace togishi {

KatanaParameters katana_from_python(const py::handle& mapping) {
    const auto items = py::dict(py::reinterpret_borrow<py::object>(mapping));
    KatanaParameters p;
    if (items.contains("zukuri"))
        p = katana_defaults(py::cast<std::string>(py::str(items["zukuri"])));
    for (const auto& [key, value] : items) {
        if (!py::isinstance<py::str>(key)) {
            throw InputError("parameters", "key", py::cast<std::string>(py::repr(key)), "a string");
        }
        const auto name = py::cast<std::string>(key);
        if (py::isinstance<py::str>(value)) {
            set_katana_value(p, name, std::string_view(py::cast<std::string>(value)), "parameters");
        } else if (!py::isinstance<py::bool_>(value) && PyNumber_Check(value.ptr()) != 0) {
            set_katana_value(
                p, name, py::cast<double>(py::float_(py::reinterpret_borrow<py::object>(value))),
                "parameters");
        } else {
            throw InputError("parameters", name, py::cast<std::string>(py::repr(value)),
                             "a number or a name");
        }
    }
    return p;
}

namespace {

struct Katana {
    KatanaMesh mesh;
    std::map<std::string, double> measures;
};

py::dict to_python(const KatanaParameters& p) {
    py::dict result;
    for (const ChoiceField& c : katana_choices()) {
        result[py::str(std::string(c.key))] =
            std::string(c.names[static_cast<std::size_t>(c.get(p))]);
    }
    for (const DimensionField& d : katana_dimensions())
        result[py::str(std::string(d.key))] = p.*d.member;
    return result;
}

}  // namespace

void bind_blade(py::module_& m) {
    py::class_<Katana, std::shared_ptr<Katana>> katana(
        m, "Katana",
        "A generated blade. Positions in mm: +X to the tip, +Z towards the mune (back), +Y to "
        "omote's outside.");
    bind_blade_arrays(katana, [](const py::object& self) -> const BladeMesh& {
        return self.cast<const Katana&>().mesh;
    });
    katana
        .def_property_readonly("chart_mm",
                               [](const Katana& k) {
                                   return py::make_tuple(k.mesh.frame.length_mm(),
                                                         k.mesh.frame.chart_height_mm);
                               })
        .def_property_readonly("frame",
                               [](const Katana& k) { return frame_to_python(k.mesh.frame); })
        .def_property_readonly("measures", [](const Katana& k) { return k.measures; });

    m.def(
        "katana_defaults",
        [](const std::string& zukuri) { return to_python(katana_defaults(zukuri)); },
        py::arg("zukuri") = "shinogi", "Ordinary dimensions of a blade: shinogi, hira or shobu.");
    m.def(
        "katana_presets",
        [] {
            constexpr std::string_view folder = "blades/";
            py::dict presets;
            for (const EmbeddedFile& file : embedded_files()) {
                if (!file.path.starts_with(folder)) continue;
                const KatanaPreset preset = parse_katana_preset(file.text, file.path);
                const std::string_view name = file.path.substr(folder.size());
                py::dict entry;
                entry["title"] = preset.title;
                entry["source"] = preset.source;
                entry["licence"] = preset.licence;
                entry["parameters"] = to_python(preset.parameters);
                presets[py::str(std::string(name.substr(0, name.rfind('.'))))] = entry;
            }
            return presets;
        },
        "Built-in blades: name -> title, source, licence, parameters (keys of katana_defaults).");
    m.def(
        "katana",
        [](const py::object& parameters, double detail) {
            const KatanaParameters p = katana_from_python(parameters);
            auto result = std::make_shared<Katana>();
            const py::gil_scoped_release release;
            result->mesh = make_katana(p, detail);
            result->measures = measure_katana(result->mesh, p);
            return result;
        },
        py::arg("parameters"), py::arg("detail") = 1.0,
        "Keys as katana_defaults returns; unknown keys and impossible dimensions raise InputError "
        "with the reason.");
}

}  // namespace togishi
