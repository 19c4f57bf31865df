#include "mesh_file/data_uri.hpp"

#include <cstdint>

namespace togishi {
namespace {

constexpr std::string_view mark = ";base64,";

int sextet(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

bool is_data_uri(std::string_view uri) {
    return uri.starts_with("data:");
}

std::optional<std::vector<unsigned char>> data_uri_bytes(std::string_view uri) {
    const auto at = uri.find(mark);
    if (!is_data_uri(uri) || at == std::string_view::npos) return std::nullopt;
    std::string_view text = uri.substr(at + mark.size());
    while (text.ends_with('=')) text.remove_suffix(1);
    std::vector<unsigned char> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t held = 0;
    unsigned bits = 0;
    for (const char c : text) {
        const int value = sextet(c);
        if (value < 0) return std::nullopt;
        held = (held << 6U | static_cast<std::uint32_t>(value)) & 0xFFFFU;
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<unsigned char>(held >> bits));
    }
    return bytes;
}

}  // namespace togishi
