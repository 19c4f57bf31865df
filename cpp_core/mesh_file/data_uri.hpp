// Bytes that stand in a text: data:TYPE;base64,BYTES.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

namespace togishi {

[[nodiscard]] bool is_data_uri(std::string_view uri);

/// Nothing where it is no base64.
[[nodiscard]] std::optional<std::vector<unsigned char>> data_uri_bytes(std::string_view uri);

}  // namespace togishi
