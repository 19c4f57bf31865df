#include "python/capture_dict.hpp"

#include <cmath>

#include "base/error.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

std::string shown(const py::handle& value) {
    return py::cast<std::string>(py::repr(value));
}

double number_from(const std::string& where, const std::string& field, const py::handle& value) {
    const bool text = py::isinstance<py::str>(value) || py::isinstance<py::bool_>(value);
    const double number = text ? 0 : PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr || text) {
        PyErr_Clear();
        throw InputError(where, field, shown(value), "a number");
    }
    if (!std::isfinite(number)) throw InputError(where, field, shown(value), "a finite number");
    return number;
}

template <int N>
py::tuple tuple_of(const glm::vec<N, double>& v) {
    py::tuple t(N);
    for (int i = 0; i < N; ++i) t[static_cast<std::size_t>(i)] = v[i];
    return t;
}

glm::dvec3 vector3(const std::vector<double>& v) {
    return {v[0], v[1], v[2]};
}

}  // namespace

OptionReader::OptionReader(std::string where, const py::handle& mapping)
    : where_(std::move(where)) {
    if (PyMapping_Check(mapping.ptr()) == 0 || !py::hasattr(mapping, "keys"))
        throw InputError(where_, "type", shown(py::type::of(mapping)), "a dict");
    left_ = py::dict(py::reinterpret_borrow<py::object>(mapping));
    // The caller's stays as it is.
    left_ = left_.attr("copy")().cast<py::dict>();
}

py::object OptionReader::object(const char* key) {
    known_ += (known_.empty() ? "" : ", ") + std::string(key);
    return left_.attr("pop")(key, py::none());
}

bool OptionReader::number(const char* key, double& target) {
    const py::object value = object(key);
    if (value.is_none()) return false;
    target = number_from(where_, key, value);
    return true;
}

bool OptionReader::truth(const char* key, bool& target) {
    const py::object value = object(key);
    if (value.is_none()) return false;
    if (!py::isinstance<py::bool_>(value))
        throw InputError(where_, key, shown(value), "True or False");
    target = py::cast<bool>(value);
    return true;
}

bool OptionReader::text(const char* key, std::string& target) {
    const py::object value = object(key);
    if (value.is_none()) return false;
    if (!py::isinstance<py::str>(value)) throw InputError(where_, key, shown(value), "text");
    target = py::cast<std::string>(value);
    return true;
}

bool OptionReader::choice(const char* key, const std::vector<std::string>& names,
                          std::size_t& target) {
    std::string value;
    if (!text(key, value)) return false;
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == value) {
            target = i;
            return true;
        }
        all += (i > 0 ? ", " : "") + names[i];
    }
    throw InputError(where_, key, value, all);
}

bool OptionReader::whole(const char* key, std::size_t& target) {
    double value = 0;
    if (!number(key, value)) return false;
    constexpr double most = 1e9;
    if (!(value >= 0 && value <= most && value == std::floor(value)))
        throw InputError(where_, key, std::to_string(value), "a whole number, 0 to 1000000000");
    target = static_cast<std::size_t>(value);
    return true;
}

bool OptionReader::numbers(const char* key, std::size_t count, std::vector<double>& target) {
    const py::object value = object(key);
    if (value.is_none()) return false;
    const std::string allowed = std::to_string(count) + " numbers";
    if (py::isinstance<py::str>(value) || PySequence_Check(value.ptr()) == 0 ||
        py::len(value) != count)
        throw InputError(where_, key, shown(value), allowed);
    target.clear();
    target.reserve(count);
    for (const auto& item : value) target.push_back(number_from(where_, key, item));
    return true;
}

void OptionReader::finish() const {
    for (const auto& [key, value] : left_) throw InputError(where_, "key", shown(key), known_);
}

Camera camera_from_dict(const py::handle& mapping) {
    OptionReader r("camera", mapping);
    Camera camera;
    std::size_t kind = 0, width = 0, height = 0;
    r.choice("kind", {"orthographic", "pinhole"}, kind);
    camera.pinhole = kind == 1;
    r.whole("width_px", width);
    r.whole("height_px", height);
    camera.width_px = static_cast<int>(width);
    camera.height_px = static_cast<int>(height);
    r.number("scale", camera.scale);
    camera.centre_px = glm::dvec2(camera.width_px, camera.height_px) * 0.5;
    std::vector<double> v;
    if (r.numbers("centre_px", 2, v)) camera.centre_px = {v[0], v[1]};
    if (r.numbers("position_mm", 3, v)) camera.position_mm = vector3(v);
    if (r.numbers("right", 3, v)) camera.right = vector3(v);
    if (r.numbers("down", 3, v)) camera.down = vector3(v);
    r.finish();
    check_camera(camera, "camera");
    return camera;
}

py::dict dict_from_camera(const Camera& camera) {
    py::dict d;
    d["kind"] = camera.pinhole ? "pinhole" : "orthographic";
    d["width_px"] = camera.width_px;
    d["height_px"] = camera.height_px;
    d["scale"] = camera.scale;
    d["centre_px"] = tuple_of<2>(camera.centre_px);
    d["position_mm"] = tuple_of<3>(camera.position_mm);
    d["right"] = tuple_of<3>(camera.right);
    d["down"] = tuple_of<3>(camera.down);
    return d;
}

std::vector<Landmark> landmarks_from_list(const py::handle& list) {
    if (py::isinstance<py::str>(list) || PySequence_Check(list.ptr()) == 0)
        throw InputError("landmarks", "type", shown(py::type::of(list)), "a list of dicts");
    std::vector<Landmark> landmarks;
    landmarks.reserve(py::len(list));
    for (const auto& item : list) {
        OptionReader r("landmark " + std::to_string(landmarks.size() + 1), item);
        Landmark one;
        std::vector<double> point, pixel;
        r.text("name", one.name);
        if (!r.numbers("point_mm", 3, point) || !r.numbers("pixel", 2, pixel))
            throw InputError("landmark " + std::to_string(landmarks.size() + 1), "place", "missing",
                             "point_mm and pixel");
        r.finish();
        one.point_mm = vector3(point);
        one.pixel = {pixel[0], pixel[1]};
        landmarks.push_back(std::move(one));
    }
    return landmarks;
}

py::dict dict_from_fit(const CameraFit& fit) {
    py::dict d;
    d["camera"] = dict_from_camera(fit.camera);
    py::list px, mm;
    for (const double r : fit.residual_px) px.append(r);
    for (const double r : fit.residual_mm) mm.append(r);
    d["residual_px"] = px;
    d["residual_mm"] = mm;
    d["rms_mm"] = fit.rms_mm;
    return d;
}

py::dict dict_from_outline(const SilhouetteFit& fit) {
    py::dict d;
    d["rms_mm"] = fit.rms_mm;
    d["p90_mm"] = fit.p90_mm;
    d["before_rms_mm"] = fit.before_rms_mm;
    d["points"] = fit.points;
    d["outline"] = fit.outline;
    return d;
}

std::function<bool(double)> progress_of(const py::object& progress) {
    if (progress.is_none()) return {};
    return [&progress](double done) {
        const py::gil_scoped_acquire acquire;
        return progress(done).ptr() != Py_False;
    };
}

py::array_t<std::uint8_t> array_of(const Picture& picture) {
    return py::array_t<std::uint8_t>({picture.height, picture.width, 3}, picture.rgb.data());
}

}  // namespace togishi
