// capture/tile_run.hpp, capture/stack_maps.hpp
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "capture/photograph_signal.hpp"
#include "capture/stack_maps.hpp"
#include "capture/tile_run.hpp"
#include "python/capture_dict.hpp"
#include "python/map_dict.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

using F32 = py::array_t<float, py::array::c_style | py::array::forcecast>;

struct Chosen {
    LightFile lights;
    std::vector<std::string> pictures;  // exposure by exposure
    StackRunOptions run;
    SignalOptions signal;
    bool has_origin = false;
};

glm::dvec3 vector3(const std::vector<double>& v) {
    return {v[0], v[1], v[2]};
}

void read_brackets(const py::object& list, const LightFileOptions& how, Chosen& chosen) {
    if (list.is_none()) return;
    for (const auto& item : list) {
        if (!py::isinstance<py::sequence>(item) || py::isinstance<py::str>(item) ||
            py::len(item) != 2)
            throw InputError("capture lights", "brackets", py::cast<std::string>(py::repr(item)),
                             "pairs of an .lp file and its light over that of the first");
        const auto pair = py::cast<py::sequence>(item);
        const LightFile other =
            read_light_bracket(py::cast<std::string>(pair[0]), chosen.lights, how);
        for (const LightEntry& light : other.lights)
            chosen.pictures.push_back(light.image.string());
        chosen.run.exposures.push_back(py::cast<double>(pair[1]));
    }
}

Chosen chosen_from(const std::string& path, const py::object& mapping) {
    OptionReader r("capture lights", mapping);
    Chosen chosen;
    LightFileOptions how;
    r.truth("positions", how.positions_mm);
    r.truth("intensities", how.intensity_column);
    chosen.lights = read_light_file(path, how);
    for (const LightEntry& light : chosen.lights.lights)
        chosen.pictures.push_back(light.image.string());
    read_brackets(r.object("brackets"), how, chosen);
    StackRunOptions& o = chosen.run;
    std::size_t model = 1, effort = 2, transfer = 0, threads = 0;
    r.choice("model", {"ji", "hamon"}, model);
    o.stack.model = static_cast<LobeModel>(model);
    r.choice("effort", {"moments", "log-linear", "full"}, effort);
    o.effort = static_cast<PixelEffort>(effort);
    r.choice("transfer", {"linear", "srgb"}, transfer);
    chosen.signal.transfer = static_cast<Transfer>(transfer);
    r.number("black", chosen.signal.black);
    r.number("clip", chosen.signal.clip);
    r.number("mm_per_pixel", o.stack.mm_per_pixel);
    r.number("camera_distance_mm", o.stack.camera_distance_mm);
    r.text("metal", o.stack.metal);
    r.text("light", o.stack.light);
    r.number("light_error_deg", o.stack.light_error_deg);
    std::vector<double> v;
    if (r.numbers("view", 3, v)) o.stack.view = vector3(v);
    if (r.numbers("normal", 3, v)) o.normal = vector3(v);
    if (r.numbers("origin_px", 2, v)) {
        o.stack.origin_px = {v[0], v[1]};
        chosen.has_origin = true;
    }
    r.truth("self_calibrate", o.self_calibration);
    r.number("snr", o.snr);
    r.number("read_noise", o.read_noise);
    r.truth("pedestal", o.pedestal);
    r.number("haze_width", o.haze_width);
    WhitePatch white;
    r.number("white_reflectance", white.reflectance);
    if (r.numbers("white_patch", 4, v)) {
        for (const double n : v) {
            constexpr double most = 1e6;
            if (!(n >= 0 && n <= most && n == std::floor(n)))
                throw InputError("capture lights", "white_patch", std::to_string(n),
                                 "whole numbers, 0 to 1000000");
        }
        white.left = static_cast<std::size_t>(v[0]);
        white.top = static_cast<std::size_t>(v[1]);
        white.width = static_cast<std::size_t>(v[2]);
        white.height = static_cast<std::size_t>(v[3]);
        o.white = white;
    }
    LobePrior prior;
    r.number("prior_sigma", prior.sigma_ln_mu);
    if (r.numbers("prior", 3, v)) {
        prior.mu_t_deg = v[0];
        prior.mu_b_deg = v[1];
        prior.rho_deg = v[2];
        o.prior = prior;
    }
    double memory_mib = 256;
    r.number("memory_mib", memory_mib);
    constexpr double least_mib = 16, most_mib = 1 << 20;
    if (!(memory_mib >= least_mib && memory_mib <= most_mib))
        throw InputError("capture lights", "memory_mib", std::to_string(memory_mib),
                         "16 to 1048576 MiB");
    o.memory_bytes = static_cast<std::size_t>(memory_mib * 1048576);
    r.whole("band_rows", o.band_rows);
    r.whole("threads", threads);
    o.threads = static_cast<unsigned>(threads);
    r.finish();
    check_signal(chosen.signal);
    return chosen;
}

