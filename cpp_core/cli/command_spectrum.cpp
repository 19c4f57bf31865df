// togishi spectrum: what a metal, a light or an observer is made of, and the RGB table of a metal
// under a light.
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <variant>

#include "bake/fresnel_table.hpp"
#include "base/error.hpp"
#include "brdf/model.hpp"
#include "cli/commands.hpp"
#include "cli/text_table.hpp"

namespace togishi::cli {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string name;
    std::string light;
    std::string observer{default_observer};
    std::string space{default_colour_space};
    std::string adaptation = "none";
    std::size_t size = default_table_size;
    bool samples = false;
};

// What is printed: facts as "key  value" lines above a table. The JSON object has the same keys.
struct Report {
    Json facts;
    TextTable table;
};

Json json_of(const glm::dvec3& v) {
    return Json::array({v.x, v.y, v.z});
}

std::vector<double> reflectance(const RefractiveIndex& index, double cos_theta) {
    std::vector<double> f(index.n.size());
    for (std::size_t i = 0; i < f.size(); ++i)
        f[i] = f64::fresnel_conductor(index.n[i], index.k[i], cos_theta);
    return f;
}

void add_colour(Json& facts, const Options& options, const std::string& key, const glm::dvec3& xyz,
                const glm::dvec3& light_white) {
    const auto matrix = rgb_from_xyz(find_colour_space(options.space),
                                     find_adaptation(options.adaptation), light_white);
    const double sum = xyz.x + xyz.y + xyz.z;
    facts[key + "_xyz"] = json_of(xyz);
    facts[key + "_xy"] = Json::array({xyz.x / sum, xyz.y / sum});
    facts[key + "_rgb"] = json_of(matrix * xyz);
}

void add_colour_settings(Json& facts, const Options& options) {
    facts["observer"] = options.observer;
    facts["space"] = options.space;
    facts["adaptation"] = options.adaptation;
}

Json header_of(std::string_view kind, const TableFile& table) {
    Json facts;
    facts["kind"] = kind;
    for (const auto* key : {"name", "title", "source", "licence", "note"}) {
        if (!table.value(key).empty()) facts[key] = table.value(key);
    }
    return facts;
}

Report report_metal(const Metal& metal, const Options& options) {
    Report report{header_of("metal", metal.table()), {{"wavelength_nm", "n", "k", "F_0deg"}, {}}};
    report.facts["range_nm"] = Json::array({metal.first_nm(), metal.last_nm()});
    auto nm = options.samples ? grid_61.wavelengths_nm() : metal.table().columns[0];
    auto index = metal.at(nm);
    auto at_normal = reflectance(index, 1.0);

    const auto weights =
        colour_weights(*find_light(default_light), *find_observer(options.observer));
    add_colour(report.facts, options, "d65_0deg", weights.xyz(reflectance(metal.at(grid_61), 1.0)),
               weights.white);
    add_colour_settings(report.facts, options);
    report.table.columns = {std::move(nm), std::move(index.n), std::move(index.k),
                            std::move(at_normal)};
    return report;
}

Report report_light(const Light& light, const Options& options) {
    const auto& d = light.description();
    Report report{{{"kind", "light"},
                   {"name", d.name},
                   {"title", d.title},
                   {"source", d.source},
                   {"licence", d.licence},
                   {"notes", d.notes}},
                  {{"wavelength_nm", "relative_power"}, {}}};
    const auto* table = std::get_if<TableSpectrum>(&light.shape());
    if (table != nullptr && !options.samples) {
        report.table.columns = {table->wavelengths_nm, table->power};
    } else {
        report.table.columns = {grid_61.wavelengths_nm(), light.sample(grid_61)};
    }
    const auto white = colour_weights(light, *find_observer(options.observer)).white;
    add_colour(report.facts, options, "white", white, white);
    add_colour_settings(report.facts, options);
    return report;
}

Report report_observer(const Observer& observer, const Options& options) {
    Report report{header_of("observer", observer.table()),
                  {{"wavelength_nm", "x_bar", "y_bar", "z_bar"}, {}}};
    report.table.columns = observer.table().columns;
    if (options.samples) {
        auto functions = observer.at(grid_61);
        report.table.columns = {grid_61.wavelengths_nm(), std::move(functions[0]),
                                std::move(functions[1]), std::move(functions[2])};
    }
    return report;
}

Report report_fresnel_table(const Metal& metal, const Options& options) {
    FresnelTableRequest request;
    request.metal = options.name;
    request.light = options.light;
    request.observer = options.observer;
    request.space = options.space;
    request.size = options.size;
    request.adaptation = options.adaptation;
    const auto rgb = fresnel_table(request);
    const auto light = find_light(options.light);

    Report report{{{"kind", "fresnel_table"},
                   {"metal", metal.name()},
                   {"metal_title", metal.table().value("title")},
                   {"metal_source", metal.table().value("source")},
                   {"light", light->description().name},
                   {"light_title", light->description().title},
                   {"light_source", light->description().source},
                   {"notes", light->description().notes}},
                  {{"cos_theta", "theta_deg", "R", "G", "B"}, std::vector<std::vector<double>>(5)}};
    add_colour_settings(report.facts, options);
    for (std::size_t i = 0; i < options.size; ++i) {
        const double c =
            f64::fresnel_table_cosine(static_cast<double>(i), static_cast<double>(options.size));
        report.table.columns[0].push_back(c);
        report.table.columns[1].push_back(std::acos(c) * 180.0 / std::numbers::pi);
        for (std::size_t channel = 0; channel < 3; ++channel) {
            report.table.columns[2 + channel].push_back(static_cast<double>(rgb[3 * i + channel]));
        }
    }
    return report;
}

