#include "python/map_dict.hpp"

#include <pybind11/numpy.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "base/error.hpp"

namespace py = pybind11;

namespace togishi {

PropertyMaps maps_from_dict(const py::dict& maps) {
    using Array = py::array_t<float, py::array::c_style | py::array::forcecast>;
    PropertyMaps result;
    result.width = 1;
    result.height = 1;
    for (const auto& [key, value] : maps) {
        const std::string name = py::str(key);
        const auto* const at = std::find(map_channel_names.begin(), map_channel_names.end(), name);
        if (at == map_channel_names.end()) {
            throw InputError("property maps", "channel", name,
                             "ji.ln_mu_deg, ji.e1, ji.e2, ha.ln_mu_deg, ha.e1, ha.e2, w, h, part");
        }
        const auto array = Array::ensure(value);
        if (!array) {
            PyErr_Clear();
            throw InputError("property maps", name, std::string(py::str(py::type::of(value))),
                             "an array of numbers");
        }
        if (array.ndim() != 2 || array.size() == 0) {
            throw InputError("property maps", name,
                             "of " + std::to_string(array.ndim()) + " dimensions, " +
                                 std::to_string(array.size()) + " values",
                             "(height, width), or (1, 1) where it is constant");
        }
        const auto height = static_cast<std::size_t>(array.shape(0));
        const auto width = static_cast<std::size_t>(array.shape(1));
        if (width * height > 1) {
            if (result.width * result.height > 1 &&
                (result.width != width || result.height != height)) {
                throw InputError(
                    "property maps", name, std::to_string(height) + " x " + std::to_string(width),
                    "the size of the other channels, " + std::to_string(result.height) + " x " +
                        std::to_string(result.width));
            }
            result.width = width;
            result.height = height;
        }
        const auto index = static_cast<std::size_t>(at - map_channel_names.begin());
        result.channels[index].assign(array.data(), array.data() + array.size());
    }
    return result;
}

py::dict dict_from_maps(PropertyMaps maps) {
    py::dict dict;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        if (maps.channels[c].empty()) continue;
        auto plane = std::make_unique<std::vector<float>>(std::move(maps.channels[c]));
        const bool constant = plane->size() == 1;
        const py::ssize_t height = constant ? 1 : static_cast<py::ssize_t>(maps.height);
        const py::ssize_t width = constant ? 1 : static_cast<py::ssize_t>(maps.width);
        float* data = plane->data();
        const py::capsule owner(plane.release(),
                                [](void* p) { delete static_cast<std::vector<float>*>(p); });
        dict[py::str(std::string(map_channel_names[c]))] =
            py::array_t<float>({height, width}, data, owner);
    }
    return dict;
}

}  // namespace togishi
