// steel/steel_pattern.hpp
#include <pybind11/stl.h>

#include <cmath>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "steel/steel_pattern.hpp"
// After the model's formulas, which must not see the blade's own arithmetic.
#include "python/blade_parameters.hpp"
#include "python/map_dict.hpp"
#include "python/material_dict.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

constexpr std::string_view pattern_where = "steel pattern";

double number_from(std::string_view where, const std::string& field, const py::handle& value) {
    // numpy's scalars and Python's numbers, but no truth values and no text.
    const bool number = !py::isinstance<py::bool_>(value) && !py::isinstance<py::str>(value) &&
                        (PyFloat_Check(value.ptr()) != 0 || PyNumber_Check(value.ptr()) != 0);
    if (!number) {
        throw InputError(where, field, py::cast<std::string>(py::repr(value)), "a number");
    }
    try {
        return py::cast<double>(py::float_(py::reinterpret_borrow<py::object>(value)));
    } catch (const py::error_already_set&) {
        throw InputError(where, field, py::cast<std::string>(py::repr(value)), "a number");
    }
}

std::uint64_t seed_from(const py::handle& value) {
    const double x = number_from(pattern_where, "seed", value);
    constexpr double most = 9007199254740992.0;  // 2^53: a double holds every whole number up to it
    if (!(x >= 0.0 && x <= most) || x != std::floor(x)) {
        throw InputError(pattern_where, "seed", py::cast<std::string>(py::repr(value)),
                         "a whole number from 0 to 2^53");
    }
    return static_cast<std::uint64_t>(x);
}

SteelParameters pattern_from_python(const py::handle& mapping) {
    SteelParameters p;
    for (const auto& [key, value] : py::dict(py::reinterpret_borrow<py::object>(mapping))) {
        const auto name = py::cast<std::string>(py::str(key));
        bool known = name == "seed";
        if (known) p.seed = seed_from(value);
        for (const SteelNumberField& field : steel_number_fields()) {
            if (field.name != name) continue;
            p.*field.member = number_from(pattern_where, name, value);
            known = true;
        }
        for (const SteelChoiceField& field : steel_choice_fields()) {
            if (field.name != name) continue;
            set_steel_choice(p, field, py::cast<std::string>(py::str(value)));
            known = true;
        }
        if (!known) {
            std::string allowed = "one of: seed";
            for (const auto& field : steel_choice_fields())
                allowed += ", " + std::string(field.name);
            for (const auto& field : steel_number_fields())
                allowed += ", " + std::string(field.name);
            throw InputError(pattern_where, "key", name, allowed);
        }
    }
    check_steel_parameters(p);
    return p;
}

py::dict to_python(const SteelParameters& p) {
    py::dict result;
    for (const SteelChoiceField& field : steel_choice_fields()) {
        result[py::str(std::string(field.name))] =
            std::string(field.names[static_cast<std::size_t>(field.get(p))]);
    }
    for (const SteelNumberField& field : steel_number_fields()) {
        result[py::str(std::string(field.name))] = p.*field.member;
    }
    result["seed"] = p.seed;
    return result;
}

std::size_t size_from(const char* name, py::ssize_t size) {
    if (size < 1) throw InputError(pattern_where, name, std::to_string(size), "1 to 65536 texels");
    return static_cast<std::size_t>(size);
}

py::dict pattern(const py::object& blade, const py::object& material, const py::object& chosen,
                 py::ssize_t width, py::ssize_t height, const py::object& progress) {
    const BladeFrame frame = frame_from_python(blade);
    const Material lobes = material_from_dict(material);
    const SteelParameters p = pattern_from_python(chosen);
    const std::size_t columns = size_from("width", width);
    const std::size_t rows = size_from("height", height);
    SteelProgress report;
    if (!progress.is_none()) {
        // What the callable raises passes through; returning False cancels as well.
        report = [&progress](double done) {
            const py::gil_scoped_acquire acquire;
            return progress(done).ptr() != Py_False;
        };
    }
    PropertyMaps maps;
    try {
        const py::gil_scoped_release release;
        maps = steel_pattern(frame, lobes, p, columns, rows, report);
    } catch (const SteelCancelled&) {
        PyErr_SetString(PyExc_InterruptedError, "steel pattern: cancelled");
        throw py::error_already_set();
    }
    return dict_from_maps(std::move(maps));
}

}  // namespace

void bind_steel(py::module_& m) {
    m.def(
        "steel_defaults", [] { return to_python(SteelParameters{}); },
        "Parameters of a blade's pattern: docs/steel.md says what each does, its unit and range.");
    m.def(
        "steel_choices",
        [] {
            py::dict result;
            for (const SteelChoiceField& field : steel_choice_fields()) {
                py::list names;
                for (const auto name : field.names) names.append(std::string(name));
                result[py::str(std::string(field.name))] = names;
            }
            return result;
        },
        "The names that each choice of steel_defaults allows.");
    m.def(
        "steel_ranges",
        [] {
            py::dict result;
            for (const SteelNumberField& field : steel_number_fields()) {
                result[py::str(std::string(field.name))] = py::make_tuple(field.low, field.high);
            }
            return result;
        },
        "The lowest and the highest value that each number of steel_defaults allows.");
    m.def("steel_pattern", &pattern, py::arg("blade"), py::arg("material"), py::arg("pattern"),
          py::arg("width"), py::arg("height"), py::kw_only(), py::arg("progress") = py::none(),
          "Property maps of a blade: channel name -> (height, width), or (1, 1) where it is "
          "constant. progress: called with the share done; returning False cancels "
          "(InterruptedError).");
}

}  // namespace togishi
