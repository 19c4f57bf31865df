#include "scanned/record.hpp"

#include <cmath>
#include <fstream>
#include <string_view>

#include <nlohmann/json.hpp>

#include "base/error.hpp"

namespace togishi {
namespace {

using Json = nlohmann::ordered_json;

constexpr int format = 1;
constexpr std::size_t longest = std::size_t{16} << 20;

constexpr const char* of_sword = "_:sword";
constexpr const char* of_software = "_:togishi";

std::string id_of(const RecordFile& file) {
    return file.sha256.empty() ? "_:" + file.role : "urn:sha256:" + file.sha256;
}

Json type_of(std::string_view label) {
    return {{"@type", "crm:E55_Type"}, {"rdfs:label", label}};
}

Json json_of(const RecordFile& file) {
    return {{"@id", id_of(file)},
            {"@type", "crmdig:D1_Digital_Object"},
            {"rdfs:label", file.name},
            {"crm:P2_has_type", type_of(file.role)},
            {"togishi:sha256", file.sha256},
            {"togishi:bytes", file.bytes}};
}

Json dimension_of(std::string_view name, double value, std::string_view unit) {
    Json dimension{{"@type", "crm:E54_Dimension"}, {"crm:P2_has_type", type_of(name)}};
    // JSON has no infinities; the reader of a record must not meet a null instead of a number.
    if (std::isfinite(value)) dimension["crm:P90_has_value"] = value;
    if (!unit.empty()) {
        dimension["crm:P91_has_unit"] = {{"@type", "crm:E58_Measurement_Unit"},
                                         {"rdfs:label", unit}};
    }
    return dimension;
}

Json json_of(const RecordDimension& d) {
    Json dimension = dimension_of(d.name, d.value, d.unit);
    if (d.sigma && std::isfinite(*d.sigma)) dimension["togishi:standard_uncertainty"] = *d.sigma;
    if (!d.note.empty()) dimension["crm:P3_has_note"] = d.note;
    return dimension;
}

Json json_of(const RecordStep& step, std::size_t number) {
    Json parameters = Json::object();
    for (const auto& parameter : step.parameters) {
        Json& to = parameters[parameter.first];
        std::visit([&to](const auto& v) { to = v; }, parameter.second);
    }
    Json figures = Json::array();
    for (const RecordFigure& f : step.figures)
        figures.push_back(dimension_of(f.name, f.value, f.unit));
    Json json{{"@id", "_:step" + std::to_string(number)},
              {"@type", "crmdig:D10_Software_Execution"},
              {"rdfs:label", step.name},
              {"crmdig:L23_used_software_or_firmware", {{"@id", of_software}}},
              {"crmdig:L13_used_parameters",
               {{"@type", "crmdig:D1_Digital_Object"}, {"togishi:parameters", parameters}}},
              {"togishi:figures", figures}};
    if (!step.notes.empty()) json["crm:P3_has_note"] = step.notes;
    return json;
}

Json links(const std::vector<RecordFile>& files) {
    Json all = Json::array();
    for (const RecordFile& file : files) all.push_back({{"@id", id_of(file)}});
    return all;
}

Json sword(const ScanRecord& record) {
    Json json{{"@id", of_sword}, {"@type", "crm:E22_Human-Made_Object"}};
    if (!record.title.empty()) json["rdfs:label"] = record.title;
    if (!record.object_id.empty()) {
        json["crm:P48_has_preferred_identifier"] = {{"@type", "crm:E42_Identifier"},
                                                    {"rdfs:label", record.object_id}};
    }
    if (!record.holder.empty()) {
        json["crm:P50_has_current_keeper"] = {{"@type", "crm:E39_Actor"},
                                              {"rdfs:label", record.holder}};
    }
    if (!record.rights.empty()) {
        json["crm:P104_is_subject_to"] = {{"@type", "crm:E30_Right"},
                                          {"rdfs:label", record.rights}};
    }
    json["crm:P43_has_dimension"] = Json::array();
    for (const RecordDimension& d : record.dimensions)
        json["crm:P43_has_dimension"].push_back(json_of(d));
    return json;
}

// --- reading ------------------------------------------------------------------------------------

// A place in the file, with what is asked of it.
struct Place {
    const Json& json;
    const std::string& where;

