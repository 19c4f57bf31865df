// togishi capture lights: photographs under many known lights become maps of normal, lobe, diffuse
// albedo, and what each is worth.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "capture/tile_run.hpp"
#include "cli/commands.hpp"
#include "image/photograph_map.hpp"
#include "image/photograph_stack.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct Options {
    std::string file, output;
    std::vector<std::string> brackets;  // FILE.lp=RATIO
    bool positions = false, intensities = false, half = false, plan = false;
    std::string transfer = "linear", model = "hamon", effort = "full";
    std::vector<double> view{0, 0, 1}, normal{0, 0, 1}, origin, white, prior;
    double white_reflectance = 0.99, prior_sigma = 0.1, memory_mib = 1024;
    PhotographOptions photographs;
    StackRunOptions run;
};

std::atomic<bool> stop_asked{false};

extern "C" void ask_stop(int signal) {
    stop_asked = true;
    // A second time it ends at once.
    std::signal(signal, SIG_DFL);
}

// While it lives, SIGINT and SIGTERM stop the run between cells.
class StopOnSignal {
  public:
    StopOnSignal()
        : interrupt_(std::signal(SIGINT, ask_stop)), end_(std::signal(SIGTERM, ask_stop)) {}
    ~StopOnSignal() {
        std::signal(SIGINT, interrupt_);
        std::signal(SIGTERM, end_);
    }
    StopOnSignal(const StopOnSignal&) = delete;
    StopOnSignal& operator=(const StopOnSignal&) = delete;

  private:
    void (*interrupt_)(int);
    void (*end_)(int);
};

std::size_t choice(const char* option, const std::string& value,
                   const std::vector<std::string>& names) {
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == value) return i;
        all += (i > 0 ? ", " : "") + names[i];
    }
    throw InputError(option, "argument", value, all);
}

std::size_t whole(const char* option, double value) {
    constexpr double most = 1e6;
    if (!(value >= 0 && value <= most && value == std::floor(value)))
        throw InputError(option, "argument", std::to_string(value), "whole numbers, 0 to 1000000");
    return static_cast<std::size_t>(value);
}

// FILE.lp=RATIO: the same lights with another exposure.
void add_bracket(const std::string& argument, const LightFile& lights, const LightFileOptions& how,
                 std::vector<fs::path>& pictures, std::vector<double>& exposures) {
    const auto equals = argument.rfind('=');
    const auto ratio =
        equals == std::string::npos ? std::nullopt : parse_number(argument.substr(equals + 1));
    if (!ratio || !(*ratio > 0 && *ratio < 1e6)) {
        throw InputError("--bracket", "argument", argument,
                         "FILE.lp=RATIO, its light over that of the first, e.g. short.lp=0.03125");
    }
    const LightFile other = read_light_bracket(argument.substr(0, equals), lights, how);
    for (const LightEntry& light : other.lights) pictures.push_back(light.image);
    exposures.push_back(*ratio);
}

glm::dvec3 vector_of(const std::vector<double>& v) {
    return {v[0], v[1], v[2]};
}

Json json_of(const StackReach& r) {
    return {{"spacing_deg", r.spacing_deg},
            {"reach_deg", r.reach_deg},
            {"mu_sure_deg", r.mu_sure_deg},
            {"mu_mostly_deg", r.mu_mostly_deg},
            {"mu_widest_deg", r.mu_widest_deg}};
}

class Progress {
  public:
    bool operator()(std::size_t done, std::size_t all) {
        if (first_ == 0) first_ = done;
        const double spent =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        const std::size_t here = done - first_ + 1;
        const double left = spent / static_cast<double>(here) * static_cast<double>(all - done);
        if (show_) {
            std::cerr << "\rtogishi capture lights: " << std::setw(3) << 100 * done / all << " %, "
                      << static_cast<long>(left / 60) << " min " << std::setw(2)
                      << static_cast<long>(left) % 60 << " s left " << (done < all ? "" : "\n")
                      << std::flush;
        }
        return !stop_asked;
    }

