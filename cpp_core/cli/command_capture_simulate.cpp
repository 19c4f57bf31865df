// togishi capture simulate: photographs of a blade or plate whose maps are known.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "blade/katana_frame.hpp"
#include "capture/diffuse_setup.hpp"
#include "capture/light_file.hpp"
#include "cli/commands.hpp"
#include "image/float_image.hpp"
#include "image/map_file.hpp"
#include "steel/steel_pattern.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string setup, output, format = "tif", example;
    std::vector<double> exposures;
    std::int64_t seed = -1;
};

// A set-up to begin with: three strip lights over a bent plate, or over a hand's breadth of a
// katana.
CaptureSetup example_setup(const std::string& kind) {
    CaptureSetup setup;
    setup.material = "sashikomi_katana";
    SensorOptions sensor;
    setup.noise = sensor;
    const double incidence = 25.0 * 3.14159265358979323846 / 180;
    glm::dvec3 target(0);
    if (kind == "plate") {
        setup.surface = Plate{{40, 20}, {0, 250}};
    } else if (kind == "blade") {
        setup.surface = BladeSurface{"", {}, 1};
        setup.simulate.pattern = {{"hadori", 0}};
        target = {300, 3, -31};
    } else {
        throw InputError("--example", "argument", kind, "plate, blade");
    }
    const glm::dvec3 eye =
        target + 900.0 * glm::dvec3(0, std::cos(incidence), -std::sin(incidence));
    setup.camera = camera_looking_at(eye, target, {0, 0, 1}, false, kind == "plate" ? 3 : 2.5,
                                     kind == "plate" ? 114 : 200, kind == "plate" ? 54 : 80);
    // The strips stand about the mirror direction of the ji, which leans towards the edge.
    glm::dvec3 normal(0, 1, 0);
    if (kind == "blade") {
        const SurfaceView view = view_of(setup);
        normal = glm::dvec3(0);
        for (std::size_t i = 0; i < view.pixels(); ++i) {
            // From the ji's middle to the edge; the shinogi-ji leans the other way.
            if (view.seen[i] != 0 && view.normal[i].z < 0) normal += glm::dvec3(view.normal[i]);
        }
        normal = glm::normalize(normal);
    }
    const glm::dvec3 to_eye = glm::normalize(eye - target);
    const glm::dvec3 mirror = 2 * glm::dot(normal, to_eye) * normal - to_eye;
    const glm::dvec3 up = glm::normalize(glm::cross(glm::dvec3(1, 0, 0), mirror));
    // Two strips, 3 degrees apart, whose edges lie where ji and ha of a hiraji turn from bright to
    // dark; and one of twice the height on the edge's side, beside which the
    // ha is at its brightest and hardly changes with its half width.
    struct Strip {
        double shift_deg, half_height_mm;
    };
    for (const Strip& strip : {Strip{-1.5, 25}, Strip{1.5, 25}, Strip{-3, 50}}) {
        const double a = strip.shift_deg * 3.14159265358979323846 / 180;
        const glm::dvec3 to = std::cos(a) * mirror - std::sin(a) * up;
        DiffuseSource source;
        source.centre_mm = target + 700.0 * to;
        source.half_u_mm = {250, 0, 0};
        source.half_v_mm =
            strip.half_height_mm * glm::normalize(glm::cross(to, glm::dvec3(1, 0, 0)));
        PhotographSetup photograph;
        photograph.source = source;
        setup.photographs.push_back(photograph);
    }
    return setup;
}

PropertyMaps maps_of(const CaptureSetup& setup, const Material& material) {
    const SimulateSetup& s = setup.simulate;
    if (!s.maps.empty()) return read_map_file(setup.path_of(s.maps)).levels.front();
    check_map_size(setup.file, s.map_width, s.map_height);
    const auto width = static_cast<std::size_t>(s.map_width),
               height = static_cast<std::size_t>(s.map_height);
    if (const auto* blade = std::get_if<BladeSurface>(&setup.surface)) {
        SteelParameters pattern;
        for (const auto& [key, value] : s.pattern) {
            const auto fields = steel_number_fields();
            const auto* const field =
                std::find_if(fields.data(), fields.data() + fields.size(),
                             [&, name = key](const SteelNumberField& f) { return f.name == name; });
            if (key == "seed") {
                pattern.seed = static_cast<std::uint64_t>(std::max(value, 0.0));
            } else if (field == fields.data() + fields.size()) {
                throw InputError(setup.file.string(), "simulate.pattern", key,
                                 "a number of the steel pattern, as of togishi bake --pattern");
            } else {
                pattern.*(field->member) = value;
            }
        }
        check_steel_parameters(pattern);
        return steel_pattern(make_blade_frame(blade->parameters), material, pattern, width, height);
    }
    return plate_maps(width, height, std::exp(stored_lobe(material.ji)[0]),
                      std::exp(stored_lobe(material.ha)[0]), s.variation, s.seed);
}

