// The .lp file of a stack of photographs: which picture was lit from where.
//
//     3                              the number of pictures
//     IMG 0001.tif 0.11 0.24 0.965   name, then x y z
//
// | piece    | what is understood |
// |----------|--------------------|
// | text     | UTF-8 or ASCII, with or without byte order mark; LF, CRLF or CR; blank lines are
// skipped | | name     | anything before the numbers, with spaces; relative to the .lp's folder, or
// absolute; |          | where no such file exists, \ is tried as / | | numbers  | decimal point or
// decimal comma, separated by blanks or tabs | | x y z    | direction to the light, any length; or,
// asked for, its place in mm | | 4th      | asked for: the light's intensity, relative to the
// others |
//
// x runs to the right in the picture, y up, z towards the camera.
#pragma once
#include <filesystem>
#include <vector>

#include <glm/glm.hpp>

namespace togishi {

struct LightFileOptions {
    bool positions_mm = false;      ///< x y z is the light's place from the origin, in mm
    bool intensity_column = false;  ///< a number more in each line: relative intensity, > 0
    bool need_images = true;        ///< every named picture must exist
};

struct LightEntry {
    std::filesystem::path image;
    glm::dvec3 direction;  ///< unit length; of a position: from the origin to it
    glm::dvec3 position_mm{0, 0, 0};
    double intensity = 1;
    std::size_t line = 0;  ///< in the file, from 1
};

inline constexpr std::size_t light_file_max_lights = 1000;

struct LightFile {
    std::filesystem::path path;
    bool near = false;  ///< positions, not directions
    std::vector<LightEntry> lights;
};

/// Throws InputError naming file, line, field, value and what is allowed: a count that does not
/// agree, no numbers, a missing picture, a direction of length zero, a light at or below the
/// horizon (z <= 0), the same picture twice.
[[nodiscard]] LightFile read_light_file(const std::filesystem::path& path,
                                        const LightFileOptions& options = {});

/// The same lights with another exposure. Throws InputError as above, and where number, order or
/// directions of the lights are not those of `lights`.
[[nodiscard]] LightFile read_light_bracket(const std::filesystem::path& path,
                                           const LightFile& lights,
                                           const LightFileOptions& options = {});

}  // namespace togishi