// Nothing is read for a plan, but the number of pictures is checked.
class NoPhotographs : public TileReader {
  public:
    explicit NoPhotographs(std::size_t images) : images_(images) {}
    [[nodiscard]] std::size_t width() const override { return cell_pixels; }
    [[nodiscard]] std::size_t height() const override { return cell_pixels; }
    [[nodiscard]] std::size_t images() const override { return images_; }
    [[nodiscard]] double quantisation_variance() const override { return 0; }
    [[nodiscard]] std::string fingerprint() const override { return {}; }
    void read(std::size_t, std::size_t, std::size_t, float*, std::uint8_t*) override {}

  private:
    std::size_t images_;
};

// An object of the caller's that reads rows; it is asked from several threads, one at a time.
class PythonPhotographs : public TileReader {
  public:
    PythonPhotographs(py::object reader, SignalOptions signal, std::vector<std::string> names)
        : reader_(std::move(reader)), signal_(signal), names_(std::move(names)) {
        width_ = py::cast<std::size_t>(reader_.attr("width"));
        height_ = py::cast<std::size_t>(reader_.attr("height"));
        step_ = py::cast<double>(reader_.attr("step"));
        fingerprint_ = py::cast<std::string>(reader_.attr("fingerprint"));
        constexpr std::size_t most = 200'000;
        if (width_ < 1 || height_ < 1 || width_ > most || height_ > most)
            throw InputError("photographs", "size",
                             std::to_string(width_) + " x " + std::to_string(height_),
                             "1 to 200000 pixels either way");
        if (!(step_ >= 0 && step_ <= 1))
            throw InputError("photographs", "step", std::to_string(step_), "0 to 1");
        fingerprint_ += "\n" + std::to_string(static_cast<int>(signal_.transfer)) + " " +
                        std::to_string(signal_.black) + " " + std::to_string(signal_.clip);
    }
    // Lives where the GIL is held: it owns a Python object.
    [[nodiscard]] std::size_t width() const override { return width_; }
    [[nodiscard]] std::size_t height() const override { return height_; }
    [[nodiscard]] std::size_t images() const override { return names_.size(); }
    [[nodiscard]] double quantisation_variance() const override { return step_ * step_ / 12; }
    [[nodiscard]] std::string fingerprint() const override { return fingerprint_; }

    void read(std::size_t image, std::size_t begin, std::size_t end, float* values,
              std::uint8_t* clipped) override {
        const py::gil_scoped_acquire acquire;
        const auto rows = F32::ensure(reader_.attr("read")(image, begin, end));
        const std::size_t count = end - begin;
        const bool fits = rows && (rows.ndim() == 2 || rows.ndim() == 3) &&
                          static_cast<std::size_t>(rows.shape(0)) == count &&
                          static_cast<std::size_t>(rows.shape(1)) == width_;
        if (!fits) {
            PyErr_Clear();
            throw InputError(names_[image],
                             "rows " + std::to_string(begin) + " to " + std::to_string(end - 1),
                             "no array of that many rows", "(rows, width) or (rows, width, C)");
        }
        StoredRows stored;
        stored.values = rows.data();
        stored.pixels = count * width_;
        stored.stride = rows.ndim() == 3 ? static_cast<std::size_t>(rows.shape(2)) : 1;
        stored.step = step_;
        // Grey, perhaps with alpha; else red, green and blue first.
        stored.channels =
            stored.stride < 3 ? std::vector<std::size_t>{0} : std::vector<std::size_t>{0, 1, 2};
        const py::gil_scoped_release release;
        to_signal(stored, signal_, values, clipped);
    }