FloatImage grey_image(const Camera& camera, std::vector<float> values) {
    FloatImage image;
    image.width = camera.width_px;
    image.height = camera.height_px;
    image.channels = 1;
    image.names = {"Y"};
    image.values = std::move(values);
    return image;
}

void write_truth(const std::filesystem::path& path, const SurfaceView& view,
                 const PixelTruth& truth) {
    FloatImage image;
    image.width = view.camera.width_px;
    image.height = view.camera.height_px;
    image.names.assign(map_channel_names.begin(), map_channel_names.end());
    image.names.insert(image.names.end(), {"u", "v", "seen"});
    image.channels = static_cast<int>(image.names.size());
    image.values.reserve(image.pixels() * image.names.size());
    for (std::size_t i = 0; i < view.pixels(); ++i) {
        const float* first = truth.values.data() + i * map_channel_count;
        image.values.insert(image.values.end(), first, first + map_channel_count);
        image.values.insert(image.values.end(),
                            {view.uv[i].x, view.uv[i].y, view.seen[i] != 0 ? 1.0F : 0.0F});
    }
    write_float_image(path, image);
}

void run(Options o, const Common& common) {
    if (!o.example.empty()) {
        std::cout << capture_setup_to_toml(example_setup(o.example));
        return;
    }
    if (o.setup.empty() || o.output.empty())
        throw InputError("capture simulate", "arguments", "missing",
                         "SETUP.toml --output FOLDER, or --example plate|blade");
    if (o.format != "tif" && o.format != "exr")
        throw InputError("--format", "argument", o.format, "tif, exr");
    CaptureSetup setup = read_capture_setup(o.setup);
    if (o.seed >= 0) setup.simulate.seed = static_cast<std::uint64_t>(o.seed);
    if (!o.exposures.empty()) setup.simulate.exposures = o.exposures;
    const std::filesystem::path folder(o.output);
    std::filesystem::create_directories(folder);
    check_output_folder(folder / "setup.toml");

    const Material material = load_material(setup.material);
    const SurfaceView view = view_of(setup);
    const PixelTruth truth = maps_in_view(view, maps_of(setup, material));
    RadianceOptions radiance_options;
    radiance_options.metal = material.metal;
    radiance_options.light = setup.light;
    radiance_options.hadori = stored_lobe(material.hadori);

    struct Shot {
        Illumination illumination;
        std::string name;
    };
    std::vector<Shot> shots;
    const bool stack = !setup.simulate.lights.empty();
    if (stack) {
        LightFileOptions options;
        options.need_images = false;
        const Camera& camera = *setup.camera;
        for (const LightEntry& entry :
             read_light_file(setup.path_of(setup.simulate.lights), options).lights) {
            PointLight light;
            // .lp: x to the right in the picture, y up, z to the camera.
            light.direction = entry.direction.x * camera.right - entry.direction.y * camera.down -
                              entry.direction.z * camera.forward();
            light.intensity = entry.intensity;
            shots.push_back({light, "light_" + std::to_string(shots.size() + 1)});
        }
    } else {
        for (const PhotographSetup& p : setup.photographs) {
            if (!p.source) {
                throw InputError(o.setup, "photograph.source", "missing",
                                 "a source, or simulate.lights: an .lp file");
            }
            shots.push_back({*p.source, "photograph_" + std::to_string(shots.size() + 1)});
        }
    }
    if (shots.empty())
        throw InputError(o.setup, "photograph", "none", "[[photograph]] or simulate.lights");

    const bool show = isatty(STDERR_FILENO) != 0;
    std::vector<std::vector<double>> radiance;
    std::vector<double> bright;
    for (const Shot& shot : shots) {
        radiance.push_back(reference_radiance(view, truth, shot.illumination, radiance_options));
        // The value under which nearly all pixels lie.
        bright.push_back(quantile(std::vector<double>(radiance.back()), stack ? 0.995 : 0.9995));
        if (show) {
            std::cerr << "\rtogishi capture simulate: " << radiance.size() << " of " << shots.size()
                      << (radiance.size() == shots.size() ? "\n" : "") << std::flush;
        }
    }
    SensorOptions sensor = setup.noise.value_or(SensorOptions{});
    sensor.blur_px = setup.simulate.blur_px;
    sensor.dark = setup.simulate.dark;
    sensor.vignetting = setup.simulate.vignetting;
    sensor.seed = setup.simulate.seed;
    if (!setup.scale) {
        const double most = *std::max_element(bright.begin(), bright.end());
        setup.scale = most > 0 ? 0.85 * (1 - sensor.dark) / most : 1.0;
    }
    setup.transfer = "linear";  // as these are written
    const Camera& camera = *setup.camera;
    std::vector<std::string> files;
    std::uint64_t frame = 0;
    const auto write = [&](const std::vector<double>& from, const SensorOptions& options,
                           const std::string& name) {
        std::string file = name + "." + o.format;
        write_float_image(
            folder / file,
            grey_image(camera, expose(from, camera.width_px, camera.height_px, options, frame++)));
        files.push_back(file);
        return file;
    };
    std::vector<PhotographSetup> taken;
    std::string lp;
    for (std::size_t k = 0; k < shots.size(); ++k) {
        for (const double exposure : setup.simulate.exposures) {
            sensor.scale = *setup.scale * exposure;
            const bool only = setup.simulate.exposures.size() == 1;
            const auto number =
                static_cast<std::size_t>(&exposure - setup.simulate.exposures.data() + 1);
            const std::string name =
                shots[k].name + (only ? "" : "_exposure_" + std::to_string(number));
            const std::string file = write(radiance[k], sensor, name);
            if (stack) {
                if (number > 1) continue;  // one .lp names the first exposure of each light
                const auto& light = std::get<PointLight>(shots[k].illumination);
                lp += file + " " + std::to_string(glm::dot(light.direction, camera.right)) + " " +
                      std::to_string(-glm::dot(light.direction, camera.down)) + " " +
                      std::to_string(-glm::dot(light.direction, camera.forward())) + "\n";
                continue;
            }
            PhotographSetup photograph = setup.photographs[k];
            photograph.file = file;
            photograph.exposure = exposure;
            if (!photograph.dark.empty() || sensor.dark > 0) {
                photograph.dark =
                    write(std::vector<double>(view.pixels(), 0.0), sensor, name + "_dark");
            }
            if (!photograph.flat.empty() || sensor.vignetting > 0) {
                // A white card in the surface's place, turned to the camera, at an exposure of its
                // own and averaged over 16 frames.
                const SurfaceView card = view_of_flat_card(setup);
                std::vector<double> light = card_radiance(card, shots[k].illumination);
                const double brightest = *std::max_element(light.begin(), light.end());
                if (brightest > 0) {
                    for (double& v : light) v *= setup.flat_reflectance;
                    SensorOptions flat = sensor;
                    photograph.flat_exposure = 0.7 / (*setup.scale * brightest);
                    flat.scale = *setup.scale * photograph.flat_exposure;
                    flat.snr *= 4;
                    flat.read /= 4;
                    flat.bits = 16;
                    photograph.flat = write(light, flat, name + "_flat");
                }
            }
            taken.push_back(std::move(photograph));
        }
    }
    write_truth(folder / "truth.exr", view, truth);
    files.emplace_back("truth.exr");
    if (const auto* blade = std::get_if<BladeSurface>(&setup.surface)) {
        SensorOptions light = sensor;
        light.scale = 0.85;
        light.vignetting = 0;
        write(picture_against_light(make_katana(blade->parameters, blade->detail), camera), light,
              "silhouette");
    }
    setup.photographs = taken;
    setup.noise = sensor;
    if (stack) {
        write_text_file(folder / "lights.lp", std::to_string(shots.size()) + "\n" + lp);
        files.emplace_back("lights.lp");
    }
    setup.simulate.lights.clear();
    if (!setup.simulate.maps.empty()) {
        setup.simulate.maps =
            std::filesystem::absolute(setup.path_of(setup.simulate.maps)).string();
    }
    write_text_file(folder / "setup.toml", capture_setup_to_toml(setup));
    files.emplace_back("setup.toml");
    std::size_t seen = 0;
    for (const std::uint8_t s : view.seen) seen += s;
    if (common.json) {
        const Json report{{"folder", o.output},      {"files", files},
                          {"pixels", view.pixels()}, {"seen", seen},
                          {"scale", *setup.scale},   {"seed", setup.simulate.seed}};
        std::cout << report.dump(2) << '\n';
    } else {
        std::cout << o.output << ": " << shots.size() << " lights, " << camera.width_px << " x "
                  << camera.height_px << " pixels, " << seen << " of them on the surface\n";
    }
}

}  // namespace

void add_capture_simulate_command(CLI::App& capture, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command = capture.add_subcommand(
        "simulate", "Photograph a generated blade or plate by the reference evaluation");
    command->add_option("setup", o->setup, "Set-up of camera, surface and sources (.toml)");
    command->add_option("-o,--output", o->output, "Folder for pictures, truth.exr, setup.toml");
    command->add_option("--format", o->format, "tif (16 bit) or exr (float)")
        ->capture_default_str();
    command->add_option("--exposure", o->exposures,
                        "Exposures of each light, instead of the set-up's");
    command->add_option("--seed", o->seed, "Of the noise and a plate's maps");
    command->add_option("--example", o->example, "Print a set-up to begin with: plate or blade");
    command->callback([o, &common] { run(*o, common); });
}

}  // namespace togishi::cli
