#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "cli/inspect.hpp"

namespace togishi::cli {

namespace {

// OpenEXR's magic number, 20000630 in little-endian order.
constexpr std::string_view exr_magic("\x76\x2f\x31\x01", 4);

std::string first_bytes(const std::filesystem::path& path) {
    std::array<char, 4> bytes{};
    std::ifstream in(path, std::ios::binary);
    in.read(bytes.data(), bytes.size());
    return {bytes.data(), static_cast<std::size_t>(in.gcount())};
}

}  // namespace

nlohmann::ordered_json inspect_file(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        throw InputError(path.string(), "file", "missing or no regular file",
                         "a .csv, .toml or .exr file");
    }
    if (first_bytes(path) == exr_magic) return inspect_map(path);
    if (path.extension() == ".toml") return inspect_material(path);
    return inspect_table(path);
}

}  // namespace togishi::cli
