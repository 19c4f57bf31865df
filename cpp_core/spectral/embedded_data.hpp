// The files of data/, compiled into the library as text.
#pragma once
#include <span>
#include <string_view>

namespace togishi {

struct EmbeddedFile {
    std::string_view path;  ///< relative to data/, with forward slashes: "metals/iron_querry.csv"
    std::string_view text;  ///< UTF-8, as in the file
};

/// Every data file (CSV, TOML, licence texts), sorted by path.
[[nodiscard]] std::span<const EmbeddedFile> embedded_files();

}  // namespace togishi
