#include <array>
#include <fstream>
#include <sstream>
#include <string>
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

// A blade preset has a table [katana]; any other TOML is read, and where wrong refused, as a
// material. By its lines, so that a preset with an error in it is still told to be one.
bool is_blade_preset(const std::filesystem::path& path) {
    constexpr std::size_t enough = 1 << 20;
    std::string text(enough, '\0');
    std::ifstream in(path, std::ios::binary);
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::erase_if(line, [](char c) { return c == ' ' || c == '\t'; });
        if (line.starts_with("[katana]") || line.starts_with("katana=")) return true;
    }
    return false;
}

}  // namespace

nlohmann::ordered_json inspect_file(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        throw InputError(path.string(), "file", "missing or no regular file",
                         "a .csv, .toml, .exr or .jsonld file");
    }
    if (first_bytes(path) == exr_magic || path.extension() == ".exr") return inspect_map(path);
    if (path.extension() == ".jsonld") return inspect_record(path);
    if (path.extension() == ".toml")
        return is_blade_preset(path) ? inspect_blade(path) : inspect_material(path);
    return inspect_table(path);
}

}  // namespace togishi::cli
