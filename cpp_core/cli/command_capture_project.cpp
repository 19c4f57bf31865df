// togishi capture project: maps of photographs onto the blade's own chart.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "capture/diffuse_run.hpp"
#include "capture/project.hpp"
#include "cli/capture_picture.hpp"
#include "cli/commands.hpp"
#include "image/float_image.hpp"
#include "image/map_file.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::vector<std::string> setups, maps;
    std::string output, frame = "surface";
    std::int64_t width = 4096, height = 512;
    bool keep_masked = false;
    ProjectOptions project;
};

// Pixels without a bit of mask_no_w, from the file that capture diffuse wrote beside the map.
std::vector<std::uint8_t> usable_pixels(const std::string& map) {
    std::filesystem::path path(map);
    path.replace_filename(path.stem().string() + "-quality.exr");
    if (!std::filesystem::exists(path)) return {};
    const FloatImage image = read_float_image(path);
    const auto found = std::find(image.names.begin(), image.names.end(), "mask");
    if (found == image.names.end()) return {};
    const auto at = static_cast<std::size_t>(found - image.names.begin());
    std::vector<std::uint8_t> usable(image.pixels());
    for (std::size_t i = 0; i < usable.size(); ++i) {
        const float mask = image.values[i * image.names.size() + at];
        usable[i] = mask >= 0 && mask < 256 && (static_cast<int>(mask) & mask_no_w) == 0 ? 1 : 0;
    }
    return usable;
}

void run(Options o, const Common& common) {
    if (!o.output.ends_with(".exr"))
        throw InputError("--output", "file name", o.output, "a name that ends in .exr");
    check_output_folder(o.output);
    check_map_size(o.output, o.width, o.height);
    if (o.setups.size() != o.maps.size()) {
        throw InputError("--map", "number", std::to_string(o.maps.size()),
                         std::to_string(o.setups.size()) + ", one for each --setup");
    }
    if (o.frame != "surface" && o.frame != "image")
        throw InputError("--frame", "argument", o.frame, "surface, image");
    o.project.width = static_cast<std::size_t>(o.width);
    o.project.height = static_cast<std::size_t>(o.height);
    std::vector<ProjectedMap> photographs;
    Json cameras = Json::array();
    std::optional<KatanaMesh> mesh;
    for (std::size_t k = 0; k < o.setups.size(); ++k) {
        CaptureSetup setup = read_capture_setup(o.setups[k]);
        const auto* blade = std::get_if<BladeSurface>(&setup.surface);
        if (blade == nullptr)
            throw InputError(o.setups[k], "surface", "no blade", "surface.kind = \"blade\"");
        if (!setup.camera) throw InputError(o.setups[k], "camera", "missing", "a table [camera]");
        refine_camera(setup, read_capture_picture);
        if (!mesh) mesh = make_katana(blade->parameters, blade->detail);
        ProjectedMap photograph;
        photograph.maps = read_map_file(o.maps[k]).levels.front();
        if (!o.keep_masked) photograph.usable = usable_pixels(o.maps[k]);
        photograph.camera = *setup.camera;
        photograph.frame = o.frame == "image" ? MapFrame::image : MapFrame::surface;
        photographs.push_back(std::move(photograph));
        Json camera{{"setup", o.setups[k]}};
        if (setup.camera_fit) {
            camera["rms_mm"] = setup.camera_fit->rms_mm;
            for (std::size_t l = 0; l < setup.landmarks.size(); ++l)
                camera["residual_mm"][setup.landmarks[l].name] = setup.camera_fit->residual_mm[l];
        }
        if (const auto& outline = setup.silhouette_fit) {
            camera["outline"] = {{"rms_mm", outline->rms_mm},
                                 {"p90_mm", outline->p90_mm},
                                 {"before_rms_mm", outline->before_rms_mm},
                                 {"points", outline->points}};
        }
        cameras.push_back(camera);
    }
    const ProjectResult result = project_maps(*mesh, photographs, o.project);
    MapFileInfo info;
    info.chart_mm = {static_cast<float>(mesh->frame.length_mm()),
                     static_cast<float>(mesh->frame.chart_height_mm)};
    info.source =
        "measured: " + std::to_string(photographs.size()) + " photographs projected onto the blade";
    info.software = "togishi " TOGISHI_VERSION;
    write_map_file(o.output, result.maps, info, MapPrecision::single);
    // Top row first, as pictures are.
    FloatImage coverage;
    coverage.width = static_cast<int>(o.width);
    coverage.height = static_cast<int>(o.height);
    coverage.channels = 1;
    coverage.names = {"coverage"};
    for (std::size_t row = o.project.height; row-- > 0;) {
        const float* from = result.coverage.data() + row * o.project.width;
        coverage.values.insert(coverage.values.end(), from, from + o.project.width);
    }
    const std::string coverage_file = o.output.substr(0, o.output.size() - 4) + "-coverage.exr";
    write_float_image(coverage_file, coverage);
    const double covered = 1 - static_cast<double>(result.holes) /
                                   static_cast<double>(std::max<std::size_t>(result.on_blade, 1));
    if (common.json) {
        const Json report{
            {"map", o.output},       {"coverage", coverage_file}, {"on_blade", result.on_blade},
            {"holes", result.holes}, {"covered_share", covered},  {"cameras", cameras}};
        std::cout << report.dump(1) << '\n';
        return;
    }
    std::cout << o.output << ": " << result.on_blade << " texels on the blade, " << result.holes
              << " of them holes (coverage 0 in " << coverage_file << ")\n";
    for (const auto& camera : cameras) {
        const auto name = camera["setup"].get<std::string>();
        if (camera.contains("rms_mm"))
            std::cout << "  " << name << ": landmarks within " << camera["rms_mm"].get<double>()
                      << " mm rms\n";
        if (camera.contains("outline")) {
            const auto& outline = camera["outline"];
            std::cout << "  " << name << ": outline within " << outline["rms_mm"].get<double>()
                      << " mm rms, " << outline["p90_mm"].get<double>() << " mm on 90 %, before "
                      << outline["before_rms_mm"].get<double>() << " mm\n";
        }
    }
}

}  // namespace

void add_capture_project_command(CLI::App& capture, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command =
        capture.add_subcommand("project", "Bring maps of photographs onto the blade's own chart");
    command
        ->add_option("--setup", o->setups,
                     "Set-up of a photograph: its blade, and its camera or landmarks (.toml)")
        ->required();
    command->add_option("--map", o->maps, "The map made from it (.exr), in the same order")
        ->required();
    command->add_option("-o,--output", o->output, "Map to write (.exr)")->required();
    command->add_option("--width", o->width, "Texels along the blade")->capture_default_str();
    command->add_option("--height", o->height, "Texels across the chart")->capture_default_str();
    command
        ->add_option("--frame", o->frame,
                     "What rho counts from in the maps: surface (capture diffuse) or image "
                     "(capture lights)")
        ->capture_default_str();
    command->add_flag("--keep-masked", o->keep_masked, "Use pixels that the quality file masks");
    command
        ->add_option("--feather-px", o->project.feather_px,
                     "Fading towards a picture's border; 0: over all of it")
        ->capture_default_str();
    command->callback([o, &common] { run(*o, common); });
}

}  // namespace togishi::cli
