#include "python/material_dict.hpp"

#include <cmath>
#include <sstream>
#include <string>

#include "base/error.hpp"
#include "python/fit_dict.hpp"

#define TOML_EXCEPTIONS 1
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace py = pybind11;

namespace togishi {
namespace {

// A dict becomes TOML text and is read by the file's own parser: one set of rules for both.
void set(toml::table& table, const std::string& path, const std::string& key,
         const py::handle& value);

toml::table table_of(const std::string& path, const py::handle& dict) {
    toml::table table;
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(dict)) {
        if (!py::isinstance<py::str>(key)) {
            throw InputError("material", path + "key", std::string(py::str(key)), "text");
        }
        set(table, path, py::cast<std::string>(key), value);
    }
    return table;
}

double number_of(const std::string& field, const py::handle& value) {
    // Anything that Python takes for a number, numpy scalars too; nothing that it would parse from
    // text.
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        throw InputError("material", field, std::string(py::str(py::repr(value))),
                         "text, a number, a list or a dict");
    }
    return number;
}

// Numbers; in the record of a fit also texts, dicts and lists of them.
toml::array list_of(const std::string& field, const py::handle& value, int depth) {
    constexpr int deepest = 4;
    if (depth > deepest)
        throw InputError("material", field, "lists in lists in lists", "fewer levels");
    toml::array list;
    for (const auto& item : value) {
        if (py::isinstance<py::str>(item)) {
            list.push_back(py::cast<std::string>(item));
        } else if (PyMapping_Check(item.ptr()) != 0 && py::hasattr(item, "keys")) {
            list.push_back(
                table_of(field + ".", py::dict(py::reinterpret_borrow<py::object>(item))));
        } else if (PySequence_Check(item.ptr()) != 0) {
            list.push_back(list_of(field, item, depth + 1));
        } else {
            list.push_back(number_of(field, item));
        }
    }
    return list;
}

void set(toml::table& table, const std::string& path, const std::string& key,
         const py::handle& value) {
    const std::string field = path + key;
    if (PyMapping_Check(value.ptr()) != 0 && py::hasattr(value, "keys")) {
        table.insert(key,
                     table_of(field + ".", py::dict(py::reinterpret_borrow<py::object>(value))));
    } else if (py::isinstance<py::str>(value)) {
        table.insert(key, py::cast<std::string>(value));
    } else if (py::isinstance<py::bool_>(value)) {
        table.insert(key, py::cast<bool>(value));
    } else if (py::isinstance<py::int_>(value)) {
        int overflow = 0;
        const long long whole = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
        if (overflow != 0)
            throw InputError("material", field, std::string(py::str(value)), "a number of 64 bits");
        table.insert(key, static_cast<std::int64_t>(whole));
    } else if (PySequence_Check(value.ptr()) != 0) {
        table.insert(key, list_of(field, value, 0));
    } else {
        table.insert(key, number_of(field, value));
    }
}

}  // namespace

Material material_from_dict(const py::object& material) {
    if (PyMapping_Check(material.ptr()) == 0 || !py::hasattr(material, "keys")) {
        throw InputError("material", "type", std::string(py::str(py::type::of(material))),
                         "a dict");
    }
    const toml::table table = table_of("", py::dict(material));
    std::ostringstream text;
    text << table;
    // Lines of the text would mean nothing to the caller.
    return material_from_toml(text.str(), "material", SourceLines::hidden);
}

py::dict dict_from_material(const Material& material) {
    py::dict dict;
    dict["format"] = material_format;
    dict["name"] = material.name;
    dict["metal"] = material.metal;
    dict["weights"] = material.weights == Weights::measured ? "measured" : "normalised";
    dict["source"] = material.source;
    dict["licence"] = material.licence;
    py::dict parts;
    for (const MaterialLobeField& field : material_lobes) {
        const MaterialLobe& lobe = material.*field.member;
        py::dict part;
        if (field.key == "nakago") {
            py::list rgb;
            for (const double channel : material.nakago_albedo_rgb) rgb.append(channel);
            part["albedo_rgb"] = rgb;
            part["ior"] = material.nakago_ior;
        }
        part["mu_t_deg"] = lobe.mu_t_deg;
        part["mu_b_deg"] = lobe.mu_b_deg;
        part["rho_deg"] = lobe.rho_deg;
        if (!field.weight_key.empty() && material.weights == Weights::measured) {
            part[py::str(std::string(field.weight_key))] = lobe.weight;
        }
        parts[py::str(std::string(field.key))] = part;
    }
    dict["parts"] = parts;
    if (!material.fits.empty()) {
        py::dict fits;
        for (const FitRecord& fit : material.fits)
            fits[py::str(fit.part)] = dict_from_fit_record(fit);
        dict["fit"] = fits;
    }
    return dict;
}

}  // namespace togishi
