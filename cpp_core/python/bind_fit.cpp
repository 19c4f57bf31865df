// scan/scan_file.hpp, scan/simulate_scan.hpp, fit/fit.hpp
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "fit/fit.hpp"
#include "fit/option_fields.hpp"
#include "python/fit_dict.hpp"
#include "python/material_dict.hpp"
#include "python/module.hpp"
#include "scan/scan_file.hpp"
#include "scan/simulate_scan.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string shown(const py::handle& value) {
    return py::cast<std::string>(py::repr(value));
}

double number_of(std::string_view where, const std::string& field, const py::handle& value) {
    const bool text = py::isinstance<py::str>(value) || py::isinstance<py::bool_>(value);
    const double number = text ? 0 : PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr || text) {
        PyErr_Clear();
        throw InputError(where, field, shown(value), "a number");
    }
    return number;
}

bool truth_of(std::string_view where, const std::string& field, const py::handle& value) {
    if (!py::isinstance<py::bool_>(value))
        throw InputError(where, field, shown(value), "True or False");
    return py::cast<bool>(value);
}

std::string text_of(std::string_view where, const std::string& field, const py::handle& value) {
    if (!py::isinstance<py::str>(value)) throw InputError(where, field, shown(value), "text");
    return py::cast<std::string>(value);
}

template <class Names>
std::size_t choice_of(std::string_view where, const std::string& field, const py::handle& value,
                      const Names& names) {
    const std::string text = text_of(where, field, value);
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == text) return i;
        all += (i > 0 ? ", " : "") + std::string(names[i]);
    }
    throw InputError(where, field, "\"" + text + "\"", all);
}

std::vector<double> numbers_of(std::string_view where, const std::string& field,
                               const py::handle& value) {
    if (py::isinstance<py::str>(value) || PySequence_Check(value.ptr()) == 0)
        throw InputError(where, field, shown(value), "a list of numbers");
    std::vector<double> numbers;
    for (const auto& item : value) numbers.push_back(number_of(where, field, item));
    return numbers;
}

std::uint64_t seed_of(std::string_view where, const py::handle& value) {
    const double seed = number_of(where, "seed", value);
    constexpr double most = 9007199254740992.0;
    if (!(seed >= 0 && seed <= most) || seed != std::floor(seed))
        throw InputError(where, "seed", shown(value), "a whole number from 0 to 2^53");
    return static_cast<std::uint64_t>(seed);
}

py::dict as_dict(std::string_view where, const py::object& mapping) {
    if (PyMapping_Check(mapping.ptr()) == 0 || !py::hasattr(mapping, "keys"))
        throw InputError(where, "type", shown(py::type::of(mapping)), "a dict");
    return py::dict(mapping);
}

ScanSettings settings_of(const py::object& mapping) {
    ScanSettings settings;
    for (const auto& [key, value] : as_dict("settings", mapping)) {
        const std::string name = text_of("settings", "key", key);
        settings.emplace(name, text_of("settings", name, value));
    }
    return settings;
}

Array table(const std::vector<double>& values, std::size_t rows, std::size_t columns) {
    return Array(
        std::vector<py::ssize_t>{static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(columns)},
        values.data());
}

py::list scans_of(const ScanSet& set) {
    py::list scans;
    for (const Scan& scan : set.scans) {
        py::dict d;
        const std::size_t n = scan.rows.size();
        std::vector<double> receive, azimuth;
        py::array_t<std::int64_t> line(static_cast<py::ssize_t>(n));
        for (std::size_t i = 0; i < n; ++i) {
            receive.push_back(scan.rows[i].receive_deg);
            azimuth.push_back(scan.rows[i].azimuth_deg);
            line.mutable_at(static_cast<py::ssize_t>(i)) =
                static_cast<std::int64_t>(scan.rows[i].line);
        }
        d["file"] = scan.file;
        d["incidence_deg"] = scan.incidence_deg;
        d["turn_deg"] = scan.turn_deg;
        d["quantity"] = std::string(scan_quantity_names[static_cast<std::size_t>(scan.quantity)]);
        d["source_aperture_deg"] = scan.source_aperture_deg;
        d["detector_aperture_deg"] = scan.detector_aperture_deg;
        d["saturation"] = scan.saturation;
        d["receive_deg"] = Array(static_cast<py::ssize_t>(n), receive.data());
        d["azimuth_deg"] = Array(static_cast<py::ssize_t>(n), azimuth.data());
        d["line"] = line;
        d["intensity"] = table(scan.intensity, n, set.channels.size());
        d["sigma"] = scan.sigma.empty() ? py::object(py::none())
                                        : py::object(table(scan.sigma, n, set.channels.size()));
        scans.append(d);
    }
    return scans;
}

