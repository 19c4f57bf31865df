// The fingerprint of an input file, so that a result can be traced to it.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace togishi {

/// SHA-256 (FIPS 180-4) of bytes that come one after the other.
class Sha256 {
  public:
    void add(std::string_view bytes);
    /// Of all that was added, in lower-case hexadecimal.
    [[nodiscard]] std::string hex() const;

  private:
    std::array<std::uint32_t, 8> state_{0x6a09e667U, 0xbb67ae85U, 0x3c6ef372U, 0xa54ff53aU,
                                        0x510e527fU, 0x9b05688cU, 0x1f83d9abU, 0x5be0cd19U};
    std::string rest_;  ///< fewer than 64 bytes
    std::uint64_t bytes_ = 0;
};

/// SHA-256 (FIPS 180-4) of bytes, in lower-case hexadecimal.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

}  // namespace togishi
