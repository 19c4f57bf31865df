// Pictures for people, as PNG.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

namespace togishi {

/// 8-bit sRGB (height, width, 3), the top row first; whole or not at all. Throws InputError naming
/// the file: a folder that cannot be written, a full disk.
void write_png(const std::filesystem::path& path, int width, int height,
               const std::vector<std::uint8_t>& rgb);

}  // namespace togishi
