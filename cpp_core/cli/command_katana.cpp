// togishi katana: a blade of given dimensions as a mesh file, and its measures.
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "blade/katana_file.hpp"
#include "cli/commands.hpp"
#include "spectral/embedded_data.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string preset;
    std::string output;
    double detail = 1;
    std::map<std::string, double> dimensions;
    std::map<std::string, std::string> choices;
};

constexpr std::string_view preset_folder = "blades/";
constexpr std::size_t max_preset_bytes = 1 << 20;

std::string preset_names() {
    std::string names;
    for (const EmbeddedFile& file : embedded_files()) {
        if (!file.path.starts_with(preset_folder)) continue;
        const std::string_view name = file.path.substr(preset_folder.size());
        names += (names.empty() ? "" : ", ") + std::string(name.substr(0, name.rfind('.')));
    }
    return names;
}

KatanaPreset find_preset(const std::string& name) {
    const std::string path = std::string(preset_folder) + name + ".toml";
    for (const EmbeddedFile& file : embedded_files()) {
        if (file.path == path) return parse_katana_preset(file.text, file.path);
    }
    if (!name.ends_with(".toml")) {
        throw InputError("--preset", "name", name,
                         preset_names() + ", or the path of a .toml file");
    }
    std::ifstream in(name, std::ios::binary);
    if (!in) throw InputError(name, "file", "missing or unreadable", "a blade preset (TOML)");
    std::string text(max_preset_bytes + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (in.bad()) throw InputError(name, "file", "unreadable", "a blade preset (TOML)");
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.size() > max_preset_bytes)
        throw InputError(name, "size", "over 1 MiB", "a blade preset (TOML)");
    return parse_katana_preset(text, name);
}

// "nagasa_mm" is --nagasa: the unit stands in the help.
std::string option_name(std::string_view key) {
    std::string name(key);
    if (name.ends_with("_mm")) name.resize(name.size() - 3);
    for (char& c : name) {
        if (c == '_') c = '-';
    }
    return "--" + name;
}

KatanaParameters parameters_of(const Options& options, std::string& title) {
    KatanaParameters p;
    const auto zukuri = options.choices.find("zukuri");
    if (!options.preset.empty()) {
        const KatanaPreset preset = find_preset(options.preset);
        p = preset.parameters;
        title = preset.title;
    } else if (zukuri != options.choices.end()) {
        p = katana_defaults(zukuri->second);
    }
    for (const auto& [key, name] : options.choices)
        set_katana_value(p, key, std::string_view(name), "command line");
    for (const auto& [key, value] : options.dimensions)
        set_katana_value(p, key, value, "command line");
    check_katana(p, "command line");
    return p;
}

Json json_of(const KatanaParameters& p) {
    Json result;
    for (const ChoiceField& c : katana_choices()) {
        result[std::string(c.key)] = std::string(c.names[static_cast<std::size_t>(c.get(p))]);
    }
    for (const DimensionField& d : katana_dimensions()) result[std::string(d.key)] = p.*d.member;
    return result;
}

void run(const Options& options, const Common& common) {
    std::string title = "Katana";
    const KatanaParameters p = parameters_of(options, title);
    const KatanaMesh mesh = make_katana(p, options.detail);
    const std::map<std::string, double> measures = measure_katana(mesh, p);
    write_katana_mesh(options.output, mesh);
    if (common.json) {
        Json report;
        report["file"] = options.output;
        report["title"] = title;
        report["parameters"] = json_of(p);
        report["measures"] = measures;
        std::cout << report.dump(2) << '\n';
        return;
    }
    std::cout << title << ": " << options.output << '\n';
    for (const auto& [key, value] : measures) {
        std::cout << "  " << std::left << std::setw(26) << key << std::setprecision(9) << value
                  << '\n';
    }
}

}  // namespace

void add_katana_command(CLI::App& app, const Common& common) {
    auto options = std::make_shared<Options>();
    auto* command = app.add_subcommand(
        "katana", "Write a blade of given dimensions as a mesh (.ply or .obj, in mm)");
    command->add_option("-o,--output", options->output, "File to write: .ply or .obj")->required();
    command->add_option("--preset", options->preset,
                        "Start from " + preset_names() + " or a .toml file");
    command->add_option("--detail", options->detail, "Vertices: 1 gives some 50,000; 0.002 to 64")
        ->capture_default_str();
    for (const ChoiceField& c : katana_choices()) {
        std::string names;
        for (const std::string_view n : c.names)
            names += (names.empty() ? "" : ", ") + std::string(n);
        const std::string key(c.key);
        command->add_option_function<std::string>(
            option_name(key),
            [options, key](const std::string& name) { options->choices[key] = name; },
            std::string(c.help) + ": " + names);
    }
    for (const DimensionField& d : katana_dimensions()) {
        const std::string key(d.key);
        const std::string unit = d.unit.empty() ? "" : " [" + std::string(d.unit) + "]";
        command->add_option_function<double>(
            option_name(key),
            [options, key](const double& value) { options->dimensions[key] = value; },
            std::string(d.help) + unit);
    }
    command->callback([options, &common] { run(*options, common); });
}

}  // namespace togishi::cli
