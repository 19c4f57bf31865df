#include "brdf/material.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <system_error>

#include "base/error.hpp"
#include "brdf/fit_record_toml.hpp"
#include "brdf/toml_reader.hpp"
#include "spectral/embedded_data.hpp"
#include "spectral/metal.hpp"

namespace togishi {
namespace {

using material_file::number_text;
using material_file::quoted;
using material_file::Reader;
using material_file::Source;
using material_file::text_of;

constexpr std::uintmax_t max_file_bytes = 1 << 20;

MaterialLobe read_lobe(Reader& reader, std::string_view weight_key, Weights weights) {
    MaterialLobe lobe;
    lobe.mu_t_deg = reader.number("mu_t_deg", 0.001, 80, "0.001 to 80 degrees");
    lobe.mu_b_deg = reader.number("mu_b_deg", 0.001, 80, "0.001 to 80 degrees");
    // Decimal fractions do not divide exactly.
    constexpr double slack = 1.0 + 1.0e-9;
    if (lobe.mu_b_deg > lobe.mu_t_deg || lobe.mu_t_deg > 100.0 * slack * lobe.mu_b_deg) {
        reader.fail(*reader.find("mu_b_deg"), "mu_b_deg", number_text(lobe.mu_b_deg),
                    "mu_t_deg/100 to mu_t_deg, here " + number_text(lobe.mu_t_deg / 100) + " to " +
                        number_text(lobe.mu_t_deg) + " degrees");
    }
    lobe.rho_deg = reader.number("rho_deg", 0, 180, "0 to 180 degrees");
    if (lobe.rho_deg == 180) lobe.rho_deg = 0;
    if (weight_key.empty()) return lobe;
    if (weights == Weights::measured) {
        lobe.weight = reader.number(weight_key, std::numeric_limits<double>::min(), 1e8,
                                    "above 0, to 1e8 (weights are measured)");
    } else if (const toml::node* node = reader.find(weight_key)) {
        reader.fail(*node, weight_key, text_of(*node), "only where weights = \"measured\"");
    }
    return lobe;
}

void read_nakago(Reader& reader, Material& material) {
    material.nakago = read_lobe(reader, "", material.weights);
    constexpr std::string_view allowed = "three numbers, 0 to 1 (linear red, green, blue)";
    const toml::node& node = reader.require("albedo_rgb", allowed);
    const toml::array* list = node.as_array();
    if (list == nullptr || list->size() != 3) {
        reader.fail(node, "albedo_rgb",
                    list == nullptr ? text_of(node) : std::to_string(list->size()) + " values",
                    allowed);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        material.nakago_albedo_rgb[i] =
            reader.checked_number(*list->get(i), "albedo_rgb", 0, 1, allowed);
    }
    material.nakago_ior = reader.number("ior", 1, 4, "1 to 4");
}

Material read_material(const toml::table& table, const Source& where) {
    Reader reader(table, "", where);
    const toml::node& format = reader.require("format", "1");
    if (format.value_exact<std::int64_t>() != material_format) {
        reader.fail(format, "format", text_of(format), "1 (the schema that this version knows)");
    }
    Material material;
    material.name = reader.text("name", "text", false);
    if (material.name.empty()) reader.fail(*reader.find("name"), "name", "empty", "text");
    material.metal = reader.text("metal", "the name of a metal or the path of its file", false);
    try {
        (void)find_metal(material.metal);
    } catch (const InputError& error) {
        reader.fail(*reader.find("metal"), "metal",
                    "\"" + material.metal + "\" (" + error.what() + ")",
                    "the name of a built-in metal or the path of a metal file");
    }
    const std::string weights = reader.text("weights", "\"normalised\" or \"measured\"", false);
    if (weights != "normalised" && weights != "measured") {
        reader.fail(*reader.find("weights"), "weights", "\"" + weights + "\"",
                    "\"normalised\" or \"measured\"");
    }
    material.weights = weights == "measured" ? Weights::measured : Weights::normalised;
    material.source = reader.text("source", "text", true);
    material.licence = reader.text("licence", "text", true);

    Reader parts(reader.table("parts"), "parts.", where);
    for (const MaterialLobeField& field : material_lobes) {
        Reader part(parts.table(field.key), "parts." + std::string(field.key) + ".", where);
        if (field.key == "nakago") {
            read_nakago(part, material);
        } else {
            material.*field.member = read_lobe(part, field.weight_key, material.weights);
        }
        part.refuse_unknown();
    }
    parts.refuse_unknown();
    if (reader.find("fit") != nullptr) {
        material.fits = material_file::read_fit_records(reader.table("fit"), where);
    }
    reader.refuse_unknown();
    return material;
}

const EmbeddedFile* find_builtin(std::string_view name) {
    const std::string path = "materials/" + std::string(name) + ".toml";
    for (const EmbeddedFile& file : embedded_files()) {
        if (file.path == path) return &file;
    }
    return nullptr;
}

}  // namespace

Material material_from_toml(std::string_view text, const std::string& where, SourceLines lines) {
    toml::table table;
    try {
        table = toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw InputError(where + ":" + std::to_string(error.source().begin.line), "text",
                         "no TOML (" + std::string(error.description()) + ")",
                         "a material as TOML");
    }
    return read_material(table, {where, lines});
}

std::string material_to_toml(const Material& material) {
    std::string text = "format = " + std::to_string(material_format) + "\n";
    const auto line = [&](std::string_view key, const std::string& value) {
        text += std::string(key) + " = " + value + "\n";
    };
    line("name", quoted(material.name));
    line("metal", quoted(material.metal));
    line("weights", material.weights == Weights::measured ? "\"measured\"" : "\"normalised\"");
    if (!material.source.empty()) line("source", quoted(material.source));
    if (!material.licence.empty()) line("licence", quoted(material.licence));
    for (const MaterialLobeField& field : material_lobes) {
        const MaterialLobe& lobe = material.*field.member;
        text += "\n[parts." + std::string(field.key) + "]\n";
        if (field.key == "nakago") {
            const auto& rgb = material.nakago_albedo_rgb;
            line("albedo_rgb", "[" + number_text(rgb[0]) + ", " + number_text(rgb[1]) + ", " +
                                   number_text(rgb[2]) + "]");
            line("ior", number_text(material.nakago_ior));
        }
        line("mu_t_deg", number_text(lobe.mu_t_deg));
        line("mu_b_deg", number_text(lobe.mu_b_deg));
        line("rho_deg", number_text(lobe.rho_deg));
        if (!field.weight_key.empty() && material.weights == Weights::measured) {
            line(field.weight_key, number_text(lobe.weight));
        }
    }
    for (const FitRecord& fit : material.fits) text += "\n" + material_file::fit_record_text(fit);
    return text;
}

Material load_material(const std::string& name_or_path) {
    if (const EmbeddedFile* file = find_builtin(name_or_path)) {
        return material_from_toml(file->text, std::string(file->path));
    }
    std::error_code error;
    const auto bytes = std::filesystem::file_size(name_or_path, error);
    if (error) {
        std::string names;
        for (const auto& name : builtin_materials()) names += name + ", ";
        throw InputError(name_or_path, "file", error.message(),
                         "a built-in material (" + names.substr(0, names.size() - 2) +
                             ") or the path of a .toml file");
    }
    if (bytes > max_file_bytes) {
        throw InputError(name_or_path, "size", std::to_string(bytes) + " bytes", "up to 1 MiB");
    }
    std::ifstream in(name_or_path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!in) throw InputError(name_or_path, "file", "unreadable", "a file that you may read");
    return material_from_toml(text, name_or_path);
}

std::vector<std::string> builtin_materials() {
    std::vector<std::string> names{std::string(default_material_name)};
    constexpr std::string_view folder = "materials/", extension = ".toml";
    for (const EmbeddedFile& file : embedded_files()) {
        if (!file.path.starts_with(folder) || !file.path.ends_with(extension)) continue;
        std::string name(
            file.path.substr(folder.size(), file.path.size() - folder.size() - extension.size()));
        if (name != default_material_name) names.push_back(std::move(name));
    }
    return names;
}

Material default_material() {
    return load_material(std::string(default_material_name));
}

}  // namespace togishi
