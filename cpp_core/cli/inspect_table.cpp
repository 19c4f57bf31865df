#include <string>
#include <utility>

#include "base/error.hpp"
#include "cli/inspect.hpp"
#include "spectral/light.hpp"
#include "spectral/metal.hpp"
#include "spectral/observer.hpp"

namespace togishi::cli {

namespace {

using Json = nlohmann::ordered_json;

// The kind that the file states, before its columns are known; an untitled table is a user's light.
std::string stated_kind(const std::string& text) {
    constexpr std::string_view key = "# kind:";
    const auto found = text.find(key);
    if (found == std::string::npos) return "light";
    const auto begin = text.find_first_not_of(" \t", found + key.size());
    const auto end = text.find_first_of(" \t\r\n", begin);
    return begin == std::string::npos ? std::string() : text.substr(begin, end - begin);
}

Json facts_of(std::string kind, const TableFile& table) {
    Json facts;
    facts["kind"] = std::move(kind);
    for (const auto& [key, value] : table.header) {
        if (key != "kind") facts[key] = value;
    }
    facts["rows"] = table.rows();
    facts["range_nm"] = Json::array({table.columns[0].front(), table.columns[0].back()});
    return facts;
}

}  // namespace

Json inspect_table(const std::filesystem::path& path) {
    const auto where = path.string();
    const auto text = read_table_text(path);
    const auto kind = stated_kind(text);
    Json facts;
    if (kind == "metal") {
        const Metal metal(parse_table(text, where, kind, 3, TableMetadata::required));
        facts = facts_of("table of a metal", metal.table());
    } else if (kind == "observer") {
        const Observer observer(parse_table(text, where, kind, 4, TableMetadata::required));
        facts = facts_of("table of an observer", observer.table());
    } else if (kind == "daylight_components") {
        facts = facts_of("table of daylight components",
                         parse_table(text, where, kind, 4, TableMetadata::required));
    } else if (kind == "light") {
        const auto light = light_from_csv(text, where, "csv:" + where);
        facts = facts_of("table of a light",
                         parse_table(text, where, kind, 2, TableMetadata::optional));
        facts["notes"] = light.description().notes;
    } else {
        throw InputError(where, "kind", "\"" + kind.substr(0, 40) + "\"",
                         "metal, light, observer, daylight_components");
    }
    facts["checks"] = "passed";
    return facts;
}

}  // namespace togishi::cli
