// Property maps as tiled OpenEXR files with all mip levels.
//
// | in the file      | what |
// |------------------|------|
// | channels         | the names of MapChannel (brdf/property_maps.hpp), half or float |
// | rows             | top row first, as images have it: v = 1 at the top |
// | levels           | sizes halve, rounded down, to 1 x 1; made by bake/map_mips.hpp |
// | togishi:format   | int, 1 |
// | togishi:chart_mm | two floats: the size that u and v in [0, 1] span |
// | togishi:constant | channels that are constant over the blade, comma-separated |
// | togishi:source   | text: what the maps were made from |
// | Software         | text: program and version that wrote the file |
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bake/map_repair.hpp"
#include "brdf/property_maps.hpp"

namespace togishi {

inline constexpr int map_file_format = 1;
inline constexpr std::size_t max_map_size = 32768;                   ///< texels either way
inline constexpr std::size_t max_map_texels = std::size_t{1} << 26;  ///< 64 M: 16384 x 4096

/// How lobes and shares are stored. Half holds ln mu to 1e-3 (0.1 % of mu); the part is exact in
/// both.
enum class MapPrecision { half, single };

struct MapFileInfo {
    std::array<float, 2> chart_mm{0, 0};  ///< 0, 0: unknown
    std::string source;
    std::string software;
};

/// A map as read: level 0 first, to 1 x 1.
struct MapFile {
    std::vector<PropertyMaps> levels;
    MapFileInfo info;
    MapRepair repair;  ///< what level 0 held and must not; the levels are then made anew
};

/// Throws InputError for a size beyond the limits; `where` names the file.
void check_map_size(const std::filesystem::path& where, std::int64_t width, std::int64_t height);

/// Writes level 0 and its mip levels, whole or not at all: under a temporary name, then renamed. A
/// map that holds NaN or values out of range is refused, not mended. Throws InputError naming the
/// file: a map without the channels that coarser_levels needs, a size beyond the limits, a folder
/// that cannot be written, a full disk.
void write_map_file(const std::filesystem::path& path, const PropertyMaps& maps,
                    const MapFileInfo& info, MapPrecision precision = MapPrecision::half);

/// Reads and checks a file: sizes, channels, levels; NaN and values out of range are mended and
/// counted (MapFile::repair). Channels that Togishi does not know are an error, so that no map is
/// half understood. Throws InputError naming file, field, what was found and what is allowed.
[[nodiscard]] MapFile read_map_file(const std::filesystem::path& path);

}  // namespace togishi
