// Photographs for the capture, through OpenImageIO: any format that it reads, a band of rows at a
// time.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/tile_reader.hpp"

namespace togishi {

enum class Transfer : std::uint8_t {
    linear,
    srgb  ///< of IEC 61966-2-1, as cameras write 8-bit JPEG; made linear
};

struct PhotographOptions {
    Transfer transfer = Transfer::linear;
    /// Channel by name or "luminance": 0.2126 R + 0.7152 G + 0.0722 B, or the only channel.
    std::string channel = "luminance";
    double black = 0;  ///< of full scale, taken off
    double clip = 0;   ///< of full scale, where samples count as clipped; 0: 1 - 1/2 step
};

/// Opens every picture and holds it open. Throws InputError naming the file: missing, not a
/// picture, of another size than the first, without the channel.
[[nodiscard]] std::unique_ptr<TileReader> open_photographs(
    const std::vector<std::filesystem::path>& files, const PhotographOptions& options = {});

}  // namespace togishi
