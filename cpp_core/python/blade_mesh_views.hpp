// A blade's arrays as Python sees them: read-only views into the object that keeps them.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>

#include "blade/blade_mesh.hpp"

namespace togishi {

/// Of a vector inside `owner`, which the array keeps alive. shape: without the columns that an
/// element has; empty: one row an element.
template <typename Scalar, typename Element>
pybind11::array view(const pybind11::object& owner, const std::vector<Element>& data,
                     std::vector<pybind11::ssize_t> shape = {}) {
    constexpr std::size_t columns = sizeof(Element) / sizeof(Scalar);
    if (shape.empty()) shape = {static_cast<pybind11::ssize_t>(data.size())};
    if constexpr (columns > 1) shape.push_back(columns);
    pybind11::array array(pybind11::dtype::of<Scalar>(), shape,
                          reinterpret_cast<const Scalar*>(data.data()), owner);
    array.attr("setflags")(pybind11::arg("write") = false);
    return array;
}

/// mesh_of: from the Python object to its BladeMesh.
template <typename Class, typename MeshOf>
void bind_blade_arrays(Class& bound, MeshOf mesh_of) {
    const auto add = [&]<typename Scalar, typename Member>(const char* name, Scalar,
                                                           Member BladeMesh::*member) {
        bound.def_property_readonly(name, [member, mesh_of](const pybind11::object& self) {
            return view<Scalar>(self, mesh_of(self).*member);
        });
    };
    add("positions_mm", double{}, &BladeMesh::positions_mm);
    add("corner_vertex", std::int32_t{}, &BladeMesh::corner_vertex);
    add("face_start", std::int32_t{}, &BladeMesh::face_start);
    add("face_part", std::uint8_t{}, &BladeMesh::face_part);
    add("corner_normal", float{}, &BladeMesh::corner_normal);
    add("corner_tangent", float{}, &BladeMesh::corner_tangent);
    add("corner_uv", float{}, &BladeMesh::corner_uv);
    add("s_mm", float{}, &BladeMesh::s_mm);
    add("t_mm", float{}, &BladeMesh::t_mm);
}

}  // namespace togishi
