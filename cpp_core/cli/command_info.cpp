// togishi info: this program and what is inside it; or what a file is.
#include <iostream>
#include <memory>
#include <string>

#include "cli/commands.hpp"
#include "cli/inspect.hpp"
#include "spectral/embedded_data.hpp"
#include "spectral/light.hpp"
#include "spectral/metal.hpp"
#include "spectral/observer.hpp"

namespace togishi::cli {

namespace {

using Json = nlohmann::ordered_json;

Json entry(std::string_view name, std::string_view title, std::string_view source,
           std::string_view licence) {
    return {{"name", name}, {"title", title}, {"source", source}, {"licence", licence}};
}

Json entry(const TableFile& table) {
    return entry(table.value("name"), table.value("title"), table.value("source"),
                 table.value("licence"));
}

Json about() {
    Json json;
    json["program"] = "togishi";
    json["version"] = TOGISHI_VERSION;
    json["licence"] = "GPL-3.0-or-later; each data file its own";
    json["compiler"] = TOGISHI_COMPILER;
    json["build_type"] = TOGISHI_BUILD_TYPE;
    json["metals"] = Json::array();
    for (const auto& metal : builtin_metals()) json["metals"].push_back(entry(metal->table()));
    json["lights"] = Json::array();
    for (const auto& light : builtin_lights()) {
        const auto& d = light->description();
        json["lights"].push_back(entry(d.name, d.title, d.source, d.licence));
    }
    json["light_laws"] = {"daylight:4000 to daylight:25000 (K)",
                          "blackbody:500 to blackbody:100000 (K)", "line:400 to line:700 (nm)",
                          "csv:FILE (wavelength in nm, power)"};
    json["observers"] = Json::array();
    for (const auto& observer : builtin_observers())
        json["observers"].push_back(entry(observer->table()));
    json["other_data"] = Json::array();
    for (const auto& file : embedded_files()) {
        const bool listed =
            file.path.ends_with(".csv") && !file.path.ends_with("daylight_components.csv");
        if (!listed) json["other_data"].push_back(file.path);
    }
    return json;
}

void print_line(const std::string& key, const Json& value) {
    std::cout << key << ": " << std::string(key.size() < 14 ? 14 - key.size() : 0, ' ')
              << (value.is_string() ? value.get<std::string>() : value.dump()) << '\n';
}

void print_text(const Json& json) {
    for (const auto& [key, value] : json.items()) {
        if (!value.is_array() || value.empty() || value.front().is_number()) {
            if (!value.is_array() || !value.empty()) print_line(key, value);
            continue;
        }
        std::cout << key << ":\n";
        for (const auto& item : value) {
            if (!item.is_object()) {
                std::cout << "  " << (item.is_string() ? item.get<std::string>() : item.dump())
                          << '\n';
                continue;
            }
            const auto name = item["name"].get<std::string>();
            std::cout << "  " << name << std::string(name.size() < 28 ? 28 - name.size() : 1, ' ')
                      << item["title"].get<std::string>() << "  ["
                      << item["licence"].get<std::string>() << "]\n";
        }
    }
}

void print_licences() {
    for (const auto& file : embedded_files()) {
        if (file.path.starts_with("LICENSE."))
            std::cout << "data/" << file.path << "\n\n" << file.text << '\n';
    }
}

}  // namespace

void add_info_command(CLI::App& app, const Common& common) {
    struct Options {
        std::string file;
        bool licences = false;
    };
    auto options = std::make_shared<Options>();
    auto* command = app.add_subcommand(
        "info", "Print version, build and built-in data; or what FILE is and its checks");
    command->add_option(
        "file", options->file,
        "A data table (.csv), a material or blade preset (.toml), a map (.exr) or a "
        "scan's record (.jsonld)");
    command->add_flag("--licences", options->licences,
                      "Print the licence texts of the built-in data");
    command->callback([options, &common] {
        if (options->licences) return print_licences();
        Json json = about();
        if (!options->file.empty()) {
            json = Json{{"file", options->file}};
            json.update(inspect_file(options->file));
        }
        if (common.json) {
            std::cout << json.dump(1, '\t', false, Json::error_handler_t::replace) << '\n';
        } else {
            print_text(json);
        }
    });
}

}  // namespace togishi::cli
