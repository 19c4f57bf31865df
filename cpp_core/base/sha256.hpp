// The fingerprint of an input file, so that a result can be traced to it.
#pragma once
#include <string>
#include <string_view>

namespace togishi {

/// SHA-256 (FIPS 180-4) of bytes, in lower-case hexadecimal.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

}  // namespace togishi
