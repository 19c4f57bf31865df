#include "base/text.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <system_error>

#include "base/error.hpp"

namespace togishi {

std::string whole_number(double value) {
    std::array<char, 330> text{};  // the largest double has 309 digits
    std::snprintf(text.data(), text.size(), "%.0f", value);
    return text.data();
}

std::string size_in_mm(double length, double width, double height) {
    return whole_number(length) + " x " + whole_number(width) + " x " + whole_number(height) +
           " mm";
}

std::string_view trim(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string shown(std::string_view text) {
    constexpr std::size_t longest = 40;
    std::string out = "\"";
    for (const char c : text.substr(0, longest)) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x20U && byte < 0x7fU) {
            out += c;
        } else {
            std::array<char, 8> hex{};
            std::snprintf(hex.data(), hex.size(), "\\x%02x", static_cast<unsigned>(byte));
            out += hex.data();
        }
    }
    return out + (text.size() > longest ? "...\"" : "\"");
}

std::optional<double> parse_number(std::string_view field) {
    if (!field.empty() && field.front() == '+') field.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
    return value;
}

std::string_view take_line(std::string_view& text) {
    const auto end = text.find_first_of("\r\n");
    const auto line = text.substr(0, end);
    if (end == std::string_view::npos) {
        text = {};
    } else {
        const bool crlf = text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n';
        text.remove_prefix(end + (crlf ? 2 : 1));
    }
    return line;
}

std::string_view checked_text(std::string_view text, const std::string& where) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
        throw InputError(where, "encoding", "UTF-16", "UTF-8 or ASCII text");
    }
    if (text.find('\0') != std::string_view::npos) {
        throw InputError(where, "content", "binary (it holds zero bytes)", "UTF-8 or ASCII text");
    }
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    return text;
}

std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes,
                           const std::string& what) {
    const std::string where = path.string();
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
        throw InputError(where, "file", "missing", "an existing file: " + what);
    }
    if (!std::filesystem::is_regular_file(status)) {
        throw InputError(where, "file", "a folder or a device", what);
    }
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(where, "file", "unreadable", "a file that you may read");
    // In pieces, up to one byte more than allowed, instead of trusting the size stated beforehand.
    constexpr std::size_t piece = std::size_t{1} << 20U;
    std::string text;
    while (in && text.size() <= max_bytes) {
        const std::size_t before = text.size();
        text.resize(before + piece);
        in.read(text.data() + before, static_cast<std::streamsize>(piece));
        text.resize(before + static_cast<std::size_t>(in.gcount()));
    }
    if (in.bad()) throw InputError(where, "file", "unreadable", "a file that you may read");
    if (text.size() > max_bytes) {
        const std::string mib = std::to_string(max_bytes >> 20U) + " MiB";
        throw InputError(where, "size", "more than " + mib, "at most " + mib);
    }
    return text;
}

}  // namespace togishi
