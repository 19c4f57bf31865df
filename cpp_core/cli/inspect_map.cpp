#include "cli/inspect.hpp"
#include "image/map_file.hpp"

namespace togishi::cli {

nlohmann::ordered_json inspect_map(const std::filesystem::path& path) {
    const auto file = read_map_file(path);
    const auto& map = file.levels.front();
    nlohmann::ordered_json facts{{"kind", "property map"},       {"size", {map.width, map.height}},
                                 {"levels", file.levels.size()}, {"chart_mm", file.info.chart_mm},
                                 {"source", file.info.source},   {"software", file.info.software}};
    auto channels = nlohmann::ordered_json::array();
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        if (map.channels[c].empty()) continue;
        const bool constant = map.channels[c].size() == 1;
        channels.push_back(std::string(map_channel_names[c]) + (constant ? " (constant)" : ""));
    }
    facts["channels"] = channels;
    facts["checks"] = file.repair.any() ? file.repair.sentence(path.string()) : "passed";
    return facts;
}

}  // namespace togishi::cli
