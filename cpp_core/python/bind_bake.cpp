#include <pybind11/numpy.h>

#include <string>

#include "bake/fresnel_table.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {

void bind_bake(py::module_& m) {
    m.def(
        "fresnel_table",
        [](const std::string& metal, const std::string& light, const std::string& observer,
           const std::string& space, std::size_t size, const std::string& adaptation) {
            FresnelTableRequest request;
            request.metal = metal;
            request.light = light;
            request.observer = observer;
            request.space = space;
            request.size = size;
            request.adaptation = adaptation;
            const auto table = [&] {
                const py::gil_scoped_release release;
                return fresnel_table(request);
            }();
            return py::array_t<float>({static_cast<py::ssize_t>(size), py::ssize_t{3}},
                                      table.data());
        },
        py::arg("metal"), py::arg("light"), py::arg("observer") = default_observer,
        py::arg("space") = default_colour_space, py::arg("size") = default_table_size,
        py::arg("adaptation") = "none",
        "(size, 3) linear RGB of F(n, k, theta) times the light (Y = 1); row i at cos(theta) = "
        "(i/(size - 1))^2.\n"
        "Beyond 64 rows F comes from a polynomial in cos(theta), to float precision.\n"
        "The metal's reflectance is kept between calls: a light's new spectrum costs some 30 us.");
}

}  // namespace togishi