// What of an option a dict has said: the fields by name, and what is left by hand.
SimulationOptions simulation_of(const py::object& mapping) {
    constexpr std::string_view where = "simulation options";
    SimulationOptions o;
    const py::dict dict = as_dict(where, mapping);
    if (dict.contains("protocol"))
        o.protocol = scan_protocol(text_of(where, "protocol", dict["protocol"]));
    for (const auto& [key, value] : dict) {
        const std::string name = text_of(where, "key", key);
        const bool of_protocol = value.is_none();
        if (name == "protocol" || of_protocol) continue;
        if (name == "incidences_deg") {
            o.protocol.incidences_deg = numbers_of(where, name, value);
        } else if (name == "turns_deg") {
            o.protocol.turns_deg = numbers_of(where, name, value);
        } else if (name == "azimuths_deg") {
            o.protocol.azimuths_deg = numbers_of(where, name, value);
        } else if (name == "receive_first_deg") {
            o.protocol.receive_first_deg = number_of(where, name, value);
        } else if (name == "receive_last_deg") {
            o.protocol.receive_last_deg = number_of(where, name, value);
        } else if (name == "step_deg") {
            o.protocol.step_deg = number_of(where, name, value);
        } else if (name == "dense_within_deg") {
            o.protocol.dense_within_deg = number_of(where, name, value);
        } else if (name == "coarse_step_deg") {
            o.protocol.coarse_step_deg = number_of(where, name, value);
        } else if (name == "quantity") {
            o.quantity =
                static_cast<ScanQuantity>(choice_of(where, name, value, scan_quantity_names));
        } else if (name == "calibration") {
            o.calibration =
                static_cast<ScanCalibration>(choice_of(where, name, value, scan_calibration_names));
        } else if (name == "channels") {
            o.channels.clear();
            for (const auto& item : value) o.channels.push_back(text_of(where, name, item));
        } else if (name == "light") {
            o.light = text_of(where, name, value);
        } else if (name == "state_sigma") {
            o.state_sigma = truth_of(where, name, value);
        } else if (name == "seed") {
            o.seed = seed_of(where, value);
        } else {
            bool known = false;
            std::string all =
                "protocol, incidences_deg, turns_deg, azimuths_deg, receive_first_deg, "
                "receive_last_deg, "
                "step_deg, "
                "dense_within_deg, coarse_step_deg, quantity, calibration, channels, light, "
                "state_sigma, seed";
            for (const SimulationField& field : simulation_fields()) {
                all += ", " + std::string(field.name);
                if (field.name != name) continue;
                o.*field.member = number_of(where, name, value);
                known = true;
            }
            if (!known) throw InputError(where, "key", name, all);
        }
    }
    return o;
}

py::dict simulation_defaults() {
    const SimulationOptions o;
    py::dict d;
    d["protocol"] = "a";
    for (const char* key : {"incidences_deg", "turns_deg", "azimuths_deg", "receive_first_deg",
                            "receive_last_deg", "step_deg", "dense_within_deg", "coarse_step_deg"})
        d[key] = py::none();
    d["quantity"] = std::string(scan_quantity_names[static_cast<std::size_t>(o.quantity)]);
    d["calibration"] = std::string(scan_calibration_names[static_cast<std::size_t>(o.calibration)]);
    d["channels"] = o.channels;
    d["light"] = o.light;
    for (const SimulationField& field : simulation_fields())
        d[py::str(std::string(field.name))] = o.*field.member;
    d["state_sigma"] = o.state_sigma;
    d["seed"] = o.seed;
    return d;
}

FitOptions fit_options_of(const py::object& mapping) {
    constexpr std::string_view where = "fit options";
    FitOptions o;
    for (const auto& [key, value] : as_dict(where, mapping)) {
        const std::string name = text_of(where, "key", key);
        bool known = false;
        std::string all;
        for (const auto& field : fit_option_fields()) {
            all += (all.empty() ? "" : ", ") + std::string(field.name);
            if (field.name != name) continue;
            known = true;
            std::visit(
                [&](auto member) {
                    auto& target = o.*member;
                    using T = std::decay_t<decltype(target)>;
                    if constexpr (std::is_same_v<T, bool>) {
                        target = truth_of(where, name, value);
                    } else if constexpr (std::is_same_v<T, std::string>) {
                        target = text_of(where, name, value);
                    } else if constexpr (std::is_same_v<T, FitChoice>) {
                        target =
                            static_cast<FitChoice>(choice_of(where, name, value, fit_choice_names));
                    } else if constexpr (std::is_same_v<T, int>) {
                        const double number = number_of(where, name, value);
                        if (number != std::floor(number) || std::abs(number) > 1e9)
                            throw InputError(where, name, shown(value), "a whole number");
                        target = static_cast<int>(number);
                    } else {
                        target = number_of(where, name, value);
                    }
                },
                field.member);
        }
        if (!known) throw InputError(where, "key", name, all);
    }
    return o;
}

