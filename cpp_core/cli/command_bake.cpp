// togishi bake: a blade's property maps as OpenEXR, and the Fresnel table of a metal under a light
// as CSV.
#include <unistd.h>

#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake/fresnel_table.hpp"
#include "bake/map_mips.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "brdf/material.hpp"
#include "cli/blade_options.hpp"
#include "cli/commands.hpp"
#include "image/map_file.hpp"
#include "steel/steel_pattern.hpp"
// After the model's formulas, which must not see the blade's own arithmetic.
#include "blade/katana_frame.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string output;
    BladeOptions blade;
    std::string material{default_material_name};
    std::vector<std::string> pattern;  // key=value
    std::int64_t width = 4096;
    std::int64_t height = 512;
    bool single = false;
    std::vector<std::string> table;  // metal, light
    std::string observer{default_observer};
    std::string space{default_colour_space};
    std::size_t table_size = default_table_size;
};

// "hamon=gunome", "ashi=0.4", "seed=7".
void set_pattern(SteelParameters& p, const std::string& assignment) {
    const auto equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    if (equals == std::string::npos) {
        throw InputError("--pattern", "argument", assignment, "KEY=VALUE, e.g. hamon=gunome");
    }
    const std::string value = assignment.substr(equals + 1);
    std::string names = "seed";
    for (const SteelChoiceField& field : steel_choice_fields()) {
        if (field.name == key) return set_steel_choice(p, field, value);
        names += ", " + std::string(field.name);
    }
    const auto number = [&](auto& target, const char* allowed) {
        std::istringstream in(value);
        if (!(in >> target) || !in.eof()) throw InputError("--pattern", key, value, allowed);
    };
    if (key == "seed") {
        // A stream would take -1 for 2^64 - 1.
        if (value.starts_with('-'))
            throw InputError("--pattern", key, value, "a whole number, 0 or more");
        return number(p.seed, "a whole number, 0 or more");
    }
    for (const SteelNumberField& field : steel_number_fields()) {
        if (field.name == key) return number(p.*field.member, "a number");
        names += ", " + std::string(field.name);
    }
    throw InputError("--pattern", "key", key, names);
}

Json bake_maps(const Options& options) {
    if (!options.output.ends_with(".exr")) {
        throw InputError("--output", "file name", options.output, "a name that ends in .exr");
    }
    check_map_size(options.output, options.width, options.height);
    check_output_folder(options.output);
    SteelParameters pattern;
    for (const auto& assignment : options.pattern) set_pattern(pattern, assignment);
    check_steel_parameters(pattern);
    const Material material = load_material(options.material);
    const KatanaPreset blade = chosen_blade(options.blade);
    const BladeFrame frame = make_blade_frame(blade.parameters);
    const auto progress = [](double done) {
        if (isatty(STDERR_FILENO) == 0) return true;  // a log is not for overwriting
        std::cerr << "\rtogishi bake: " << std::setw(3) << static_cast<int>(100 * done) << " %"
                  << (done < 1 ? "" : "\n") << std::flush;
        return true;
    };
    const PropertyMaps maps =
        steel_pattern(frame, material, pattern, static_cast<std::size_t>(options.width),
                      static_cast<std::size_t>(options.height), progress);
    MapFileInfo info;
    info.chart_mm = {static_cast<float>(frame.length_mm()),
                     static_cast<float>(frame.chart_height_mm)};
    info.source = "generated: " + blade.title + ", " + material.name;
    const auto note = [&](std::string_view key, std::string_view value) {
        info.source.append(", ").append(key).append("=").append(value);
    };
    for (const auto& [key, name] : options.blade.choices) note(key, name);
    for (const auto& [key, value] : options.blade.dimensions) note(key, Json(value).dump());
    for (const auto& assignment : options.pattern) info.source.append(", ").append(assignment);
    info.software = "togishi " TOGISHI_VERSION;
    write_map_file(options.output, maps, info,
                   options.single ? MapPrecision::single : MapPrecision::half);
    Json report;
    report["file"] = options.output;
    report["width"] = maps.width;
    report["height"] = maps.height;
    report["chart_mm"] = info.chart_mm;
    report["blade"] = blade.title;
    report["parameters"] = json_of(blade.parameters);
    report["material"] = material.name;
    Json channels = Json::object();
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        if (maps.channels[c].empty()) continue;
        channels[std::string(map_channel_names[c])] =
            maps.channels[c].size() == 1 ? "constant" : "plane";
    }
    report["channels"] = channels;
    return report;
}

Json bake_table(const Options& options) {
    if (!options.output.ends_with(".csv")) {
        throw InputError("--output", "file name", options.output,
                         "with --table, a name that ends in .csv");
    }
    FresnelTableRequest request;
    request.metal = options.table[0];
    request.light = options.table[1];
    request.observer = options.observer;
    request.space = options.space;
    request.size = options.table_size;
    const std::vector<float> table = fresnel_table(request);
    std::ostringstream text;
    text << "# linear RGB (" << options.space
         << ") of Fresnel reflectance times light, light at Y = 1\n# metal: " << options.table[0]
         << "\n# light: " << options.table[1] << "\n# observer: " << options.observer
         << "\n# software: togishi " TOGISHI_VERSION "\ncos_theta,r,g,b\n";
    text << std::setprecision(9);
    for (std::size_t i = 0; i < options.table_size; ++i) {
        const double x = static_cast<double>(i) / static_cast<double>(options.table_size - 1);
        text << x * x << ',' << table[3 * i] << ',' << table[3 * i + 1] << ',' << table[3 * i + 2]
             << '\n';
    }
    write_text_file(options.output, text.str());
    Json report;
    report["file"] = options.output;
    report["metal"] = options.table[0];
    report["light"] = options.table[1];
    report["rows"] = options.table_size;
    return report;
}

void run(const Options& options, const Common& common) {
    const Json report = options.table.empty() ? bake_maps(options) : bake_table(options);
    if (common.json) {
        std::cout << report.dump(2) << '\n';
        return;
    }
    for (const auto& [key, value] : report.items()) {
        if (key == "parameters") continue;  // two dozen dimensions: for machines
        std::cout << std::left << std::setw(10) << key << ' '
                  << (value.is_string() ? value.get<std::string>() : value.dump()) << '\n';
    }
}

}  // namespace

void add_bake_command(CLI::App& app, const Common& common) {
    auto options = std::make_shared<Options>();
    auto* command = app.add_subcommand(
        "bake", "Write property maps of a blade (.exr), or a Fresnel table (.csv)");
    command->add_option("-o,--output", options->output, "File to write")->required();
    command->add_option("--material", options->material, "Built-in material or .toml file")
        ->capture_default_str();
    command->add_option("--pattern", options->pattern,
                        "KEY=VALUE of the steel pattern; repeat for more");
    command->add_option("--width", options->width, "Texels along the blade")->capture_default_str();
    command->add_option("--height", options->height, "Texels across the chart")
        ->capture_default_str();
    command->add_flag("--float", options->single, "Store 32-bit floats instead of half");
    command
        ->add_option("--table", options->table,
                     "METAL LIGHT: write this pair's table instead of maps")
        ->expected(2);
    command->add_option("--observer", options->observer, "Observer of the table")
        ->capture_default_str();
    command->add_option("--space", options->space, "Linear RGB space of the table")
        ->capture_default_str();
    command->add_option("--table-size", options->table_size, "Rows of the table")
        ->capture_default_str();
    add_blade_options(*command, options->blade);
    command->callback([options, &common] { run(*options, common); });
}

}  // namespace togishi::cli
