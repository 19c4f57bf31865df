#include <sstream>

#define TOML_EXCEPTIONS 1
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

#include "base/error.hpp"
#include "blade/katana_file.hpp"

namespace togishi {

KatanaPreset parse_katana_preset(std::string_view text, std::string_view where) {
    toml::table file;
    try {
        file = toml::parse(text, where);
    } catch (const toml::parse_error& error) {
        std::ostringstream line;
        line << where << ", line " << error.source().begin.line;
        throw InputError(line.str(), "text", error.description(), "TOML");
    }
    KatanaPreset preset;
    auto take = [&](std::string_view key, std::string& target) {
        const auto value = file[key].value<std::string>();
        if (!value || value->empty())
            throw InputError(where, key, "missing or not a text", "a text in quotes");
        target = *value;
    };
    take("title", preset.title);
    take("source", preset.source);
    take("licence", preset.licence);
    for (const auto& [key, node] : file) {
        if (key != "title" && key != "source" && key != "licence" && key != "katana") {
            throw InputError(where, "key", key.str(), "title, source, licence, katana");
        }
    }
    const toml::table* dimensions = file["katana"].as_table();
    if (dimensions == nullptr) throw InputError(where, "katana", "missing", "a table [katana]");
    if (const auto zukuri = (*dimensions)["zukuri"].value<std::string>()) {
        set_katana_value(preset.parameters, "zukuri", std::string_view(*zukuri), where);
        preset.parameters = katana_defaults(*zukuri);
    }
    for (const auto& [key, node] : *dimensions) {
        if (const auto name = node.value_exact<std::string>()) {
            set_katana_value(preset.parameters, key.str(), std::string_view(*name), where);
        } else if (node.is_number()) {
            set_katana_value(preset.parameters, key.str(), *node.value<double>(), where);
        } else {
            throw InputError(where, key.str(), "neither number nor text",
                             "a number or a name in quotes");
        }
    }
    check_katana(preset.parameters, where);
    return preset;
}

}  // namespace togishi