  private:
    bool show_ = isatty(STDERR_FILENO) != 0;
    std::size_t first_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

Json json_of(const StackRunReport& r, const Options& o) {
    static constexpr std::array<const char*, 7> reasons{
        "uncertain",        "misfit",   "few_samples", "at_bound",
        "rejected_samples", "inferred", "missing"};
    Json out{{"file", o.output},
             {"width", r.width},
             {"height", r.height},
             {"lights", r.lights},
             {"pictures", r.pictures},
             {"reach", json_of(r.reach)},
             {"bands", r.bands},
             {"bands_resumed", r.bands_resumed},
             {"flagged", r.flagged},
             {"inferred", r.inferred},
             {"haze_cells", r.haze_cells},
             {"cells", r.cells},
             {"seconds_reading", r.seconds_reading},
             {"seconds_fitting", r.seconds_fitting},
             {"instruction_set", r.instruction_set}};
    for (std::size_t i = 0; i < reasons.size(); ++i) out["reasons"][reasons[i]] = r.reasons[i];
    if (r.calibration) {
        out["calibration"] = {{"rms_deg", r.calibration->rms_deg},
                              {"sigma_h_deg", r.calibration->sigma_h_deg},
                              {"pixels", r.calibration->pixels}};
    }
    return out;
}

void print(const StackRunReport& r, const Options& o) {
    const double pixels = static_cast<double>(r.width) * static_cast<double>(r.height);
    std::cout << o.output << ": " << r.width << " x " << r.height << ", " << std::setprecision(3)
              << 100 * static_cast<double>(r.flagged) / pixels << " % flagged";
    if (r.inferred > 0) std::cout << ", " << r.inferred << " pixels inferred from the prior";
    if (o.run.haze_width > 0)
        std::cout << ", haze in " << r.haze_cells << " of " << r.cells << " cells";
    if (r.bands_resumed > 0)
        std::cout << "; " << r.bands_resumed << " of " << r.bands
                  << " bands were there from an earlier run (counts are of the others)";
    std::cout << '\n';
    if (r.calibration) {
        std::cout << "lights moved by " << r.calibration->rms_deg << " deg (half vectors, rms), by "
                  << r.calibration->pixels << " pixels\n";
    }
}

void run(Options o, const Common& common) {
    if (!o.plan) {
        if (!o.output.ends_with(".exr"))
            throw InputError("--output", "file name", o.output.empty() ? "missing" : o.output,
                             "a name that ends in .exr");
        check_output_folder(o.output);
    }
    LightFileOptions how;
    how.positions_mm = o.positions;
    how.intensity_column = o.intensities;
    const LightFile lights = read_light_file(o.file, how);
    std::vector<fs::path> pictures;
    pictures.reserve(lights.lights.size());
    for (const LightEntry& light : lights.lights) pictures.push_back(light.image);
    StackRunOptions& r = o.run;
    for (const std::string& bracket : o.brackets)
        add_bracket(bracket, lights, how, pictures, r.exposures);
    r.stack.model = static_cast<LobeModel>(choice("--model", o.model, {"ji", "hamon"}));
    r.effort =
        static_cast<PixelEffort>(choice("--effort", o.effort, {"moments", "log-linear", "full"}));
    o.photographs.transfer =
        static_cast<Transfer>(choice("--transfer", o.transfer, {"linear", "srgb"}));
    r.stack.view = vector_of(o.view);
    r.normal = vector_of(o.normal);
    constexpr double least_mib = 16, most_mib = 1 << 20;
    if (!(o.memory_mib >= least_mib && o.memory_mib <= most_mib))
        throw InputError("--memory", "argument", std::to_string(o.memory_mib), "16 to 1048576 MiB");
    r.memory_bytes = static_cast<std::size_t>(o.memory_mib * 1048576);
    if (!o.white.empty()) {
        r.white = WhitePatch{whole("--white-patch", o.white[0]), whole("--white-patch", o.white[1]),
                             whole("--white-patch", o.white[2]), whole("--white-patch", o.white[3]),
                             o.white_reflectance};
    }
    if (!o.prior.empty()) r.prior = LobePrior{o.prior[0], o.prior[1], o.prior[2], o.prior_sigma};

    const auto photographs = open_photographs(pictures, o.photographs);
    r.stack.origin_px = o.origin.empty()
                            ? glm::dvec2(0.5 * static_cast<double>(photographs->width()) - 0.5,
                                         0.5 * static_cast<double>(photographs->height()) - 0.5)
                            : glm::dvec2(o.origin[0], o.origin[1]);
    stop_asked = false;
    r.stop = &stop_asked;
    StackRun stack(lights, *photographs, r);
    const StackReach reach = stack.reach();
    if (o.plan) {
        if (common.json) {
            std::cout << Json{{"lights", lights.lights.size()}, {"reach", json_of(reach)}}.dump(2)
                      << '\n';
        } else {
            std::cout << reach_sentence(reach, lights.lights.size()) << '\n';
        }
        return;
    }
    if (!common.json) std::cout << reach_sentence(reach, lights.lights.size()) << std::endl;
    StackRunReport report;
    try {
        const StopOnSignal guard;
        Progress progress;
        TileStore tiles = stack.run(o.output, report, std::ref(progress));
        write_capture_map(o.output, tiles, "togishi capture lights " + o.file,
                          "togishi " TOGISHI_VERSION,
                          o.half ? MapPrecision::half : MapPrecision::single, r.threads);
    } catch (const StackStopped& stopped) {
        throw std::runtime_error("stopped: " + std::to_string(stopped.bands_done) + " of " +
                                 std::to_string(stopped.bands) +
                                 " bands are kept beside the output; the same command goes on "
                                 "from there");
    }
    if (common.json) {
        std::cout << json_of(report, o).dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    } else {
        print(report, o);
    }
}

}  // namespace