  private:
    py::object reader_;
    SignalOptions signal_;
    std::vector<std::string> names_;
    std::size_t width_ = 0, height_ = 0;
    double step_ = 0;
    std::string fingerprint_;
};

// Asks the caller ten times a second whether to go on, so that a stop does not wait for a band.
class Watch {
  public:
    Watch(const py::object& progress, std::atomic<bool>& stop) : progress_(progress), stop_(stop) {
        if (!progress.is_none()) thread_ = std::thread([this] { watch(); });
    }
    ~Watch() { end(); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    void done(double share) { share_ = share; }
    void end() {
        {
            const std::lock_guard lock(mutex_);
            over_ = true;
        }
        wake_.notify_all();
        if (thread_.joinable()) thread_.join();
    }
    // What the callable raised; the GIL is held.
    void rethrow() const {
        if (error_) std::rethrow_exception(error_);
    }

  private:
    void watch() {
        using namespace std::chrono_literals;
        std::unique_lock lock(mutex_);
        while (!over_) {
            lock.unlock();
            ask();
            lock.lock();
            wake_.wait_for(lock, 100ms, [this] { return over_; });
        }
    }
    void ask() {
        const py::gil_scoped_acquire acquire;
        try {
            if (progress_(share_.load()).ptr() == Py_False) stop_ = true;
        } catch (const py::error_already_set&) {
            if (!error_) error_ = std::current_exception();
            stop_ = true;
        }
    }

    const py::object& progress_;
    std::atomic<bool>& stop_;
    std::atomic<double> share_{0};
    std::mutex mutex_;
    std::condition_variable wake_;
    bool over_ = false;
    std::exception_ptr error_;
    std::thread thread_;
};

// What a run has finished, on disk beside its target.
struct CaptureTiles {
    TileStore store;
    StackRunReport report;
    LobeModel model;

    [[nodiscard]] std::vector<float> whole() {
        std::vector<float> pixels;
        pixels.reserve(store.width() * store.height() * store.channels());
        for (std::size_t b = 0; b < store.bands(); ++b) {
            const std::vector<float> band = store.read(b);
            pixels.insert(pixels.end(), band.begin(), band.end());
        }
        return pixels;
    }
};

py::dict dict_from_reach(const StackReach& r) {
    py::dict d;
    d["spacing_deg"] = r.spacing_deg;
    d["reach_deg"] = r.reach_deg;
    d["mu_sure_deg"] = r.mu_sure_deg;
    d["mu_mostly_deg"] = r.mu_mostly_deg;
    d["mu_widest_deg"] = r.mu_widest_deg;
    return d;
}

py::dict report_of(const CaptureTiles& tiles) {
    static constexpr std::array<const char*, 7> reasons{
        "uncertain",        "misfit",   "few_samples", "at_bound",
        "rejected_samples", "inferred", "missing"};
    const StackRunReport& r = tiles.report;
    py::dict d, why;
    d["reach"] = dict_from_reach(r.reach);
    d["lights"] = r.lights;
    d["pictures"] = r.pictures;
    d["bands_resumed"] = r.bands_resumed;
    d["flagged"] = r.flagged;
    d["inferred"] = r.inferred;
    for (std::size_t i = 0; i < reasons.size(); ++i) why[reasons[i]] = r.reasons[i];
    d["reasons"] = why;
    d["calibration_rms_deg"] =
        r.calibration ? py::object(py::float_(r.calibration->rms_deg)) : py::object(py::none());
    d["seconds_reading"] = r.seconds_reading;
    d["seconds_fitting"] = r.seconds_fitting;
    return d;
}

py::dict plan(const std::string& path, const py::object& options) {
    const Chosen chosen = chosen_from(path, options);
    NoPhotographs none(chosen.pictures.size());
    const StackReach reach = StackRun(chosen.lights, none, chosen.run).reach();
    py::dict d = dict_from_reach(reach);
    d["lights"] = chosen.lights.lights.size();
    d["pictures"] = chosen.pictures;
    d["sentence"] = reach_sentence(reach, chosen.lights.lights.size());
    return d;
}

std::shared_ptr<CaptureTiles> run(const std::string& path, const py::object& photographs,
                                  const std::string& target, const py::object& options,
                                  const py::object& progress) {
    Chosen chosen = chosen_from(path, options);
    PythonPhotographs reader(photographs, chosen.signal, chosen.pictures);
    StackRunOptions& o = chosen.run;
    if (!chosen.has_origin) {
        o.stack.origin_px = {0.5 * static_cast<double>(reader.width()) - 0.5,
                             0.5 * static_cast<double>(reader.height()) - 0.5};
    }
    std::atomic<bool> stop{false};
    o.stop = &stop;
    StackRunReport report;
    StackRun stack(chosen.lights, reader, o);
    Watch watch(progress, stop);
    std::shared_ptr<CaptureTiles> tiles;
    try {
        const py::gil_scoped_release release;
        // Also where the run throws: the watching thread needs the GIL that this one gives up.
        struct End {
            Watch& watch;
            ~End() { watch.end(); }
        } const end{watch};
        TileStore store = stack.run(target, report, [&](std::size_t done, std::size_t all) {
            watch.done(static_cast<double>(done) / static_cast<double>(all));
            return !stop;
        });
        tiles = std::shared_ptr<CaptureTiles>(
            new CaptureTiles{std::move(store), report, o.stack.model});
    } catch (const StackStopped& stopped) {
        watch.rethrow();
        const std::string text = "capture lights: stopped; " + std::to_string(stopped.bands_done) +
                                 " of " + std::to_string(stopped.bands) + " bands are kept";
        PyErr_SetString(PyExc_InterruptedError, text.c_str());
        throw py::error_already_set();
    }
    watch.rethrow();
    return tiles;
}

py::dict property_maps_of(CaptureTiles& tiles) {
    ProjectedMap map;
    {
        const py::gil_scoped_release release;
        map = maps_of_stack(tiles.whole(), tiles.store.width(), tiles.store.height(), tiles.model);
    }
    py::array_t<bool> usable({static_cast<py::ssize_t>(tiles.store.height()),
                              static_cast<py::ssize_t>(tiles.store.width())});
    for (std::size_t i = 0; i < map.usable.size(); ++i)
        usable.mutable_data()[i] = map.usable[i] != 0;
    py::dict d;
    d["maps"] = dict_from_maps(std::move(map.maps));
    d["usable"] = usable;
    return d;
}

}  // namespace

