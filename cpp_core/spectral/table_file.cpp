#include "spectral/table_file.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace togishi {

namespace {

constexpr std::string_view format_line = "togishi-table 1";

std::string_view trim(std::string_view s) {
    const auto first = s.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
}

// What a file holds may be anything: short and printable before it goes into a message.
std::string quoted(std::string_view s) {
    std::string out = "\"";
    for (const char c : s.substr(0, 40)) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x20U && byte < 0x7fU) {
            out += c;
        } else {
            std::array<char, 8> hex{};
            std::snprintf(hex.data(), hex.size(), "\\x%02x", static_cast<unsigned>(byte));
            out += hex.data();
        }
    }
    return out + (s.size() > 40 ? "...\"" : "\"");
}

std::optional<double> number(std::string_view field) {
    if (!field.empty() && field.front() == '+') field.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
    return value;
}

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

// Takes the next line off the front of `text`; LF, CRLF and CR end a line.
std::string_view next_line(std::string_view& text) {
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

void check_encoding(std::string_view text, const std::string& where) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
        throw InputError(where, "encoding", "UTF-16", "UTF-8 or ASCII text");
    }
    if (text.find('\0') != std::string_view::npos) {
        throw InputError(where, "content", "binary (it holds zero bytes)", "UTF-8 or ASCII text");
    }
}

void check_header(const TableFile& table, std::string_view kind, TableMetadata metadata) {
    const auto format = table.value("format");
    if (!format.empty() && format != format_line) {
        throw InputError(table.where, "format", quoted(format), format_line);
    }
    const auto found = table.value("kind");
    if (!found.empty() && found != kind) {
        throw InputError(table.where, "kind", quoted(found), kind);
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
    check_encoding(text, table.where);
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);

    for (std::size_t line_number = 1; !text.empty(); ++line_number) {
        const auto line = trim(next_line(text));
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
                if (number(field)) return true;
            }
            return false;
        }();
        if (!any_number && table.rows() == 0 && table.column_titles.empty()) {
            table.column_titles = line.substr(0, 200);
            continue;
        }
        if (fields.size() != column_count) {
            throw InputError(
                at, "row", quoted(line) + " (" + std::to_string(fields.size()) + " fields)",
                std::to_string(column_count) +
                    " numbers with decimal points, separated by comma, semicolon, tab or space");
        }
        if (table.rows() == table_file_max_rows) {
            throw InputError(at, "number of rows",
                             "more than " + std::to_string(table_file_max_rows),
                             "at most that many");
        }
        for (std::size_t c = 0; c < column_count; ++c) {
            const auto value = number(fields[c]);
            if (!value || !std::isfinite(*value)) {
                throw InputError(at, "column " + std::to_string(c + 1), quoted(fields[c]),
                                 "a finite number with a decimal point");
            }
            table.columns[c].push_back(*value);
        }
        const double nm = table.columns[0].back();
        if (nm <= 0.0) {
            throw InputError(at, "wavelength", quoted(fields[0]), "above 0 nm");
        }
        if (table.rows() > 0 && nm <= table.columns[0][table.rows() - 1]) {
            throw InputError(
                at, "wavelength", quoted(fields[0]),
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
    const std::string where = path.string();
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
        throw InputError(where, "file", "missing", "an existing CSV file");
    }
    if (!std::filesystem::is_regular_file(status)) {
        throw InputError(where, "file", "a folder or a device", "a CSV file");
    }
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(where, "file", "unreadable", "a file that you may read");
    // Read up to one byte more than allowed instead of trusting the size stated beforehand.
    std::string text(table_file_max_bytes + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (in.bad()) throw InputError(where, "file", "unreadable", "a file that you may read");
    if (text.size() > table_file_max_bytes) {
        throw InputError(where, "size", "more than 16 MiB", "at most 16 MiB");
    }
    return text;
}

}  // namespace togishi
