// Numbers in columns, for people and for JSON alike.
#pragma once
#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace togishi::cli {

struct TextTable {
    std::vector<std::string> titles;
    std::vector<std::vector<double>> columns;  ///< [column][row], all of the same height
};

/// Right-aligned columns of six significant digits under their titles.
void print_table(std::ostream& out, const TextTable& table);

/// {"columns": [titles], "rows": [[numbers]]}, numbers in full precision.
[[nodiscard]] nlohmann::ordered_json json_of(const TextTable& table);

}  // namespace togishi::cli