    [[noreturn]] void fail(const std::string& field, const char* allowed) const {
        std::string found = "missing";
        if (json.is_object() && json.contains(field)) {
            const Json& value = json[field];
            // A structure is not printed: it may be nested deeper than the printer's stack.
            found = value.is_structured()
                        ? std::string(value.type_name())
                        : value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 80);
        }
        throw InputError(where, field, found, allowed);
    }
    [[nodiscard]] const Json* find(const char* field) const {
        if (!json.is_object()) fail(field, "an object that has it");
        const auto it = json.find(field);
        return it == json.end() ? nullptr : &*it;
    }
    [[nodiscard]] std::string text(const char* field, bool needed = false) const {
        const Json* found = find(field);
        if (found == nullptr && !needed) return {};
        if (found == nullptr || !found->is_string()) fail(field, "text");
        return found->get<std::string>();
    }
    [[nodiscard]] double number(const char* field) const {
        const Json* found = find(field);
        if (found == nullptr || !found->is_number()) fail(field, "a number");
        return found->get<double>();
    }
    [[nodiscard]] const Json& list(const char* field) const {
        const Json* found = find(field);
        if (found == nullptr || !found->is_array()) fail(field, "a list");
        return *found;
    }
    [[nodiscard]] const Json& member(const char* field) const {
        const Json* found = find(field);
        if (found == nullptr || !found->is_object()) fail(field, "an object");
        return *found;
    }
    [[nodiscard]] std::string label_of(const char* field) const {
        const Json* found = find(field);
        return found == nullptr ? std::string() : Place{*found, where}.text("rdfs:label");
    }
    [[nodiscard]] std::vector<std::string> texts(const char* field) const {
        std::vector<std::string> all;
        if (find(field) == nullptr) return all;
        for (const Json& one : list(field)) {
            if (!one.is_string()) fail(field, "a list of texts");
            all.push_back(one.get<std::string>());
        }
        return all;
    }
};

double value_of(const Place& dimension) {
    return dimension.find("crm:P90_has_value") == nullptr ? NAN
                                                          : dimension.number("crm:P90_has_value");
}

RecordDimension dimension_from(const Place& place) {
    RecordDimension d;
    d.name = place.label_of("crm:P2_has_type");
    d.value = value_of(place);
    d.unit = place.label_of("crm:P91_has_unit");
    d.note = place.text("crm:P3_has_note");
    if (place.find("togishi:standard_uncertainty") != nullptr)
        d.sigma = place.number("togishi:standard_uncertainty");
    return d;
}

RecordFile file_from(const Place& place) {
    const double bytes = place.number("togishi:bytes");
    constexpr double most = 1e18;
    if (!(bytes >= 0 && bytes <= most)) place.fail("togishi:bytes", "0 to 1e18");
    return {place.text("rdfs:label", true), place.label_of("crm:P2_has_type"),
            place.text("togishi:sha256"), static_cast<std::uint64_t>(bytes)};
}

RecordStep step_from(const Place& place) {
    RecordStep step;
    step.name = place.text("rdfs:label", true);
    if (const Json* used = place.find("crmdig:L13_used_parameters")) {
        const Json& all = Place{*used, place.where}.member("togishi:parameters");
        for (const auto& [name, value] : all.items()) {
            if (value.is_boolean()) {
                step.parameters.emplace_back(name, value.get<bool>());
            } else if (value.is_number()) {
                step.parameters.emplace_back(name, value.get<double>());
            } else if (value.is_string()) {
                step.parameters.emplace_back(name, value.get<std::string>());
            } else {
                place.fail("crmdig:L13_used_parameters", "numbers, texts, true and false");
            }
        }
    }
    for (const Json& one : place.list("togishi:figures")) {
        const RecordDimension d = dimension_from({one, place.where});
        step.figures.push_back({d.name, d.value, d.unit});
    }
    step.notes = place.texts("crm:P3_has_note");
    return step;
}

}  // namespace

