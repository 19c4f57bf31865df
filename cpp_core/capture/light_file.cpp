#include "capture/light_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "base/text.hpp"

namespace togishi {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_bytes = std::size_t{4} << 20U;

// A number with decimal point or decimal comma, not both.
std::optional<double> number(std::string_view field) {
    std::string text(field);
    const auto comma = text.find(',');
    if (comma != std::string::npos) {
        if (text.find('.') != std::string::npos || text.find(',', comma + 1) != std::string::npos)
            return std::nullopt;
        text[comma] = '.';
    }
    const auto value = parse_number(text);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string place(const fs::path& path, std::size_t line) {
    return path.string() + ", line " + std::to_string(line);
}

// Takes the last field off the end of a line.
std::string_view take_last(std::string_view& line) {
    line = trim(line);
    const auto blank = line.find_last_of(" \t");
    const auto field = blank == std::string_view::npos ? line : line.substr(blank + 1);
    line = blank == std::string_view::npos ? std::string_view{} : trim(line.substr(0, blank));
    return field;
}

bool is_file(const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error);
}

fs::path image_path(const fs::path& folder, const std::string& name) {
    // An absolute name replaces the folder.
    fs::path found = folder / fs::path(name);
    if (is_file(found) || name.find('\\') == std::string::npos) return found;
    std::string slashes = name;
    std::replace(slashes.begin(), slashes.end(), '\\', '/');
    const fs::path other = folder / fs::path(slashes);
    return is_file(other) ? other : found;
}

std::size_t read_count(const fs::path& path, std::string_view line, std::size_t number_of_line) {
    std::size_t count = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), count);
    if (error != std::errc() || end != line.data() + line.size() || count < 1 ||
        count > light_file_max_lights) {
        throw InputError(place(path, number_of_line), "count", shown(line),
                         "the number of pictures, 1 to " + std::to_string(light_file_max_lights) +
                             ", alone in the first line");
    }
    return count;
}

LightEntry read_entry(const fs::path& path, std::string_view line, std::size_t number_of_line,
                      const LightFileOptions& options) {
    const std::string where = place(path, number_of_line);
    static constexpr std::array<std::string_view, 4> names{"x", "y", "z", "intensity"};
    std::array<double, 4> values{0, 0, 0, 1};
    std::string_view rest = line;
    const std::size_t fields = options.intensity_column ? 4 : 3;
    for (std::size_t i = fields; i-- > 0;) {
        const auto field = take_last(rest);
        const auto value = number(field);
        if (!value) {
            throw InputError(where, names[i], shown(field),
                             "a finite number; the line is: file name, x y z" +
                                 std::string(options.intensity_column ? ", intensity" : ""));
        }
        values[i] = *value;
    }
    if (rest.empty())
        throw InputError(where, "file name", "missing", "a picture's name before x y z");
    if (rest.size() > 2 && rest.front() == '"' && rest.back() == '"')
        rest = rest.substr(1, rest.size() - 2);
    LightEntry entry;
    entry.line = number_of_line;
    entry.image = image_path(path.parent_path(), std::string(rest));
    const glm::dvec3 v(values[0], values[1], values[2]);
    const double length = glm::length(v);
    if (!(length > 1e-9 && length < 1e9)) {
        throw InputError(where, "x y z", "a vector of length " + std::to_string(length),
                         options.positions_mm ? "a place away from the origin, in mm"
                                              : "a direction from the object to the light");
    }
    if (!(v.z > 0)) {
        throw InputError(where, "z", std::to_string(v.z),
                         "more than 0: a light above the object's horizon");
    }
    entry.direction = v / length;
    if (options.positions_mm) entry.position_mm = v;
    entry.intensity = values[3];
    if (!(entry.intensity > 0))
        throw InputError(where, "intensity", std::to_string(entry.intensity), "more than 0");
    if (options.need_images && !is_file(entry.image)) {
        throw InputError(where, "picture", "missing: " + entry.image.string(),
                         "an existing file, relative to the .lp file or absolute");
    }
    return entry;
}

}  // namespace

LightFile read_light_file(const fs::path& path, const LightFileOptions& options) {
    const std::string content = read_text_file(path, max_bytes, "an .lp file");
    std::string_view text = checked_text(content, path.string());
    LightFile file;
    file.path = path;
    file.near = options.positions_mm;
    std::optional<std::size_t> count;
    std::set<fs::path> seen;
    std::size_t line_number = 0;
    while (!text.empty()) {
        const auto line = trim(take_line(text));
        ++line_number;
        if (line.empty()) continue;
        if (!count) {
            count = read_count(path, line, line_number);
            continue;
        }
        if (file.lights.size() == *count) {
            throw InputError(place(path, line_number), "count",
                             std::to_string(*count) + " in the first line, but more lines follow",
                             "as many lines as the first line says");
        }
        file.lights.push_back(read_entry(path, line, line_number, options));
        if (!seen.insert(file.lights.back().image).second) {
            throw InputError(place(path, line_number), "picture",
                             "named twice: " + file.lights.back().image.string(),
                             "each picture once");
        }
    }
    if (!count)
        throw InputError(path.string(), "count", "missing (the file is empty)",
                         "the number of pictures in the first line");
    if (file.lights.size() != *count) {
        throw InputError(path.string(), "count",
                         std::to_string(*count) + " in the first line, but " +
                             std::to_string(file.lights.size()) + " lines follow",
                         "as many lines as the first line says");
    }
    return file;
}

LightFile read_light_bracket(const std::filesystem::path& path, const LightFile& lights,
                             const LightFileOptions& options) {
    LightFile other = read_light_file(path, options);
    if (other.lights.size() != lights.lights.size()) {
        throw InputError(
            other.path.string(), "lights", std::to_string(other.lights.size()),
            std::to_string(lights.lights.size()) + ", as " + lights.path.string() + " has");
    }
    for (std::size_t i = 0; i < other.lights.size(); ++i) {
        constexpr double least_cosine = 0.999999;  // 0.08 degrees
        if (glm::dot(other.lights[i].direction, lights.lights[i].direction) < least_cosine) {
            throw InputError(
                other.path.string() + ", line " + std::to_string(other.lights[i].line), "x y z",
                "another direction than in line " + std::to_string(lights.lights[i].line) + " of " +
                    lights.path.string(),
                "the same lights in the same order");
        }
    }
    return other;
}

}  // namespace togishi
