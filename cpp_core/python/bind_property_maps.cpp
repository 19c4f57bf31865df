#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bake/map_mips.hpp"
#include "bake/map_repair.hpp"
#include "bake/mip_atlas.hpp"
#include "bake/normal_mips.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "brdf/model.hpp"
#include "python/map_dict.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

using F32 = py::array_t<float, py::array::c_style | py::array::forcecast>;
using F64 = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Shape = std::vector<py::ssize_t>;

std::string shape_text(const py::array& array) {
    std::string text = "(";
    for (py::ssize_t i = 0; i < array.ndim(); ++i)
        text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
    return text + (array.ndim() == 1 ? ",)" : ")");
}

void warn(const std::string& sentence) {
    if (!sentence.empty() && PyErr_WarnEx(PyExc_RuntimeWarning, sentence.c_str(), 1) != 0) {
        throw py::error_already_set();
    }
}

F32 encode_lobe(const F64& mu_t_deg, const F64& mu_b_deg, const F64& rho_deg) {
    // Broadcast as numpy does, by numpy.
    const auto all =
        py::module_::import("numpy").attr("broadcast_arrays")(mu_t_deg, mu_b_deg, rho_deg);
    const F64 t(all[py::int_(0)]), b(all[py::int_(1)]), rho(all[py::int_(2)]);
    Shape shape(t.shape(), t.shape() + t.ndim());
    shape.push_back(3);
    F32 lobes(shape);
    float* out = lobes.mutable_data();
    const double *mu_t = t.data(), *mu_b = b.data(), *azimuth = rho.data();
    const auto count = static_cast<std::size_t>(t.size());
    const py::gil_scoped_release release;
    parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            constexpr double degree = 0.017453292519943295769;
            const f64::Lobe lobe =
                f64::lobe_from_mu(mu_t[i] * degree, mu_b[i] * degree, azimuth[i] * degree);
            out[3 * i] = static_cast<float>(lobe.ln_mu_deg);
            out[3 * i + 1] = static_cast<float>(lobe.e1);
            out[3 * i + 2] = static_cast<float>(lobe.e2);
        }
    });
    return lobes;
}

F64 decode_lobe(const F64& lobe) {
    if (lobe.ndim() < 1 || lobe.shape(lobe.ndim() - 1) != 3) {
        throw InputError("lobe", "shape", shape_text(lobe), "(..., 3)");
    }
    F64 axes(Shape(lobe.shape(), lobe.shape() + lobe.ndim()));
    double* out = axes.mutable_data();
    const double* in = lobe.data();
    const auto count = static_cast<std::size_t>(lobe.size() / 3);
    const py::gil_scoped_release release;
    parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            constexpr double degrees = 57.295779513082320877;
            const f64::LobeAxes a = f64::lobe_axes({in[3 * i], in[3 * i + 1], in[3 * i + 2]});
            out[3 * i] = a.mu_t_rad * degrees;
            out[3 * i + 1] = a.mu_b_rad * degrees;
            out[3 * i + 2] = a.rho_rad * degrees;
        }
    });
    return axes;
}

py::list map_mip_levels(const py::dict& maps) {
    PropertyMaps map = maps_from_dict(maps);
    std::vector<PropertyMaps> levels;
    MapRepair repair;
    {
        const py::gil_scoped_release release;
        if (!is_valid(view_of(map))) repair = repair_map(map);
        levels = coarser_levels(view_of(map));
    }
    warn(repair.sentence("property maps"));
    py::list all;
    all.append(dict_from_maps(std::move(map)));
    for (PropertyMaps& level : levels) all.append(dict_from_maps(std::move(level)));
    return all;
}

// numpy.float16 from raw halves: pybind11 has no half type of its own.
py::array half_array(std::size_t height, std::size_t width, py::ssize_t channels = 4) {
    return py::array(py::dtype("float16"), Shape{static_cast<py::ssize_t>(height),
                                                 static_cast<py::ssize_t>(width), channels});
}

py::array_t<std::int32_t> rectangles_of(const AtlasLayout& layout) {
    py::array_t<std::int32_t> rectangles(Shape{static_cast<py::ssize_t>(layout.levels.size()), 4});
    auto* rectangle = rectangles.mutable_data();
    for (const AtlasLevel& level : layout.levels) {
        for (const std::size_t value : {level.x, level.y, level.width, level.height}) {
            *rectangle++ = static_cast<std::int32_t>(value);
        }
    }
    return rectangles;
}

constexpr std::array<MapChannel, 4> lobes_rgba{MapChannel::ji_ln_mu_deg, MapChannel::ha_ln_mu_deg,
                                               MapChannel::w, MapChannel::h};
constexpr std::array<MapChannel, 4> shape_rgba{MapChannel::ji_e1, MapChannel::ji_e2,
                                               MapChannel::ha_e1, MapChannel::ha_e2};

void check_image(const char* name, const F32& image) {
    if (image.ndim() != 3 || image.shape(2) != 4 || image.size() == 0) {
        throw InputError(name, "shape", shape_text(image), "(height, width, 4), none of them 0");
    }
}

