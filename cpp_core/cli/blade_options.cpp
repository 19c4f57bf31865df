#include "cli/blade_options.hpp"

#include <fstream>
#include <system_error>

#include "base/error.hpp"
#include "spectral/embedded_data.hpp"

namespace togishi::cli {

namespace {

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
    return read_katana_preset(name);
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

}  // namespace

void add_blade_options(CLI::App& command, BladeOptions& options) {
    command
        .add_option("--preset", options.preset, "Start from " + preset_names() + " or a .toml file")
        ->group("Blade");
    for (const ChoiceField& c : katana_choices()) {
        std::string names;
        for (const std::string_view n : c.names)
            names += (names.empty() ? "" : ", ") + std::string(n);
        const std::string key(c.key);
        command
            .add_option_function<std::string>(
                option_name(key),
                [&options, key](const std::string& name) { options.choices[key] = name; },
                std::string(c.help) + ": " + names)
            ->group("Blade");
    }
    for (const DimensionField& d : katana_dimensions()) {
        const std::string key(d.key);
        const std::string unit = d.unit.empty() ? "" : " [" + std::string(d.unit) + "]";
        command
            .add_option_function<double>(
                option_name(key),
                [&options, key](const double& value) { options.dimensions[key] = value; },
                std::string(d.help) + unit)
            ->group("Blade");
    }
}

KatanaPreset chosen_blade(const BladeOptions& options) {
    KatanaPreset blade{"Katana", "", "", {}};
    const auto zukuri = options.choices.find("zukuri");
    if (!options.preset.empty()) {
        blade = find_preset(options.preset);
    } else if (zukuri != options.choices.end()) {
        blade.parameters = katana_defaults(zukuri->second);
    }
    for (const auto& [key, name] : options.choices)
        set_katana_value(blade.parameters, key, std::string_view(name), "command line");
    for (const auto& [key, value] : options.dimensions)
        set_katana_value(blade.parameters, key, value, "command line");
    check_katana(blade.parameters, "command line");
    return blade;
}

KatanaPreset read_katana_preset(const std::filesystem::path& path) {
    const std::string where = path.string();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        throw InputError(where, "file", error ? error.message() : "no regular file",
                         "a blade preset (TOML)");
    }
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(where, "file", "unreadable", "a file that you may read");
    std::string text(max_preset_bytes + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (in.bad()) throw InputError(where, "file", "unreadable", "a blade preset (TOML)");
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.size() > max_preset_bytes)
        throw InputError(where, "size", "over 1 MiB", "up to 1 MiB");
    return parse_katana_preset(text, where);
}

nlohmann::ordered_json json_of(const KatanaParameters& parameters) {
    nlohmann::ordered_json result;
    for (const ChoiceField& c : katana_choices()) {
        result[std::string(c.key)] =
            std::string(c.names[static_cast<std::size_t>(c.get(parameters))]);
    }
    for (const DimensionField& d : katana_dimensions())
        result[std::string(d.key)] = parameters.*d.member;
    return result;
}

}  // namespace togishi::cli
