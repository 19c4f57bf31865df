// capture/diffuse_setup.hpp, capture/diffuse_run.hpp
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "capture/diffuse_run.hpp"
#include "python/capture_dict.hpp"
#include "python/map_dict.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

using F32 = py::array_t<float, py::array::c_style | py::array::forcecast>;
using SharedSetup = std::shared_ptr<CaptureSetup>;

struct Chosen {
    DiffuseOptions options;
    bool geometry = true;
};

Chosen chosen_from(CaptureSetup& setup, const py::object& mapping) {
    OptionReader r("capture diffuse", mapping);
    Chosen chosen;
    bool no_geometry = false, hadori = false;
    r.text("material", setup.material);
    r.truth("hadori", hadori);
    r.truth("no_geometry", no_geometry);
    DiffuseOptions& o = chosen.options;
    r.number("spread", o.spread);
    r.number("known_spread", o.known_spread);
    r.number("model_error", o.model_error);
    r.number("max_sigma_w", o.max_sigma_w);
    r.number("max_sigma_ln_mu", o.max_sigma_ln_mu);
    r.number("border_px", o.border_px);
    std::size_t threads = 0;
    r.whole("threads", threads);
    o.threads = static_cast<unsigned>(threads);
    r.finish();
    take_material(setup, hadori, o);
    chosen.geometry = !no_geometry && has_geometry(setup);
    return chosen;
}

// A Python callable as the reader of pictures: path -> (values, whole_numbers).
CapturePictureReader reader_of(const py::object& read_picture) {
    return [&read_picture](const std::filesystem::path& path) {
        const py::gil_scoped_acquire acquire;
        const py::object answer = read_picture(path.string());
        const std::string where = path.string();
        if (!py::isinstance<py::tuple>(answer) || py::len(answer) != 2)
            throw InputError(where, "picture",
                             py::cast<std::string>(py::repr(py::type::of(answer))),
                             "a pair of an array and whether its file holds whole numbers");
        const auto values = F32::ensure(answer[py::int_(0)]);
        if (!values || (values.ndim() != 2 && values.ndim() != 3) || values.size() == 0) {
            PyErr_Clear();
            throw InputError(where, "picture", "no array of numbers", "(H, W) or (H, W, C)");
        }
        CapturePicture picture;
        picture.height = static_cast<int>(values.shape(0));
        picture.width = static_cast<int>(values.shape(1));
        picture.channels = values.ndim() == 3 ? static_cast<int>(values.shape(2)) : 1;
        picture.values.assign(values.data(), values.data() + values.size());
        picture.whole_numbers = py::cast<bool>(py::bool_(answer[py::int_(1)]));
        return picture;
    };
}

py::array plane(const std::vector<float>& values, const DiffuseResult& result) {
    return py::array_t<float>(
        {static_cast<py::ssize_t>(result.height), static_cast<py::ssize_t>(result.width)},
        values.data());
}

py::list list_of(const std::vector<double>& values) {
    py::list list;
    for (const double v : values) list.append(v);
    return list;
}

py::list list_of(const std::vector<std::string>& values) {
    py::list list;
    for (const std::string& v : values) list.append(v);
    return list;
}

py::dict plan_of(const CaptureSetup& given, const py::object& options) {
    CaptureSetup setup = given;
    const Chosen chosen = chosen_from(setup, options);
    DiffusePlan plan;
    Picture picture;
    {
        const py::gil_scoped_release release;
        plan = plan_setup(setup, chosen.options);
        picture = plot_plan(plan);
    }
    py::dict d;
    d["mu_deg"] = list_of(plan.mu_deg);
    d["mu_share"] = list_of(plan.mu_share);
    d["sigma_ln_mu"] = list_of(plan.sigma_ln_mu);
    d["w_share"] = plan.w_share;
    d["blind"] = plan.blind;
    d["sentences"] = list_of(plan.sentences);
    py::list photographs;
    for (const DiffusePlanCurve& curve : plan.photographs) {
        py::dict one;
        one["radiance"] = list_of(curve.radiance);
        one["flat_at_deg"] = list_of(curve.flat_at_deg);
        photographs.append(one);
    }
    d["photographs"] = photographs;
    d["picture"] = array_of(picture);
    return d;
}

py::object camera_of(const CaptureSetup& setup) {
    return setup.camera ? py::object(dict_from_camera(*setup.camera)) : py::object(py::none());
}

py::object outline_of(const CaptureSetup& setup) {
    return setup.silhouette_fit ? py::object(dict_from_outline(*setup.silhouette_fit))
                                : py::object(py::none());
}

py::dict dict_from_result(const CaptureSetup& setup, const DiffuseOptions& options,
                          const DiffuseResult& result) {
    PropertyMaps maps;
    Picture w, mu;
    {
        const py::gil_scoped_release release;
        maps = diffuse_maps(result, options);
        w = picture_of_w(result);
        mu = picture_of_mu(result);
    }
    py::dict d, quality, masked, pictures;
    d["maps"] = dict_from_maps(std::move(maps));
    quality["sigma.w"] = plane(result.sigma_w, result);
    quality["sigma.ji.ln_mu_deg"] = plane(result.sigma_ji, result);
    quality["sigma.ha.ln_mu_deg"] = plane(result.sigma_ha, result);
    quality["sigma.h"] = plane(result.sigma_h, result);
    quality["chi2"] = plane(result.chi2, result);
    quality["mask"] = py::array_t<std::uint8_t>(
        {static_cast<py::ssize_t>(result.height), static_cast<py::ssize_t>(result.width)},
        result.mask.data());
    d["quality"] = quality;
    for (const auto& [bit, name] : diffuse_mask_names)
        masked[py::str(std::string(name))] = result.masked(bit);
    d["masked"] = masked;
    d["seen"] = result.seen();
    d["masked_w"] = result.masked(mask_no_w);
    d["masked_mu"] = result.masked(mask_no_mu);
    py::array_t<bool> usable(
        {static_cast<py::ssize_t>(result.height), static_cast<py::ssize_t>(result.width)});
    for (std::size_t i = 0; i < result.mask.size(); ++i)
        usable.mutable_data()[i] = (result.mask[i] & mask_no_w) == 0;
    d["usable"] = usable;
    d["mu_measured"] = result.mu_measured;
    d["calibration"] = result.calibration;
    d["source"] = source_text(setup, result);
    d["camera"] = camera_of(setup);
    d["outline"] = outline_of(setup);
    d["notes"] = list_of(result.notes);
    pictures["w"] = array_of(w);
    if (result.mu_measured) pictures["mu"] = array_of(mu);
    d["pictures"] = pictures;
    return d;
}

