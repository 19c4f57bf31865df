#include "spectral/table_file.hpp"

#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace togishi {

namespace {

constexpr std::string_view format_line = "togishi-table 1";

// Fields of a row; spaces separate only where no other separator does.
std::vector<std::string_view> split(std::string_view line) {
    std::vector<std::string_view> fields;
    const std::string_view separators =
        line.find_first_of(",;\t") != std::string_view::npos ? ",;\t" : " ";
    const bool by_space = separators == " ";
    std::size_t begin = 0;
    while (true) {
        const auto end = line.find_first_of(separators, begin);
        const auto field =
            trim(line.substr(begin, end == std::string_view::npos ? end : end - begin));
        if (!by_space || !field.empty()) fields.push_back(field);
        if (end == std::string_view::npos) return fields;
        begin = end + 1;
    }
}

void check_header(const TableFile& table, std::string_view kind, TableMetadata metadata) {
    const auto format = table.value("format");
    if (!format.empty() && format != format_line) {
        throw InputError(table.where, "format", shown(format), format_line);
    }
    const auto found = table.value("kind");
    if (!found.empty() && found != kind) {
        throw InputError(table.where, "kind", shown(found), kind);
    }
    if (metadata == TableMetadata::optional) return;
    for (const std::string_view key : {"format", "kind", "name", "title", "source", "licence"}) {
        if (table.value(key).empty()) {
            throw InputError(table.where, key, "missing",
                             "a line \"# " + std::string(key) + ": ...\" at the head of the file");
        }
    }
}

}  // namespace

std::string_view TableFile::value(std::string_view key) const {
    const auto found = header.find(key);
    return found == header.end() ? std::string_view{} : std::string_view{found->second};
}

std::string TableFile::at(std::size_t row) const {
    return where + ", line " + std::to_string(lines[row]);
}

TableFile parse_table(std::string_view text, std::string where, std::string_view kind,
                      std::size_t column_count, TableMetadata metadata) {
    TableFile table;
    table.where = std::move(where);
    table.columns.resize(column_count);
    text = checked_text(text, table.where);

    for (std::size_t line_number = 1; !text.empty(); ++line_number) {
        const auto line = trim(take_line(text));
        if (line.empty()) continue;
        const std::string at = table.where + ", line " + std::to_string(line_number);
        if (line.front() == '#') {
            const auto colon = line.find(':');
            if (colon == std::string_view::npos || table.rows() > 0) continue;
            const auto key = trim(line.substr(1, colon - 1));
            if (key.find(' ') == std::string_view::npos && table.header.size() < 100) {
                table.header.try_emplace(std::string(key), trim(line.substr(colon + 1)));
            }
            continue;
        }
        const auto fields = split(line);
        const bool any_number = [&] {
            for (const auto field : fields) {
                if (parse_number(field)) return true;
            }
            return false;
        }();
        if (!any_number && table.rows() == 0 && table.column_titles.empty()) {
            table.column_titles = line.substr(0, 200);
            continue;
        }
        if (fields.size() != column_count) {
            throw InputError(
                at, "row", shown(line) + " (" + std::to_string(fields.size()) + " fields)",
                std::to_string(column_count) +
                    " numbers with decimal points, separated by comma, semicolon, tab or space");
        }
        if (table.rows() == table_file_max_rows) {
            throw InputError(at, "number of rows",
                             "more than " + std::to_string(table_file_max_rows),
                             "at most that many");
        }
        for (std::size_t c = 0; c < column_count; ++c) {
            const auto value = parse_number(fields[c]);
            if (!value || !std::isfinite(*value)) {
                throw InputError(at, "column " + std::to_string(c + 1), shown(fields[c]),
                                 "a finite number with a decimal point");
            }
            table.columns[c].push_back(*value);
        }
        const double nm = table.columns[0].back();
        if (nm <= 0.0) {
            throw InputError(at, "wavelength", shown(fields[0]), "above 0 nm");
        }
        if (table.rows() > 0 && nm <= table.columns[0][table.rows() - 1]) {
            throw InputError(
                at, "wavelength", shown(fields[0]),
                "more than in the row before: each wavelength once, in increasing order");
        }
        table.lines.push_back(line_number);
    }
    check_header(table, kind, metadata);
    if (table.rows() == 0) {
        throw InputError(
            table.where, "content", "without a row of numbers",
            "rows of " + std::to_string(column_count) + " numbers, the first a wavelength in nm");
    }
    return table;
}

std::string read_table_text(const std::filesystem::path& path) {
    return read_text_file(path, table_file_max_bytes, "a CSV file");
}

}  // namespace togishi
