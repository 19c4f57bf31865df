#include "cli/text_table.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>

namespace togishi::cli {

namespace {

constexpr std::size_t number_width = 12;

std::string padded(const std::string& text, std::size_t width) {
    return std::string(width > text.size() ? width - text.size() : 0, ' ') + text;
}

}  // namespace

void print_table(std::ostream& out, const TextTable& table) {
    auto width = [&](std::size_t c) { return std::max(number_width, table.titles[c].size()) + 2; };
    for (std::size_t c = 0; c < table.titles.size(); ++c) out << padded(table.titles[c], width(c));
    out << '\n';
    for (std::size_t row = 0; row < table.columns[0].size(); ++row) {
        for (std::size_t c = 0; c < table.columns.size(); ++c) {
            std::array<char, 32> number{};
            std::snprintf(number.data(), number.size(), "%.6g", table.columns[c][row]);
            out << padded(number.data(), width(c));
        }
        out << '\n';
    }
}

nlohmann::ordered_json json_of(const TextTable& table) {
    nlohmann::ordered_json json;
    json["columns"] = table.titles;
    json["rows"] = nlohmann::ordered_json::array();
    for (std::size_t row = 0; row < table.columns[0].size(); ++row) {
        auto numbers = nlohmann::ordered_json::array();
        for (const auto& column : table.columns) numbers.push_back(column[row]);
        json["rows"].push_back(std::move(numbers));
    }
    return json;
}

}  // namespace togishi::cli
