// What a capture finished, as one tiled OpenEXR file.
//
// | in the file | what |
// |-------------|------|
// | channels    | capture_channels (capture/tile_run.hpp), half or float; top row first |
// | togishi:capture | int, 1 |
// | togishi:source  | text: the .lp file and the options |
// | Software        | text: program and version |
#pragma once
#include <filesystem>
#include <string>

#include "capture/tile_store.hpp"
#include "image/map_file.hpp"

namespace togishi {

/// Band by band, whole or not at all; the store's file is removed when the map stands. Throws
/// InputError naming the file: another extension than .exr, a full disk (the tiles are kept).
/// threads: for the compression, 0: all cores.
void write_capture_map(const std::filesystem::path& path, TileStore& tiles,
                       const std::string& source, const std::string& software,
                       MapPrecision precision = MapPrecision::single, unsigned threads = 0);

}  // namespace togishi
