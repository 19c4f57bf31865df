#include "brdf/toml_reader.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <sstream>

namespace togishi::material_file {

std::string number_text(double value) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    std::string text(buffer.data(), end);
    // TOML tells 1 from 1.0.
    if (text.find_first_of(".einf") == std::string::npos) text += ".0";
    return text;
}

std::string text_of(const toml::node& node) {
    std::ostringstream out;
    if (node.is_table()) return "a table";
    if (node.is_array()) return "a list";
    if (const auto number = node.value_exact<double>()) return number_text(*number);
    node.visit([&](const auto& value) { out << value; });
    std::string text = out.str();
    constexpr std::size_t longest = 60;
    if (text.size() > longest) text = text.substr(0, longest) + "...";
    return text;
}

// A TOML basic string. Our own: what the library prints for a text with quotes and line ends, it
// does not read back.
std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (code < 0x20 || code == 0x7f) {
            std::array<char, 8> escape{};
            std::snprintf(escape.data(), escape.size(), "\\u%04X", code);
            out += escape.data();
        } else {
            out += c;
        }
    }
    return out + "\"";
}

}  // namespace togishi::material_file