std::string text_of(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_array()) return value.dump();
    std::string text;
    for (const auto& item : value) {
        const bool number = item.is_number();
        if (!text.empty()) text += number ? " " : "; ";
        char buffer[32];
        std::snprintf(buffer, sizeof buffer, "%.6g", number ? item.get<double>() : 0.0);
        text += number ? std::string(buffer) : item.get<std::string>();
    }
    return text;
}

void print(const Report& report, bool as_json) {
    if (as_json) {
        Json json = report.facts;
        json.update(json_of(report.table));
        std::cout << json.dump(1, '\t', false, Json::error_handler_t::replace) << '\n';
        return;
    }
    for (const auto& [key, value] : report.facts.items()) {
        const auto text = text_of(value);
        if (text.empty()) continue;
        std::cout << key << ':' << std::string(key.size() < 16 ? 16 - key.size() : 1, ' ') << text
                  << '\n';
    }
    std::cout << '\n';
    print_table(std::cout, report.table);
}

// A user's file says itself whether it is a metal; without a word about it, it is a light.
bool is_metal_file(const std::string& name) {
    const bool prefixed = name.starts_with("csv:");
    const std::filesystem::path path(prefixed ? name.substr(4) : name);
    if (!prefixed && !path.has_parent_path() && path.extension() != ".csv") return false;
    const auto text = read_table_text(path);
    return text.find("# kind: metal") != std::string::npos;
}

std::string light_name(const std::string& name) {
    const std::filesystem::path path(name);
    const bool bare_path = name.find(':') == std::string::npos &&
                           (path.has_parent_path() || path.extension() == ".csv");
    return bare_path ? "csv:" + name : name;
}

std::string known_names() {
    std::string known;
    for (const auto& metal : builtin_metals()) known += std::string(metal->name()) + ", ";
    for (const auto& light : builtin_lights()) known += light->description().name + ", ";
    for (const auto& observer : builtin_observers()) known += std::string(observer->name()) + ", ";
    return known + "daylight:K, blackbody:K, line:NM, or the path of a .csv file";
}

template <class All, class NameOf>
bool has_name(const All& all, const std::string& name, NameOf name_of) {
    for (const auto& one : all) {
        if (name_of(*one) == name) return true;
    }
    return false;
}

Report report_on(Options options) {
    const auto own_name = [](const auto& thing) { return thing.name(); };
    if (has_name(builtin_metals(), options.name, own_name) || is_metal_file(options.name)) {
        const auto metal = find_metal(options.name);
        if (options.light.empty()) return report_metal(*metal, options);
        options.light = light_name(options.light);
        return report_fresnel_table(*metal, options);
    }
    if (!options.light.empty()) {
        throw InputError("togishi spectrum --light", "name",
                         "\"" + options.name + "\", which is no metal",
                         "a metal, to be seen under the light");
    }
    if (has_name(builtin_observers(), options.name, own_name)) {
        return report_observer(*find_observer(options.name), options);
    }
    options.name = light_name(options.name);
    const auto is_light = [](const auto& light) {
        return std::string_view(light.description().name);
    };
    if (!has_name(builtin_lights(), options.name, is_light) &&
        options.name.find(':') == std::string::npos) {
        throw InputError("togishi spectrum", "name", "\"" + options.name + "\"", known_names());
    }
    return report_light(*find_light(options.name), options);
}

}  // namespace

void add_spectrum_command(CLI::App& app, const Common& common) {
    auto options = std::make_shared<Options>();
    auto* command = app.add_subcommand("spectrum",
                                       "Print a metal, a light or an observer; with --light, the "
                                       "RGB table of a metal under a light");
    command
        ->add_option(
            "name", options->name,
            "A name that \"togishi info\" lists, daylight:K, blackbody:K, line:NM or a .csv file")
        ->required();
    command->add_option("--light", options->light,
                        "Print the RGB table of the metal under this light");
    command->add_option("--observer", options->observer, "cie1931_2 or cie1964_10")
        ->capture_default_str();
    command->add_option("--space", options->space, "rec709, rec2020, acescg, acescg_d65 or xyz")
        ->capture_default_str();
    command
        ->add_option("--adaptation", options->adaptation,
                     "To the space's white: none, bradford or cat16")
        ->capture_default_str();
    command->add_option("--size", options->size, "Rows of the RGB table, 2 to 4096")
        ->capture_default_str();
    command->add_flag("--samples", options->samples,
                      "Print the 61 samples from 400 to 700 nm, not the rows of the file");
    command->callback([options, &common] { print(report_on(*options), common.json); });
}

}  // namespace togishi::cli
