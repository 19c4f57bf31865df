// mesh/ray_tree.hpp
#include <pybind11/numpy.h>

#include <cstring>
#include <string>

#include "base/error.hpp"
#include "mesh/ray_tree.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// Rows of an (N, 3) array.
template <typename Row, typename T>
std::vector<Row> rows_of(const Array<T>& array, const char* field) {
    if (array.ndim() != 2 || array.shape(1) != 3) {
        throw InputError("mesh", field, py::cast<std::string>(py::str(array.attr("shape"))),
                         "(N, 3)");
    }
    std::vector<Row> rows(static_cast<std::size_t>(array.shape(0)));
    if (!rows.empty()) std::memcpy(rows.data(), array.data(), rows.size() * sizeof(Row));
    return rows;
}

py::array_t<float> texels(const std::vector<glm::vec4>& values) {
    py::array_t<float> out({static_cast<py::ssize_t>(values.size()), py::ssize_t{4}});
    if (!values.empty()) {
        std::memcpy(out.mutable_data(), values.data(), values.size() * sizeof(glm::vec4));
    }
    return out;
}

}  // namespace

void bind_trace(py::module_& m) {
    m.def(
        "ray_tree",
        [](const Array<float>& positions, const Array<float>& normals,
           const Array<std::uint32_t>& triangles, const Array<std::uint16_t>& groups) {
            TriangleMesh mesh;
            mesh.positions = rows_of<glm::vec3>(positions, "positions");
            mesh.triangles = rows_of<Triangle>(triangles, "triangles");
            const auto directions = rows_of<glm::vec3>(normals, "normals");
            const std::span group(groups.data(), static_cast<std::size_t>(groups.size()));
            const RayTree tree = [&] {
                const py::gil_scoped_release release;
                return ray_tree(mesh, directions, group);
            }();
            return py::make_tuple(texels(tree.nodes), texels(tree.triangles));
        },
        py::arg("positions"), py::arg("normals"), py::arg("triangles"), py::arg("groups"),
        "A surface as the GPU's rays search it: ((2 N, 4), (4 T, 4)) float32, the nodes and the\n"
        "triangles of shaders/shared/trace/ray_tree.glsl.\n"
        "positions, normals (V, 3); triangles (T, 3), at most 2^21; groups (T,) 0 to 4095.\n"
        "Raises InputError for other shapes and for vertices that are not there.");
}

}  // namespace togishi
