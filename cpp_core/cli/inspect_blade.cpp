#include "cli/blade_options.hpp"
#include "cli/inspect.hpp"

namespace togishi::cli {

nlohmann::ordered_json inspect_blade(const std::filesystem::path& path) {
    const KatanaPreset blade = read_katana_preset(path);
    nlohmann::ordered_json facts{{"kind", "blade preset"},
                                 {"title", blade.title},
                                 {"source", blade.source},
                                 {"licence", blade.licence}};
    facts.update(json_of(blade.parameters));
    facts["checks"] = "passed";
    return facts;
}

}  // namespace togishi::cli
