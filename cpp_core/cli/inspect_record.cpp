#include <cmath>

#include "cli/inspect.hpp"
#include "scanned/record.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

Json files_of(const std::vector<RecordFile>& files) {
    Json all = Json::array();
    for (const RecordFile& file : files)
        all.push_back(file.name + " (" + file.role + "), " + std::to_string(file.bytes) +
                      " bytes, SHA-256 " + file.sha256);
    return all;
}

Json value_of(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

std::string sentence_of(const RecordDimension& d) {
    const Json number = value_of(d.value);
    std::string text = d.name + " " + (number.is_null() ? "not to be had" : number.dump());
    if (d.sigma) text += " ± " + Json(*d.sigma).dump();
    if (!d.unit.empty() && !number.is_null()) text += " " + d.unit;
    return d.note.empty() ? text : text + " (" + d.note + ")";
}

std::string sentence_of(const RecordStep& step) {
    std::string text = step.name;
    for (const auto& [name, value] : step.parameters) {
        text +=
            "; " + name + " = " + std::visit([](const auto& v) { return Json(v).dump(); }, value);
    }
    for (const RecordFigure& f : step.figures) {
        text += "; " + f.name + ": " + value_of(f.value).dump();
        if (!f.unit.empty()) text += " " + f.unit;
    }
    for (const std::string& note : step.notes) text += "; " + note;
    return text;
}

}  // namespace

Json inspect_record(const std::filesystem::path& path) {
    const ScanRecord record = read_record(path);
    Json facts{{"kind", "record of a scanned sword"}};
    for (const auto& [name, text] :
         {std::pair{"object", &record.object_id}, std::pair{"title", &record.title},
          std::pair{"holder", &record.holder}, std::pair{"rights", &record.rights},
          std::pair{"made", &record.created_utc}}) {
        if (!text->empty()) facts[name] = *text;
    }
    facts["software"] = "Togishi " + record.software_version;
    facts["unit"] = record.unit_how;
    facts["inputs"] = files_of(record.inputs);
    facts["outputs"] = files_of(record.outputs);
    facts["dimensions"] = Json::array();
    for (const RecordDimension& d : record.dimensions)
        facts["dimensions"].push_back(sentence_of(d));
    facts["steps"] = Json::array();
    for (const RecordStep& step : record.steps) facts["steps"].push_back(sentence_of(step));
    facts["inferred"] = record.inferred;
    facts["checks"] = "passed";
    return facts;
}

}  // namespace togishi::cli