py::tuple pack_mip_atlas(const F32& lobes, const std::optional<F32>& shape) {
    check_image("lobes", lobes);
    MapView view;
    view.height = static_cast<std::size_t>(lobes.shape(0));
    view.width = static_cast<std::size_t>(lobes.shape(1));
    for (std::size_t c = 0; c < 4; ++c) view[lobes_rgba[c]] = {lobes.data() + c, 4};
    if (shape) {
        check_image("shape", *shape);
        if (shape->shape(0) != lobes.shape(0) || shape->shape(1) != lobes.shape(1)) {
            throw InputError("shape", "size", shape_text(*shape),
                             "the size of lobes, " + shape_text(lobes));
        }
        for (std::size_t c = 0; c < 4; ++c) view[shape_rgba[c]] = {shape->data() + c, 4};
    }
    const AtlasLayout layout = atlas_layout(view.width, view.height);
    py::array lobes_atlas = half_array(layout.height, layout.width);
    py::object shape_atlas =
        shape ? py::object(half_array(layout.height, layout.width)) : py::none();
    auto* lobes_out = static_cast<std::uint16_t*>(lobes_atlas.mutable_data());
    auto* shape_out =
        shape ? static_cast<std::uint16_t*>(shape_atlas.cast<py::array>().mutable_data()) : nullptr;
    MapRepair repair;
    {
        const py::gil_scoped_release release;
        PropertyMaps mended;
        if (!is_valid(view)) {
            mended = copy_of(view);
            repair = repair_map(mended);
            view = view_of(mended);
        }
        const std::vector<PropertyMaps> coarse = coarser_levels(view);
        std::vector<MapView> levels{view};
        for (const PropertyMaps& level : coarse) levels.push_back(view_of(level));
        const std::size_t halves = layout.width * layout.height * 4;
        std::fill_n(lobes_out, halves, std::uint16_t{0});
        fill_atlas(layout, levels, lobes_rgba, lobes_out);
        if (shape_out != nullptr) {
            std::fill_n(shape_out, halves, std::uint16_t{0});
            fill_atlas(layout, levels, shape_rgba, shape_out);
        }
    }
    warn(repair.sentence("blade maps"));
    return py::make_tuple(lobes_atlas, shape_atlas, rectangles_of(layout));
}

py::tuple pack_normal_atlas(const F32& image) {
    if (image.ndim() != 3 || image.shape(2) < 3 || image.size() == 0) {
        throw InputError("normal map", "shape", shape_text(image),
                         "(height, width, 3 or more), none of them 0");
    }
    NormalMapView map;
    map.rgb = image.data();
    map.height = static_cast<std::size_t>(image.shape(0));
    map.width = static_cast<std::size_t>(image.shape(1));
    map.texel_stride = static_cast<std::size_t>(image.shape(2));
    const AtlasLayout layout = atlas_layout(map.width, map.height);
    py::array leans = half_array(layout.height, layout.width);
    py::array correlations = half_array(layout.height, layout.width, 1);
    auto* leans_out = static_cast<std::uint16_t*>(leans.mutable_data());
    auto* correlations_out = static_cast<std::uint16_t*>(correlations.mutable_data());
    NormalRepair repair;
    {
        const py::gil_scoped_release release;
        const std::vector<NormalLevel> levels = normal_levels(map, repair);
        std::fill_n(leans_out, layout.width * layout.height * 4, std::uint16_t{0});
        std::fill_n(correlations_out, layout.width * layout.height, std::uint16_t{0});
        fill_normal_atlas(layout, levels, leans_out, correlations_out);
    }
    warn(repair.sentence("normal map"));
    return py::make_tuple(leans, correlations, rectangles_of(layout));
}

}  // namespace

void bind_property_maps(py::module_& m) {
    py::list names;
    for (const auto name : map_channel_names) names.append(std::string(name));
    m.attr("MAP_CHANNELS") = names;
    m.def("encode_lobe", &encode_lobe, py::arg("mu_t_deg"), py::arg("mu_b_deg"), py::arg("rho_deg"),
          "(..., 3) of ln_mu_deg, e1, e2 from half widths and azimuth in degrees, which are "
          "broadcast.\n"
          "Half widths are brought into 0.001 to 80 degrees and 100:1; NaN becomes 1 degree.");
    m.def("decode_lobe", &decode_lobe, py::arg("lobe"),
          "(..., 3) of mu_t_deg, mu_b_deg, rho_deg in [0, 180) from (..., 3) encoded lobes.");
    m.def("map_mip_levels", &map_mip_levels, py::arg("maps"),
          "Levels 0 (the map itself) to 1 x 1 by covariance. maps: channel name -> (H, W), or (1, "
          "1) for a\n"
          "constant channel; at least ji.ln_mu_deg, ha.ln_mu_deg, w. NaN and infinity are replaced "
          "by the\n"
          "nearest valid value and counted in a RuntimeWarning.");
    m.def("pack_mip_atlas", &pack_mip_atlas, py::arg("lobes"), py::arg("shape") = py::none(),
          "Blade images (H, W, 4) -> (lobes atlas, shape atlas or None, (levels, 4) of x, y, "
          "width, height):\n"
          "half floats with all mip levels, each framed by one texel that repeats its border.");
    m.def("pack_normal_atlas", &pack_normal_atlas, py::arg("image"),
          "Normal map (H, W, 3 or more), 0.5 + 0.5 n -> (leans atlas (H', W', 4): mean lean and "
          "standard\n"
          "deviation along u and v; correlations atlas (H', W', 1); (levels, 4) as "
          "pack_mip_atlas).");
}

}  // namespace togishi