std::string record_json(const ScanRecord& record) {
    Json graph = Json::array();
    graph.push_back(sword(record));
    graph.push_back({{"@id", of_software},
                     {"@type", "crmdig:D14_Software"},
                     {"rdfs:label", "Togishi " + record.software_version},
                     {"togishi:version", record.software_version}});
    for (const RecordFile& file : record.inputs) {
        Json json = json_of(file);
        json["crm:P129_is_about"] = {{"@id", of_sword}};
        graph.push_back(json);
    }
    for (const RecordFile& file : record.outputs) {
        Json json = json_of(file);
        json["crm:P129_is_about"] = {{"@id", of_sword}};
        graph.push_back(json);
    }
    Json import{{"@id", "_:import"},
                {"@type", "crmdig:D3_Formal_Derivation"},
                {"crmdig:L21_used_as_derivation_source", links(record.inputs)},
                {"crmdig:L22_created_derivative", links(record.outputs)},
                {"crmdig:L23_used_software_or_firmware", {{"@id", of_software}}},
                {"togishi:mm_per_unit", record.mm_per_unit},
                {"togishi:unit_decision", record.unit_how},
                {"togishi:inferred", record.inferred},
                {"crm:P9_consists_of", Json::array()}};
    if (!record.created_utc.empty()) {
        import["crm:P4_has_time-span"] = {{"@type", "crm:E52_Time-Span"},
                                          { "crm:P82_at_some_time_within",
                                            { {"@type", "xsd:dateTime"},
                                              { "@value",
                                                record.created_utc } } }};
    }
    for (std::size_t i = 0; i < record.steps.size(); ++i)
        import["crm:P9_consists_of"].push_back(json_of(record.steps[i], i + 1));
    graph.push_back(import);
    const Json whole{{"@context",
                      {{"crm", "http://www.cidoc-crm.org/cidoc-crm/"},
                       {"crmdig", "http://www.ics.forth.gr/isl/CRMdig/"},
                       {"rdfs", "http://www.w3.org/2000/01/rdf-schema#"},
                       {"xsd", "http://www.w3.org/2001/XMLSchema#"},
                       {"togishi", "urn:togishi:record:"}}},
                     {"togishi:format", format},
                     {"@graph", graph}};
    return whole.dump(1, '\t', false, Json::error_handler_t::replace) + "\n";
}

ScanRecord parse_record(std::string_view text, const std::string& where) {
    if (text.size() > longest)
        throw InputError(where, "size", std::to_string(text.size()) + " bytes", "at most 16 MiB");
    const Json whole = Json::parse(text, nullptr, false);
    if (whole.is_discarded()) throw InputError(where, "file", "no JSON", "a record of a scan");
    const Place top{whole, where};
    if (top.find("togishi:format") == nullptr)
        throw InputError(where, "togishi:format", "missing", "a record of a scan by Togishi");
    if (top.number("togishi:format") != format) top.fail("togishi:format", "1");
    ScanRecord record;
    const Json* import = nullptr;
    std::vector<RecordFile> files;
    std::vector<std::string> ids;
    for (const Json& node : top.list("@graph")) {
        const Place place{node, where};
        const std::string type = place.text("@type", true);
        if (type == "crm:E22_Human-Made_Object") {
            record.title = place.text("rdfs:label");
            record.object_id = place.label_of("crm:P48_has_preferred_identifier");
            record.holder = place.label_of("crm:P50_has_current_keeper");
            record.rights = place.label_of("crm:P104_is_subject_to");
            for (const Json& one : place.list("crm:P43_has_dimension"))
                record.dimensions.push_back(dimension_from({one, where}));
        } else if (type == "crmdig:D14_Software") {
            record.software_version = place.text("togishi:version");
        } else if (type == "crmdig:D1_Digital_Object") {
            files.push_back(file_from(place));
            ids.push_back(place.text("@id", true));
        } else if (type == "crmdig:D3_Formal_Derivation") {
            import = &node;
        }
    }
    if (import == nullptr)
        throw InputError(where, "crmdig:D3_Formal_Derivation", "missing", "one in @graph");
    const Place place{*import, where};
    record.mm_per_unit = place.number("togishi:mm_per_unit");
    record.unit_how = place.text("togishi:unit_decision");
    record.inferred = place.texts("togishi:inferred");
    if (const Json* span = place.find("crm:P4_has_time-span")) {
        if (const Json* time = Place{*span, where}.find("crm:P82_at_some_time_within"))
            record.created_utc = Place{*time, where}.text("@value", true);
    }
    for (const auto& [field, to] :
         {std::pair{"crmdig:L21_used_as_derivation_source", &record.inputs},
          std::pair{"crmdig:L22_created_derivative", &record.outputs}}) {
        for (const Json& link : place.list(field)) {
            const std::string id = Place{link, where}.text("@id", true);
            for (std::size_t i = 0; i < ids.size(); ++i) {
                if (ids[i] != id) continue;
                to->push_back(files[i]);
                break;
            }
        }
    }
    for (const Json& step : place.list("crm:P9_consists_of"))
        record.steps.push_back(step_from({step, where}));
    return record;
}

ScanRecord read_record(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file.string(), "file", "missing or unreadable", "a record (.jsonld)");
    std::string text(longest + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    return parse_record(text, file.string());
}

}  // namespace togishi
