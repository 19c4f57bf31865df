// What a file is, and whether it passes its checks: the part of `togishi info FILE` that knows
// files.
#pragma once
#include <filesystem>

#include <nlohmann/json.hpp>

namespace togishi::cli {

/// {"kind": ..., what is in it}. Each throws InputError where the file fails its checks.
[[nodiscard]] nlohmann::ordered_json inspect_table(const std::filesystem::path& path);
[[nodiscard]] nlohmann::ordered_json inspect_material(const std::filesystem::path& path);
[[nodiscard]] nlohmann::ordered_json inspect_blade(const std::filesystem::path& path);
[[nodiscard]] nlohmann::ordered_json inspect_record(const std::filesystem::path& path);
[[nodiscard]] nlohmann::ordered_json inspect_map(const std::filesystem::path& path);

/// Tells the kind by the first bytes and the name, and inspects. Throws InputError for a kind that
/// Togishi does not read.
[[nodiscard]] nlohmann::ordered_json inspect_file(const std::filesystem::path& path);

}  // namespace togishi::cli