void add_capture_lights_command(CLI::App& capture, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command = capture.add_subcommand(
        "lights", "Photographs under many known lights (.lp) into maps of normal and lobe");
    command->add_option("file", o->file, "The .lp file: a count, then NAME x y z a line")
        ->required();
    command->add_option("-o,--output", o->output, "Map to write (.exr)");
    command->add_flag("--plan", o->plan, "Only say what the set-up can see");
    command->add_option("--bracket", o->brackets,
                        "FILE.lp=RATIO: the same lights with RATIO times the exposure");
    command->add_flag("--positions", o->positions,
                      "x y z are the lights' places in mm; needs --mm-per-pixel");
    command->add_flag("--intensities", o->intensities,
                      "A fourth number in each line: the light's relative intensity");
    command->add_option("--mm-per-pixel", o->run.stack.mm_per_pixel, "Scale of the pictures");
    command
        ->add_option("--origin", o->origin,
                     "Column and row of the origin of x y z (default: the picture's middle)")
        ->expected(2);
    command->add_option("--camera-distance", o->run.stack.camera_distance_mm,
                        "Of the camera from the origin in mm (default: far)");
    command->add_option("--view", o->view, "Direction to the camera")
        ->expected(3)
        ->capture_default_str();
    command->add_option("--normal", o->normal, "The object's normal, roughly")
        ->expected(3)
        ->capture_default_str();
    command
        ->add_option("--model", o->model,
                     "ji (smooth, Fresnel at the light's angle) or hamon (rough, at the half "
                     "vector's)")
        ->capture_default_str();
    command->add_option("--metal", o->run.stack.metal, "Metal of the object")
        ->capture_default_str();
    command->add_option("--light", o->run.stack.light, "Spectrum of the lights")
        ->capture_default_str();
    command
        ->add_option("--light-error", o->run.stack.light_error_deg,
                     "How well the lights' directions are known, in degrees (rms)")
        ->capture_default_str();
    command->add_flag("--self-calibrate", o->run.self_calibration,
                      "Correct the lights' directions by what the pixels agree on");
    command->add_option("--transfer", o->transfer, "linear, or srgb")->capture_default_str();
    command
        ->add_option("--channel", o->photographs.channel,
                     "luminance, or the name of a picture's channel")
        ->capture_default_str();
    command->add_option("--black", o->photographs.black, "Black level, of full scale")
        ->capture_default_str();
    command->add_option("--clip", o->photographs.clip,
                        "Where samples count as clipped, of full scale (default: at full scale)");
    command->add_option("--snr", o->run.snr, "Signal to noise at full scale")
        ->capture_default_str();
    command->add_option("--read-noise", o->run.read_noise, "Noise in the dark, of full scale, rms")
        ->capture_default_str();
    command
        ->add_option("--white-patch", o->white,
                     "left top width height in pixels of a white reference in the pictures")
        ->expected(4);
    command->add_option("--white-reflectance", o->white_reflectance, "Of the white reference")
        ->capture_default_str();
    command->add_flag("--pedestal", o->run.pedestal, "Fit stray light too");
    command->add_option("--haze-width", o->run.haze_width,
                        "Look for a second lobe this many times wider (known from a fit)");
    command
        ->add_option("--prior", o->prior,
                     "mu_t mu_b rho in degrees: where the photographs leave the lobe open, take "
                     "this one and mark it as inferred")
        ->expected(3);
    command->add_option("--prior-sigma", o->prior_sigma, "How sure the prior is, of ln mu")
        ->capture_default_str();
    command->add_option("--effort", o->effort, "moments, log-linear or full")
        ->capture_default_str();
    command->add_flag("--half", o->half, "Write 16-bit floats");
    command->add_option("--threads", o->run.threads, "0: all cores")->capture_default_str();
    command->add_option("--memory", o->memory_mib, "For the pictures' bands, in MiB")
        ->capture_default_str();
    command->add_option("--band-rows", o->run.band_rows,
                        "Rows a band, a multiple of 64 (default: what the memory allows)");
    command->callback([o, &common] { run(*o, common); });
}

}  // namespace togishi::cli