py::dict fit_defaults() {
    const FitOptions o;
    py::dict d;
    for (const auto& field : fit_option_fields()) {
        const py::str name{std::string(field.name)};
        std::visit(
            [&](auto member) {
                const auto& value = o.*member;
                if constexpr (std::is_same_v<std::decay_t<decltype(value)>, FitChoice>) {
                    d[name] = std::string(fit_choice_names[static_cast<std::size_t>(value)]);
                } else {
                    d[name] = value;
                }
            },
            field.member);
    }
    return d;
}

std::shared_ptr<Fit> run_fit(const std::shared_ptr<ScanSet>& scans, const py::object& options,
                             const py::object& progress) {
    const FitOptions chosen = fit_options_of(options);
    FitProgress report;
    if (!progress.is_none()) {
        // What the callable raises passes through; returning False cancels as well.
        report = [&progress](double done) {
            const py::gil_scoped_acquire acquire;
            return progress(done).ptr() != Py_False;
        };
    }
    try {
        const py::gil_scoped_release release;
        return std::make_shared<Fit>(fit_scans(*scans, chosen, report));
    } catch (const FitCancelled&) {
        PyErr_SetString(PyExc_InterruptedError, "fit: cancelled");
        throw py::error_already_set();
    }
}

py::list fitted_of(const Fit& fit) {
    py::list scans;
    const std::size_t channels = fit.scans.channels.size();
    for (const FittedScan& scan : fit.fitted) {
        const std::size_t rows = scan.modelled.size() / channels;
        py::dict d;
        d["modelled"] = table(scan.modelled, rows, channels);
        d["residual_sigma"] = table(scan.residual_sigma, rows, channels);
        py::array_t<std::uint8_t> state(std::vector<py::ssize_t>{
            static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(channels)});
        for (std::size_t i = 0; i < scan.state.size(); ++i)
            state.mutable_data()[i] = static_cast<std::uint8_t>(scan.state[i]);
        d["state"] = state;
        d["gain"] = scan.gain;
        d["gain_sigma"] = scan.gain_sigma;
        d["residual_rms_sigma"] = scan.residual_rms_sigma;
        d["mu_eff_deg"] = scan.mu_eff_deg;
        d["mu_eff_sigma_deg"] = scan.mu_eff_sigma_deg;
        scans.append(d);
    }
    return scans;
}

std::vector<double> vector_of(const char* name, const Array& array) {
    if (array.ndim() != 1)
        throw InputError(name, "array", std::to_string(array.ndim()) + " dimensions", "(N,)");
    return {array.data(), array.data() + array.size()};
}

void bind_classes(py::module_& m) {
    py::class_<ScanSet, std::shared_ptr<ScanSet>>(
        m, "ScanSet", "Scans of one part, to be fitted together. Read-only.")
        .def_property_readonly(
            "part",
            [](const ScanSet& s) {
                return std::string(scan_part_names[static_cast<std::size_t>(s.part)]);
            })
        .def_property_readonly(
            "calibration",
            [](const ScanSet& s) {
                return std::string(scan_calibration_names[static_cast<std::size_t>(s.calibration)]);
            })
        .def_readonly("unit", &ScanSet::unit)
        .def_readonly("metal", &ScanSet::metal)
        .def_readonly("light", &ScanSet::light)
        .def_readonly("name", &ScanSet::name)
        .def_readonly("notes", &ScanSet::notes)
        .def_property_readonly("channels",
                               [](const ScanSet& s) {
                                   std::vector<std::string> names;
                                   for (const ScanChannel& c : s.channels) names.push_back(c.name);
                                   return names;
                               })
        .def_property_readonly("inputs",
                               [](const ScanSet& s) {
                                   py::list inputs;
                                   for (const ScanInput& input : s.inputs) {
                                       py::dict d;
                                       d["file"] = input.file;
                                       d["sha256"] = input.sha256;
                                       inputs.append(d);
                                   }
                                   return inputs;
                               })
        .def_property_readonly("scans", &scans_of)
        .def_property_readonly("readings", &ScanSet::readings)
        .def("to_text", &scans_to_text, "A scan file that parse_scans reads back.");
    py::class_<Fit, std::shared_ptr<Fit>>(m, "Fit", "What fit_scans found. Read-only.")
        .def_property_readonly("scan_set",
                               [](const Fit& f) { return std::make_shared<ScanSet>(f.scans); })
        .def_property_readonly("record",
                               [](const Fit& f) {
                                   py::dict d = dict_from_fit_record(f.record);
                                   d["part"] = f.record.part;
                                   return d;
                               })
        .def_property_readonly("lobe",
                               [](const Fit& f) {
                                   py::dict d;
                                   d["mu_t_deg"] = f.lobe.mu_t_deg;
                                   d["mu_b_deg"] = f.lobe.mu_b_deg;
                                   d["rho_deg"] = f.lobe.rho_deg;
                                   d["weight"] = f.lobe.weight;
                                   return d;
                               })
        .def_property_readonly("scans", &fitted_of)
        .def_readonly("seconds", &Fit::seconds)
        .def_readonly("evaluations", &Fit::evaluations)
        .def(
            "curve",
            [](const Fit& f, py::ssize_t scan, const Array& receive_deg) {
                const std::vector<double> angles = vector_of("receive_deg", receive_deg);
                if (scan < 0) throw InputError("fit", "scan", std::to_string(scan), "0 or more");
                return table(modelled_curve(f, static_cast<std::size_t>(scan), angles),
                             angles.size(), f.scans.channels.size());
            },
            py::arg("scan"), py::arg("receive_deg"),
            "(N, C): the fitted model at other receive angles of one scan, in its plane of "
            "incidence.")
        .def(
            "mu_eff_deg",
            [](const Fit& f, const Array& turn_deg) {
                const std::vector<double> widths = mu_eff_deg(f, vector_of("turn_deg", turn_deg));
                return Array(static_cast<py::ssize_t>(widths.size()), widths.data());
            },
            py::arg("turn_deg"),
            "(N,) half width of the fitted lobe along the plane of incidence at each turn of the "
            "sample.");
}

}  // namespace