void bind_capture_lights(py::module_& m) {
    py::list names;
    for (const auto name : capture_channels) names.append(std::string(name));
    m.attr("CAPTURE_CHANNELS") = names;
    py::class_<CaptureTiles, std::shared_ptr<CaptureTiles>>(
        m, "CaptureTiles", "What capture_lights finished, kept on disk beside its target.")
        .def_property_readonly("width", [](const CaptureTiles& t) { return t.store.width(); })
        .def_property_readonly("height", [](const CaptureTiles& t) { return t.store.height(); })
        .def_property_readonly("bands", [](const CaptureTiles& t) { return t.store.bands(); })
        .def_property_readonly("report", &report_of)
        .def(
            "read",
            [](CaptureTiles& t, std::size_t band) {
                if (band >= t.store.bands())
                    throw InputError("capture lights", "band", std::to_string(band),
                                     "0 to " + std::to_string(t.store.bands() - 1));
                const std::vector<float> pixels = t.store.read(band);
                return py::array_t<float>({static_cast<py::ssize_t>(t.store.rows_of(band)),
                                           static_cast<py::ssize_t>(t.store.width()),
                                           static_cast<py::ssize_t>(t.store.channels())},
                                          pixels.data());
            },
            py::arg("band"), "(rows, width, CAPTURE_CHANNELS), the top row first.")
        .def("property_maps", &property_maps_of, "As capture_project takes them, frame \"image\".")
        .def(
            "remove", [](CaptureTiles& t) { t.store.remove(); },
            "Deletes the file: what was read of it stands elsewhere.");
    m.def("capture_lights_plan", &plan, py::arg("path"), py::arg("options") = py::dict(),
          "What a set-up of many known lights (.lp) can see; no picture is read.");
    m.def("capture_lights", &run, py::arg("path"), py::arg("photographs"), py::arg("target"),
          py::arg("options") = py::dict(), py::kw_only(), py::arg("progress") = py::none(),
          "Normal, lobe and albedo of each pixel from photographs under many known lights. "
          "progress: called ten\n"
          "times a second with the share done; returning False stops (InterruptedError), and the "
          "finished bands\nstay beside the target: the same call goes on from there.");
}

}  // namespace togishi
