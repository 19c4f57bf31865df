// Photographs for the capture, through OpenImageIO: any format that it reads, a band of rows at a
// time.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/photograph_signal.hpp"
#include "capture/tile_reader.hpp"

namespace togishi {

struct PhotographOptions : SignalOptions {
    /// Channel by name or "luminance": 0.2126 R + 0.7152 G + 0.0722 B, or the only channel.
    std::string channel = "luminance";
};

/// Opens every picture and holds it open. Throws InputError naming the file: missing, not a
/// picture, of another size than the first, without the channel.
[[nodiscard]] std::unique_ptr<TileReader> open_photographs(
    const std::vector<std::filesystem::path>& files, const PhotographOptions& options = {});

}  // namespace togishi
