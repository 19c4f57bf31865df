#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "blade/part.hpp"
#include "python/module.hpp"
#include "spectral/colour_space.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/delta_e.hpp"
#include "spectral/light.hpp"
#include "spectral/metal.hpp"
#include "spectral/observer.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

Array array_of(const std::vector<double>& values) {
    return Array(static_cast<py::ssize_t>(values.size()), values.data());
}

// (N,) wavelengths, finite; strictly increasing where the function needs them so.
std::vector<double> wavelengths_of(const Array& array, bool increasing) {
    if (array.ndim() != 1) {
        throw InputError("wavelengths_nm", "shape", std::to_string(array.ndim()) + " dimensions",
                         "one dimension");
    }
    std::vector<double> nm(array.data(), array.data() + array.size());
    for (std::size_t i = 0; i < nm.size(); ++i) {
        if (!std::isfinite(nm[i]) || nm[i] <= 0.0 || (increasing && i > 0 && nm[i] <= nm[i - 1])) {
            throw InputError("wavelengths_nm", "element " + std::to_string(i),
                             std::to_string(nm[i]),
                             increasing ? "finite, above 0, increasing" : "finite, above 0");
        }
    }
    return nm;
}

void bind_names(py::module_& m) {
    m.def(
        "metals",
        [] {
            py::list all;
            for (const auto& metal : builtin_metals()) {
                py::dict entry;
                for (const auto* key : {"name", "title", "source", "licence"})
                    entry[key] = metal->table().value(key);
                entry["nm_min"] = metal->first_nm();
                entry["nm_max"] = metal->last_nm();
                all.append(entry);
            }
            return all;
        },
        "Built-in metals, iron first (the default): name, title, source, licence, nm_min, nm_max.");
    m.def(
        "lights",
        [] {
            py::list all;
            for (const auto& light : builtin_lights()) {
                const auto& d = light->description();
                py::dict entry;
                entry["name"] = d.name;
                entry["title"] = d.title;
                entry["source"] = d.source;
                entry["licence"] = d.licence;
                all.append(entry);
            }
            return all;
        },
        "Built-in light spectra, D65 first (the default): name, title, source, licence.");
    m.def(
        "observers",
        [] {
            std::vector<std::string> names;
            for (const auto& observer : builtin_observers()) names.emplace_back(observer->name());
            return names;
        },
        "Names of the CIE observers, the default first.");
    m.def(
        "colour_spaces",
        [] {
            std::vector<std::string> names;
            for (const auto& space : colour_spaces()) names.emplace_back(space.name);
            return names;
        },
        "Names of the linear RGB spaces, the default first.");
}

void bind_spectra(py::module_& m) {
    m.def(
        "metal_nk",
        [](const std::string& metal, const Array& wavelengths_nm) {
            const auto nm = wavelengths_of(wavelengths_nm, false);
            const auto index = [&] {
                const py::gil_scoped_release release;
                return find_metal(metal)->at(nm);
            }();
            return std::pair{array_of(index.n), array_of(index.k)};
        },
        py::arg("metal"), py::arg("wavelengths_nm"), "n and k by PCHIP at the wavelengths (N,).");
    m.def(
        "light_power",
        [](const std::string& light, const Array& wavelengths_nm) {
            const auto nm = wavelengths_of(wavelengths_nm, true);
            const auto power = [&] {
                const py::gil_scoped_release release;
                return find_light(light)->power_at(nm);
            }();
            return array_of(power);
        },
        py::arg("light"), py::arg("wavelengths_nm"),
        "Relative spectral power at increasing wavelengths (N,). A line gives its power to its two "
        "neighbours.");
    m.def(
        "light_notes",
        [](const std::string& light) {
            const py::gil_scoped_release release;
            return find_light(light)->description().notes;
        },
        py::arg("light"),
        "What a reader should know of this spectrum: range shortfalls, resampling.");
}

Array array_of(const glm::dmat3& matrix) {
    Array out({3, 3});
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            out.mutable_at(row, column) = matrix[column][row];
    }
    return out;
}

