// Pictures as floats, for measurements: any format that OpenImageIO reads, 16-bit TIFF and OpenEXR
// written.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace togishi {

/// The top row first, channels interleaved. Integer formats: 0 to 1.
struct FloatImage {
    int width = 0, height = 0, channels = 0;
    std::vector<float> values;
    std::vector<std::string> names;            ///< of the channels
    bool whole_numbers = false;                ///< read from an integer format: 1 is full scale
    std::map<std::string, std::string> notes;  ///< text attributes to write

    [[nodiscard]] std::size_t pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
};

/// Throws InputError naming the file: missing, no picture, cut off, over 2^28 values.
[[nodiscard]] FloatImage read_float_image(const std::filesystem::path& path);

/// 16-bit TIFF (.tif, .tiff) or OpenEXR in 32-bit floats (.exr); whole or not at all. TIFF values
/// are clamped to 0 to 1. Throws InputError: another extension, a folder that cannot be written.
void write_float_image(const std::filesystem::path& path, const FloatImage& image);

}  // namespace togishi
