#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "python/module.hpp"
#include "reference/reference.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));

// -1 in `expected` stands for any length.
void check_shape(const char* name, const py::array& array,
                 std::initializer_list<py::ssize_t> expected, const char* allowed) {
    bool same = array.ndim() == static_cast<py::ssize_t>(expected.size());
    py::ssize_t axis = 0;
    for (const py::ssize_t length : expected) {
        same = same && (length < 0 || array.shape(axis) == length);
        ++axis;
    }
    if (same) return;
    std::string found = "of shape (";
    for (py::ssize_t i = 0; i < array.ndim(); ++i)
        found += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
    throw InputError(name, "array", found + ")", allowed);
}

std::span<const glm::dvec3> vectors(const Array& array) {
    return {reinterpret_cast<const glm::dvec3*>(array.data()),
            static_cast<std::size_t>(array.size() / 3)};
}

PerPoint<StoredLobe> lobes(const char* name, const Array& array, py::ssize_t points) {
    if (array.ndim() == 1) {
        check_shape(name, array, {3}, "(P, 3) or (3,)");
    } else {
        check_shape(name, array, {points, 3}, "(P, 3) or (3,)");
    }
    return {{reinterpret_cast<const StoredLobe*>(array.data()),
             static_cast<std::size_t>(array.size() / 3)}};
}

PerPoint<double> shares(const char* name, const Array& array, py::ssize_t points) {
    if (array.ndim() != 0) check_shape(name, array, {points}, "(P,) or one number");
    return {{array.data(), static_cast<std::size_t>(array.size())}};
}

Array reference(const std::string& metal, const std::vector<std::string>& lights,
                const Indices& light_of, const Array& normal, const Array& tangent,
                const Array& view, const Array& light_direction, const Array& irradiance,
                const Array& lobe_ji, const Array& lobe_hadori, const Array& lobe_ha,
                const Array& w, const Array& h, double chi, double beta_hadori, double beta_ha,
                const std::optional<std::pair<std::string, double>>& world,
                const std::string& observer, const std::string& grid) {
    check_shape("normal", normal, {-1, 3}, "(P, 3)");
    check_shape("light_of", light_of, {-1}, "(K,)");
    const py::ssize_t points = normal.shape(0), count = light_of.shape(0);
    check_shape("tangent", tangent, {points, 3}, "(P, 3)");
    check_shape("view", view, {points, 3}, "(P, 3)");
    check_shape("light_direction", light_direction, {points, count, 3}, "(P, K, 3)");
    check_shape("irradiance", irradiance, {points, count}, "(P, K)");
    ReferenceScene scene;
    scene.metal = metal;
    scene.lights = lights;
    scene.light_of = {light_of.data(), static_cast<std::size_t>(count)};
    scene.normal = vectors(normal);
    scene.tangent = vectors(tangent);
    scene.view = vectors(view);
    scene.light_direction = vectors(light_direction);
    scene.irradiance = {irradiance.data(), static_cast<std::size_t>(irradiance.size())};
    scene.lobe_ji = lobes("lobe_ji", lobe_ji, points);
    scene.lobe_hadori = lobes("lobe_hadori", lobe_hadori, points);
    scene.lobe_ha = lobes("lobe_ha", lobe_ha, points);
    scene.w = shares("w", w, points);
    scene.h = shares("h", h, points);
    scene.chi = chi;
    scene.beta_hadori = beta_hadori;
    scene.beta_ha = beta_ha;
    scene.world = world;
    scene.observer = observer;
    if (grid != "61" && grid != "1nm") throw InputError("reference_xyz", "grid", grid, "61 or 1nm");
    scene.grid = grid == "61" ? ReferenceGrid::samples_61 : ReferenceGrid::full_1nm;
    std::vector<glm::dvec3> xyz;
    {
        const py::gil_scoped_release release;
        xyz = reference_xyz(scene);
    }
    return Array(std::vector<py::ssize_t>{points, 3}, reinterpret_cast<const double*>(xyz.data()));
}

}  // namespace

void bind_reference(py::module_& m) {
    m.def("reference_xyz", &reference, py::arg("metal"), py::arg("lights"), py::arg("light_of"),
          py::arg("normal"), py::arg("tangent"), py::arg("view"), py::arg("light_direction"),
          py::arg("irradiance"), py::arg("lobe_ji"), py::arg("lobe_hadori"), py::arg("lobe_ha"),
          py::arg("w"), py::arg("h"), py::arg("chi") = -1.0, py::arg("beta_hadori") = -1.0,
          py::arg("beta_ha") = -1.0, py::arg("world") = py::none(),
          py::arg("observer") = "cie1931_2", py::arg("grid") = "61",
          "XYZ (P, 3) of P points under K lights by the plain sum over wavelengths in double "
          "precision.\n"
          "Shapes: light_of (K,), normal, tangent, view (P, 3), light_direction (P, K, 3), "
          "irradiance (P, K),\n"
          "lobes (P, 3) or (3,), w, h (P,) or a number. Negative weights: normalised. grid: \"61\" "
          "or \"1nm\".");
}

}  // namespace togishi