void bind_fit(py::module_& m) {
    bind_classes(m);
    m.def(
        "parse_scans",
        [](const std::string& text, const std::string& name, const py::object& settings) {
            const ScanSettings chosen = settings_of(settings);
            const py::gil_scoped_release release;
            return std::make_shared<ScanSet>(parse_scans(text, name, chosen));
        },
        py::arg("text"), py::arg("name") = "text", py::arg("settings") = py::dict(),
        "The text of one scan file. settings: header keys that stand in for what the file does not "
        "say.\nInputError names line and column.");
    m.def(
        "read_scans",
        [](const std::vector<std::string>& paths, const py::object& settings) {
            const ScanSettings chosen = settings_of(settings);
            std::vector<std::shared_ptr<ScanSet>> sets;
            const py::gil_scoped_release release;
            const std::vector<std::filesystem::path> files(paths.begin(), paths.end());
            for (ScanSet& set : read_scans(files, chosen))
                sets.push_back(std::make_shared<ScanSet>(std::move(set)));
            return sets;
        },
        py::arg("paths"), py::arg("settings") = py::dict(),
        "Files from disk, joined by part, ji first: each set goes into one fit.");
    m.def("simulation_defaults", &simulation_defaults,
          "Options of simulate_scan with their defaults (cpp_core/scan/simulate_scan.hpp).");
    m.def(
        "simulate_scan",
        [](const py::object& material, const std::string& part, const py::object& options) {
            const Material chosen = material_from_dict(material);
            const auto which = static_cast<ScanPart>(
                choice_of("simulate_scan", "part", py::str(part), scan_part_names));
            const SimulationOptions o = simulation_of(options);
            const py::gil_scoped_release release;
            return std::make_shared<ScanSet>(simulate_scan(chosen, which, o));
        },
        py::arg("material"), py::arg("part"), py::arg("options") = py::dict(),
        "What a goniometer would measure of the part (\"ji\" or \"hamon\") of a material, by the "
        "reference "
        "evaluation.");
    m.def("fit_defaults", &fit_defaults,
          "Options of fit_scans with their defaults (cpp_core/fit/fit.hpp).");
    m.def("fit_scans", &run_fit, py::arg("scans"), py::arg("options") = py::dict(), py::kw_only(),
          py::arg("progress") = py::none(),
          "Fits the model to all scans of a set jointly. progress: called with the share done, in "
          "[0, 1]; what it "
          "raises passes through, and returning False cancels with InterruptedError.");
    m.def(
        "material_from_fits",
        [](const std::vector<std::shared_ptr<Fit>>& fits, const py::object& base,
           const std::string& name) {
            std::vector<const Fit*> all;
            for (const auto& fit : fits) all.push_back(fit.get());
            const Material from = base.is_none() ? default_material() : material_from_dict(base);
            return dict_from_material(material_from_fits(all, from, name));
        },
        py::arg("fits"), py::arg("base") = py::none(), py::arg("name") = "",
        "The base material (default: the default material) with the fitted parts and their records "
        "(key \"fit\").");
}

}  // namespace togishi
