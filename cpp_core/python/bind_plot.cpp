// plot/fit_plot.hpp
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>

#include "plot/fit_plot.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

py::array_t<std::uint8_t> array_of(const Picture& picture) {
    return py::array_t<std::uint8_t>({picture.height, picture.width, 3}, picture.rgb.data());
}

}  // namespace

void bind_plot(py::module_& m) {
    m.def(
        "fit_pictures",
        [](const std::shared_ptr<Fit>& fit, double scale) {
            Picture scans, mu_eff;
            {
                const py::gil_scoped_release release;
                scans = plot_scans(*fit, scale);
                mu_eff = plot_mu_eff(*fit, scale);
            }
            py::dict pictures;
            pictures["scans"] = array_of(scans);
            pictures["mu_eff"] = array_of(mu_eff);
            return pictures;
        },
        py::arg("fit"), py::arg("scale") = 1.0,
        "What was measured beside what the fitted model says, for people: (H, W, 3) in 8-bit sRGB, "
        "the top row "
        "first.");
}

}  // namespace togishi
