#include <pybind11/stl.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "blade/katana_frame.hpp"
#include "python/blade_parameters.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

constexpr const char* key = "frame";
constexpr const char* where = "frame";

template <typename T>
T value_of(const py::dict& items, std::string_view name, const char* allowed) {
    const py::str field{std::string(name)};
    if (!items.contains(field)) throw InputError(where, name, "missing", allowed);
    try {
        return py::cast<T>(items[field]);
    } catch (const py::cast_error&) {
        throw InputError(where, name,
                         py::cast<std::string>(py::str(py::type::handle_of(items[field]))),
                         allowed);
    }
}

}  // namespace

BladeFrame frame_from_python(const py::handle& mapping) {
    const auto items = py::dict(py::reinterpret_borrow<py::object>(mapping));
    if (!items.contains(key)) return make_blade_frame(katana_from_python(items));
    if (!py::isinstance<py::dict>(items[key]))
        throw InputError(where, key, py::cast<std::string>(py::repr(items[key])), "a mapping");
    const auto kept = py::cast<py::dict>(items[key]);
    BladeFrame frame;
    for (const auto& [name, member] : frame_lengths)
        frame.*member = value_of<double>(kept, name, "a number");
    for (const auto& [name, member] : frame_curves)
        frame.*member = value_of<std::vector<double>>(kept, name, "a list of numbers");
    check_frame(frame, where);
    return frame;
}

py::dict frame_to_python(const BladeFrame& frame) {
    constexpr double steps = 1e6;
    py::dict kept;
    for (const auto& [name, member] : frame_lengths)
        kept[py::str(std::string(name))] = frame.*member;
    for (const auto& [name, member] : frame_curves) {
        std::vector<double> curve = frame.*member;
        for (double& x : curve) x = std::round(x * steps) / steps;
        kept[py::str(std::string(name))] = curve;
    }
    py::dict result;
    result[key] = kept;
    return result;
}

}  // namespace togishi