void bind_colour(py::module_& m) {
    m.def(
        "light_rgb",
        [](const std::string& light, const std::string& observer, const std::string& space,
           const std::string& adaptation) {
            glm::dvec3 rgb;
            {
                const py::gil_scoped_release release;
                const auto white =
                    colour_weights(*find_light(light), *find_observer(observer)).white;
                rgb = rgb_from_xyz(find_colour_space(space), find_adaptation(adaptation), white) *
                      white;
            }
            return array_of({rgb.x, rgb.y, rgb.z});
        },
        py::arg("light"), py::arg("observer") = default_observer,
        py::arg("space") = default_colour_space, py::arg("adaptation") = "none",
        "(3,) linear RGB of the light itself, scaled to luminance Y = 1.");
    m.def(
        "xyz_to_rgb",
        [](const std::string& space) { return array_of(find_colour_space(space).rgb_from_xyz); },
        py::arg("space"), "(3, 3) matrix from XYZ to linear RGB of the space: rgb = matrix @ xyz.");
    m.def(
        "adapt_rgb",
        [](const std::string& light, const std::string& observer, const std::string& space_name,
           const std::string& adaptation) {
            glm::dmat3 matrix;
            {
                const py::gil_scoped_release release;
                const auto& space = find_colour_space(space_name);
                const auto white =
                    colour_weights(*find_light(light), *find_observer(observer)).white;
                matrix = rgb_from_xyz(space, find_adaptation(adaptation), white) *
                         glm::inverse(space.rgb_from_xyz);
            }
            return array_of(matrix);
        },
        py::arg("light"), py::arg("observer") = default_observer,
        py::arg("space") = default_colour_space, py::arg("adaptation") = "cat16",
        "(3, 3) matrix on linear RGB: what an eye adapted to the white of `light` sees.");
    m.def(
        "delta_e00",
        [](const Array& xyz_a, const Array& xyz_b, const Array& white_xyz) {
            auto check = [](const Array& a, const char* name) {
                if (a.ndim() != 2 || a.shape(1) != 3) {
                    throw InputError(name, "shape", std::to_string(a.ndim()) + " dimensions",
                                     "(N, 3)");
                }
            };
            check(xyz_a, "xyz_a");
            check(xyz_b, "xyz_b");
            if (xyz_a.shape(0) != xyz_b.shape(0)) {
                throw InputError("xyz_b", "rows", std::to_string(xyz_b.shape(0)),
                                 "as many as xyz_a has: " + std::to_string(xyz_a.shape(0)));
            }
            if (white_xyz.ndim() != 1 || white_xyz.shape(0) != 3 || !(white_xyz.at(1) > 0.0)) {
                throw InputError("white_xyz", "value", "of another shape or without luminance",
                                 "(3,) with Y > 0");
            }
            Array out(xyz_a.shape(0));
            const auto count = static_cast<std::size_t>(xyz_a.shape(0));
            const double* a = xyz_a.data();
            const double* b = xyz_b.data();
            const glm::dvec3 white(white_xyz.at(0), white_xyz.at(1), white_xyz.at(2));
            double* result = out.mutable_data();
            const py::gil_scoped_release release;
            parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    const glm::dvec3 xyz_1(a[3 * i], a[3 * i + 1], a[3 * i + 2]);
                    const glm::dvec3 xyz_2(b[3 * i], b[3 * i + 1], b[3 * i + 2]);
                    result[i] = delta_e00(lab_from_xyz(xyz_1, white), lab_from_xyz(xyz_2, white));
                }
            });
            return out;
        },
        py::arg("xyz_a"), py::arg("xyz_b"), py::arg("white_xyz"),
        "CIEDE2000 per row of two (N, 3) arrays; Lab under white_xyz (3,). NaN where a row holds "
        "NaN.");
}

}  // namespace

void bind_spectral(py::module_& m) {
    m.attr("PART_NAMES") = part_names;
    bind_names(m);
    bind_spectra(m);
    bind_colour(m);
}

}  // namespace togishi
