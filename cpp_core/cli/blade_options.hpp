// Which blade: --preset and one option per dimension and choice, the same in every command that
// makes one.
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "blade/katana_file.hpp"
#include "blade/katana_parameters.hpp"

namespace togishi::cli {

/// As given on the command line; keys as katana_dimensions and katana_choices have them.
struct BladeOptions {
    std::string preset;
    std::map<std::string, double> dimensions;
    std::map<std::string, std::string> choices;
};

/// Adds --preset, --zukuri, --nagasa and the rest. `options` must outlive the parsing.
void add_blade_options(CLI::App& command, BladeOptions& options);

/// The preset (without one: the defaults of the zukuri), then the options over it; checked. Throws
/// InputError.
[[nodiscard]] KatanaPreset chosen_blade(const BladeOptions& options);

/// A preset from a file of at most 1 MiB. Throws InputError.
[[nodiscard]] KatanaPreset read_katana_preset(const std::filesystem::path& path);

/// All choices and dimensions by their keys.
[[nodiscard]] nlohmann::ordered_json json_of(const KatanaParameters& parameters);

}  // namespace togishi::cli