py::dict run(const CaptureSetup& given, const py::object& read_picture, const py::object& options,
             const py::object& progress) {
    CaptureSetup setup = given;
    const Chosen chosen = chosen_from(setup, options);
    const DiffuseProgress report = progress_of(progress);
    const CapturePictureReader read = reader_of(read_picture);
    DiffuseResult result;
    try {
        const py::gil_scoped_release release;
        if (chosen.geometry) refine_camera(setup, read);
        result = evaluate_setup(setup, chosen.options, chosen.geometry, read, report);
    } catch (const DiffuseCancelled&) {
        PyErr_SetString(PyExc_InterruptedError, "capture diffuse: cancelled");
        throw py::error_already_set();
    }
    return dict_from_result(setup, chosen.options, result);
}

SharedSetup refined(const CaptureSetup& given, const py::object& read_picture) {
    auto setup = std::make_shared<CaptureSetup>(given);
    const CapturePictureReader read = reader_of(read_picture);
    const py::gil_scoped_release release;
    refine_camera(*setup, read);
    return setup;
}

py::object silhouette_of(const CaptureSetup& setup) {
    if (setup.silhouette.file.empty()) return py::none();
    return py::str(setup.path_of(setup.silhouette.file).string());
}

py::object fit_of(const CaptureSetup& setup) {
    return setup.camera_fit ? py::object(dict_from_fit(*setup.camera_fit)) : py::object(py::none());
}

std::string surface_of(const CaptureSetup& setup) {
    struct Name {
        std::string operator()(const NoSurface&) const { return "none"; }
        std::string operator()(const Plate&) const { return "plate"; }
        std::string operator()(const PlaneSurface&) const { return "plane"; }
        std::string operator()(const BladeSurface&) const { return "blade"; }
    };
    return std::visit(Name{}, setup.surface);
}

py::list landmarks_of(const CaptureSetup& setup) {
    py::list list;
    for (const Landmark& l : setup.landmarks) {
        py::dict d;
        d["name"] = l.name;
        d["point_mm"] = py::make_tuple(l.point_mm.x, l.point_mm.y, l.point_mm.z);
        d["pixel"] = py::make_tuple(l.pixel.x, l.pixel.y);
        list.append(d);
    }
    return list;
}

py::list files_of(const CaptureSetup& setup) {
    py::list list;
    for (const PhotographSetup& p : setup.photographs)
        list.append(p.file.empty() ? std::string() : setup.path_of(p.file).string());
    return list;
}

}  // namespace

void bind_capture_diffuse(py::module_& m) {
    py::class_<CaptureSetup, SharedSetup>(
        m, "CaptureSetup", "Photographs under diffuse light and how they were taken. Read-only.")
        .def_property_readonly("file", [](const CaptureSetup& s) { return s.file.string(); })
        .def_readonly("material", &CaptureSetup::material)
        .def_property_readonly("surface", &surface_of)
        .def_property_readonly("camera", &camera_of)
        .def_property_readonly("camera_fit", &fit_of)
        .def_property_readonly("landmarks", &landmarks_of)
        .def_property_readonly("silhouette", &silhouette_of)
        .def_property_readonly("outline", &outline_of)
        .def_property_readonly("files", &files_of)
        .def("to_toml", &capture_setup_to_toml, "Text that parse_capture_setup reads back.");
    m.def(
        "parse_capture_setup",
        [](const std::string& text, const std::string& name) {
            const py::gil_scoped_release release;
            return std::make_shared<CaptureSetup>(capture_setup_from_toml(text, name));
        },
        py::arg("text"), py::arg("name") = "text",
        "The text of a set-up (cpp_core/capture/diffuse_setup.hpp lists every key). name: where "
        "it came from;\nits folder is where pictures are looked for.");
    m.def(
        "read_capture_setup",
        [](const std::string& path) {
            const py::gil_scoped_release release;
            return std::make_shared<CaptureSetup>(read_capture_setup(path));
        },
        py::arg("path"), "A set-up's file (TOML). InputError names file, line and field.");
    m.def("refine_capture_camera", &refined, py::arg("setup"), py::arg("read_picture"),
          "The set-up with its camera refined on the outline in the picture that it names.");
    m.def("capture_diffuse_plan", &plan_of, py::arg("setup"), py::arg("options") = py::dict(),
          "What the set-up can tell, before anything is photographed; no picture is read.");
    m.def("capture_diffuse", &run, py::arg("setup"), py::arg("read_picture"),
          py::arg("options") = py::dict(), py::kw_only(), py::arg("progress") = py::none(),
          "Maps of w and half widths from photographs under diffuse light. progress: called with "
          "the share done;\nreturning False cancels (InterruptedError).");
}

}  // namespace togishi
