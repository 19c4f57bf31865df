// capture/camera_pose.hpp, capture/project.hpp
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "capture/project.hpp"
#include "capture/silhouette.hpp"
#include "python/blade_parameters.hpp"
#include "python/capture_dict.hpp"
#include "python/map_dict.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

py::dict landmarks_of(const py::object& parameters) {
    const KatanaParameters p = katana_from_python(parameters);
    KatanaMesh mesh;
    {
        const py::gil_scoped_release release;
        constexpr double detail = 0.02;  // a landmark is a vertex at any
        mesh = make_katana(p, detail);
    }
    py::dict places;
    for (const std::string& name : blade_landmark_names()) {
        const glm::dvec3 at = blade_landmark(mesh, name);
        places[py::str(name)] = py::make_tuple(at.x, at.y, at.z);
    }
    return places;
}

py::dict pose(const py::object& landmarks, std::size_t width_px, std::size_t height_px,
              const std::string& kind, const std::vector<double>& facing, double max_residual_mm) {
    constexpr std::size_t most = 100000;
    if (width_px < 1 || height_px < 1 || width_px > most || height_px > most)
        throw InputError("camera", "size",
                         std::to_string(width_px) + " x " + std::to_string(height_px),
                         "1 to 100000 pixels");
    const bool pinhole = kind == "pinhole";
    if (!pinhole && kind != "orthographic")
        throw InputError("camera", "kind", kind, "orthographic, pinhole");
    if (facing.size() != 3) throw InputError("camera", "facing", "no direction", "three numbers");
    const std::vector<Landmark> marks = landmarks_from_list(landmarks);
    const auto width = static_cast<int>(width_px), height = static_cast<int>(height_px);
    CameraFit fit;
    {
        const py::gil_scoped_release release;
        fit = pinhole ? fit_pinhole_camera(marks, width, height, max_residual_mm)
                      : fit_orthographic_camera(marks, width, height,
                                                {facing[0], facing[1], facing[2]}, max_residual_mm);
    }
    return dict_from_fit(fit);
}

py::dict on_outline(const py::object& parameters, const py::object& camera,
                    const py::object& picture, const py::object& landmarks, double search_mm,
                    double detail) {
    const KatanaParameters blade = katana_from_python(parameters);
    const Camera start = camera_from_dict(camera);
    const std::vector<Landmark> marks = landmarks_from_list(landmarks);
    SilhouetteOptions options;
    options.search_mm = search_mm;
    const auto values =
        py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(picture);
    if (!values) throw py::error_already_set();
    if (values.ndim() != 2) throw InputError("picture", "type", "no rows", "(H, W) numbers");
    if (values.shape(0) != start.height_px || values.shape(1) != start.width_px) {
        throw InputError("picture", "size",
                         std::to_string(values.shape(1)) + " x " + std::to_string(values.shape(0)),
                         "that of the camera");
    }
    const std::vector<float> pixels(values.data(), values.data() + values.size());
    SilhouetteFit fit;
    {
        const py::gil_scoped_release release;
        fit = refine_on_silhouette(make_katana(blade, detail), start, pixels, marks, options);
    }
    py::dict d;
    d["camera"] = dict_from_camera(fit.camera);
    d["outline"] = dict_from_outline(fit);
    return d;
}

ProjectedMap photograph_from(const py::handle& mapping, std::size_t number) {
    OptionReader r("photograph " + std::to_string(number), mapping);
    ProjectedMap one;
    const py::object maps = r.object("maps"), camera = r.object("camera"),
                     usable = r.object("usable");
    std::size_t frame = 0;
    r.choice("frame", {"surface", "image"}, frame);
    r.finish();
    if (!py::isinstance<py::dict>(maps))
        throw InputError("photograph " + std::to_string(number), "maps", "missing",
                         "a dict of channels");
    one.maps = maps_from_dict(maps.cast<py::dict>());
    one.camera = camera_from_dict(camera);
    one.frame = frame == 1 ? MapFrame::image : MapFrame::surface;
    if (!usable.is_none()) {
        const auto mask =
            py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>::ensure(usable);
        if (!mask) throw py::error_already_set();
        one.usable.assign(mask.data(), mask.data() + mask.size());
    }
    return one;
}

py::dict project(const py::object& parameters, const py::object& photographs, std::size_t width,
                 std::size_t height, double feather_px, double detail, const py::object& progress) {
    const KatanaParameters blade = katana_from_python(parameters);
    std::vector<ProjectedMap> all;
    for (const auto& one : photographs) all.push_back(photograph_from(one, all.size() + 1));
    ProjectOptions options;
    options.width = width;
    options.height = height;
    options.feather_px = feather_px;
    const ProjectProgress report = progress_of(progress);
    ProjectResult result;
    try {
        const py::gil_scoped_release release;
        result = project_maps(make_katana(blade, detail), all, options, report);
    } catch (const ProjectCancelled&) {
        PyErr_SetString(PyExc_InterruptedError, "capture project: cancelled");
        throw py::error_already_set();
    }
    py::dict d;
    d["maps"] = dict_from_maps(std::move(result.maps));
    d["coverage"] =
        py::array_t<float>({static_cast<py::ssize_t>(height), static_cast<py::ssize_t>(width)},
                           result.coverage.data());
    d["on_blade"] = result.on_blade;
    d["holes"] = result.holes;
    return d;
}

}  // namespace

void bind_capture_project(py::module_& m) {
    m.def("blade_landmarks", &landmarks_of, py::arg("katana_parameters"),
          "Places that every generated blade has: name -> (x, y, z) in mm in the blade's frame.");
    m.def("camera_from_landmarks", &pose, py::arg("landmarks"), py::arg("width_px"),
          py::arg("height_px"), py::arg("kind") = "orthographic",
          py::arg("facing") = std::vector<double>{0, 1, 0}, py::arg("max_residual_mm") = 2.0,
          "The camera of a photograph from places on the blade and where they are in the picture.");
    m.def("camera_on_outline", &on_outline, py::arg("katana_parameters"), py::arg("camera"),
          py::arg("picture"), py::arg("landmarks") = py::list(), py::kw_only(),
          py::arg("search_mm") = SilhouetteOptions{}.search_mm, py::arg("detail") = 1.0,
          "A camera refined on the blade's outline against a plain ground in its photograph.");
    m.def("capture_project", &project, py::arg("katana_parameters"), py::arg("photographs"),
          py::arg("width") = 4096, py::arg("height") = 512, py::kw_only(),
          py::arg("feather_px") = ProjectOptions{}.feather_px, py::arg("detail") = 1.0,
          py::arg("progress") = py::none(),
          "Maps of photographs onto the blade's own chart: each texel from the pixels it covers.");
}

}  // namespace togishi
