// Togishi's table format, which is also how a user brings a measured spectrum or metal.
//
//   # format: togishi-table 1
//   # kind: metal                      metal | light | observer | daylight_components
//   # name: iron_johnson_christy
//   # title: ...   # source: ...   # licence: ...   # note: ...
//   # columns: wavelength_nm,n,k
//   188,1.29,1.35
//
// UTF-8 with or without byte order mark, any line ends. Lines that start with # are metadata
// ("key: value") or comments. Fields are separated by commas, semicolons, tabs or spaces; one line
// of column titles may stand before the first row. Wavelengths in nm, strictly increasing.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace togishi {

/// Limits that no honest spectrum comes near.
inline constexpr std::size_t table_file_max_bytes = std::size_t{16} << 20U;
inline constexpr std::size_t table_file_max_rows = 200'000;

struct TableFile {
    std::string where;  ///< file name, for messages
    std::map<std::string, std::string, std::less<>> header;
    std::vector<std::vector<double>> columns;  ///< [column][row]; columns[0] are wavelengths in nm
    std::vector<std::size_t> lines;            ///< line number of each row, from 1
    std::string column_titles;                 ///< the line of titles where there was one

    /// Value of a header key, or an empty string.
    [[nodiscard]] std::string_view value(std::string_view key) const;
    [[nodiscard]] std::size_t rows() const { return lines.size(); }
    /// "file.csv, line 12"
    [[nodiscard]] std::string at(std::size_t row) const;
};

enum class TableMetadata { required, optional };

/// Reads a table of `column_count` columns and checks it: numbers finite, wavelengths positive and
/// strictly increasing, `kind` as stated where the file states one (or metadata is required).
/// Throws InputError naming the line.
[[nodiscard]] TableFile parse_table(std::string_view text, std::string where, std::string_view kind,
                                    std::size_t column_count, TableMetadata metadata);

/// The text of a user's file. Throws InputError where it is missing, no regular file, unreadable or
/// larger than table_file_max_bytes.
[[nodiscard]] std::string read_table_text(const std::filesystem::path& path);

}  // namespace togishi
