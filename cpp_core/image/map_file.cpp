#include "image/map_file.hpp"

#include <algorithm>
#include <memory>
#include <sstream>
#include <string_view>
#include <system_error>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "bake/map_mips.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace togishi {
namespace {

constexpr int tile_size = 64;
constexpr const char* format_key = "togishi:format";
constexpr const char* chart_key = "togishi:chart_mm";
constexpr const char* constant_key = "togishi:constant";
constexpr const char* source_key = "togishi:source";

std::string size_text(std::size_t width, std::size_t height) {
    return std::to_string(width) + " x " + std::to_string(height);
}

std::string all_channels() {
    std::string names;
    for (const auto name : map_channel_names)
        names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
}

// Level as OpenImageIO wants it: channels interleaved, top row first.
std::vector<float> interleave(const PropertyMaps& level, const std::vector<std::size_t>& channels) {
    std::vector<float> pixels(level.width * level.height * channels.size());
    float* out = pixels.data();
    for (std::size_t row = 0; row < level.height; ++row) {
        const std::size_t y = level.height - 1 - row;
        for (std::size_t x = 0; x < level.width; ++x) {
            for (const std::size_t c : channels)
                *out++ = level.at(static_cast<MapChannel>(c), x, y);
        }
    }
    return pixels;
}

OIIO::ImageSpec spec_of(const PropertyMaps& level, const std::vector<std::size_t>& channels,
                        MapPrecision precision) {
    OIIO::ImageSpec spec(
        static_cast<int>(level.width), static_cast<int>(level.height),
        static_cast<int>(channels.size()),
        precision == MapPrecision::half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    spec.tile_width = tile_size;
    spec.tile_height = tile_size;
    spec.channelnames.clear();
    for (const std::size_t c : channels) spec.channelnames.emplace_back(map_channel_names[c]);
    spec.alpha_channel = -1;
    spec.z_channel = -1;
    return spec;
}

[[noreturn]] void fail_reading(const std::filesystem::path& path, const std::string& reason) {
    throw InputError(path.string(), "content", "unreadable (" + reason + ")",
                     "a whole OpenEXR file");
}

// One line, without what OpenImageIO appends.
std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text.empty() ? "no reason given" : text;
}

// The whole file as bytes. Not straight to the disk: where a write fails, the OpenEXR library of
// Debian 12 waits for ever.
std::vector<unsigned char> encoded_levels(const AtomicFile& file,
                                          const std::vector<const PropertyMaps*>& levels,
                                          const MapFileInfo& info, MapPrecision precision) {
    const PropertyMaps& first = *levels.front();
    std::vector<std::size_t> channels;
    std::string constant;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        if (first.channels[c].empty()) continue;
        channels.push_back(c);
        if (first.width * first.height > 1 && first.channels[c].size() == 1) {
            constant += (constant.empty() ? "" : ",") + std::string(map_channel_names[c]);
        }
    }
    auto out = OIIO::ImageOutput::create("openexr");
    OIIO::Filesystem::IOVecOutput bytes;
    if (!out)
        throw std::runtime_error("OpenImageIO writes no OpenEXR here: " +
                                 one_line(OIIO::geterror()));
    if (!out->set_ioproxy(&bytes))
        throw std::runtime_error("OpenImageIO cannot write OpenEXR to memory");
    for (std::size_t n = 0; n < levels.size(); ++n) {
        OIIO::ImageSpec spec = spec_of(*levels[n], channels, precision);
        if (n == 0) {
            // Tells the writer that levels follow, and that their sizes round down.
            spec.attribute("textureformat", "Plain Texture");
            spec.attribute("openexr:levelmode", 1);
            spec.attribute("openexr:roundingmode", 0);
            spec.attribute("compression", "zip");
            spec.attribute("Software", info.software);
            spec.attribute(format_key, map_file_format);
            spec.attribute(chart_key, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC2),
                           info.chart_mm.data());
            if (!constant.empty()) spec.attribute(constant_key, constant);
            if (!info.source.empty()) spec.attribute(source_key, info.source);
        }
        const auto mode = n == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendMIPLevel;
        if (!out->open(file.path().string(), spec, mode))
            file.fail_writing(one_line(out->geterror()));
        const std::vector<float> pixels = interleave(*levels[n], channels);
        if (!out->write_image(OIIO::TypeDesc::FLOAT, pixels.data())) {
            file.fail_writing(one_line(out->geterror()));
        }
    }
    if (!out->close()) file.fail_writing(one_line(out->geterror()));
    out.reset();  // flushes
    return bytes.buffer();
}

// Which of our channels each channel of the file is.
std::vector<std::size_t> channels_of(const std::filesystem::path& path,
                                     const OIIO::ImageSpec& spec) {
    std::vector<std::size_t> channels;
    for (const std::string& name : spec.channelnames) {
        const auto* const at = std::find(map_channel_names.begin(), map_channel_names.end(), name);
        if (at == map_channel_names.end()) {
            throw InputError(path.string(), "channel", "\"" + name + "\"", all_channels());
        }
        const auto c = static_cast<std::size_t>(at - map_channel_names.begin());
        if (std::find(channels.begin(), channels.end(), c) != channels.end()) {
            throw InputError(path.string(), "channel", "\"" + name + "\" twice",
                             "each channel once");
        }
        channels.push_back(c);
    }
    return channels;
}

PropertyMaps read_level(const std::filesystem::path& path, OIIO::ImageInput& in, int level,
                        const std::vector<std::size_t>& channels, std::size_t width,
                        std::size_t height) {
    PropertyMaps maps;
    maps.width = width;
    maps.height = height;
    std::vector<float> pixels(width * height * channels.size());
    if (!in.read_image(0, level, 0, static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT,
                       pixels.data())) {
        fail_reading(path, "level " + std::to_string(level) + ": " + one_line(in.geterror()));
    }
    for (std::size_t i = 0; i < channels.size(); ++i) {
        auto& plane = maps.channels[channels[i]];
        plane.resize(width * height);
        for (std::size_t row = 0; row < height; ++row) {
            const float* from = pixels.data() + row * width * channels.size() + i;
            float* to = plane.data() + (height - 1 - row) * width;
            for (std::size_t x = 0; x < width; ++x) to[x] = from[x * channels.size()];
        }
    }
    return maps;
}

// Channels that the writer declared constant become one value again, if they still are.
void collapse_constants(PropertyMaps& maps, const std::string& names) {
    std::istringstream list(names);
    for (std::string name; std::getline(list, name, ',');) {
        const auto* const at = std::find(map_channel_names.begin(), map_channel_names.end(), name);
        if (at == map_channel_names.end()) continue;
        auto& plane = maps.channels[static_cast<std::size_t>(at - map_channel_names.begin())];
        if (plane.size() < 2) continue;
        const bool same =
            std::all_of(plane.begin(), plane.end(), [&](float v) { return v == plane[0]; });
        if (same) plane.resize(1);
    }
}

void check_header(const std::filesystem::path& path, const OIIO::ImageSpec& spec) {
    const int format = spec.get_int_attribute(format_key, 0);
    if (format != map_file_format) {
        throw InputError(path.string(), format_key,
                         format == 0 ? "missing" : std::to_string(format),
                         "1: property maps as `togishi bake` writes them");
    }
    if (spec.depth != 1) {
        throw InputError(path.string(), "depth", std::to_string(spec.depth), "1");
    }
    check_map_size(path, spec.width, spec.height);
    if (spec.nchannels < 1 || spec.nchannels > static_cast<int>(map_channel_count)) {
        throw InputError(path.string(), "channels", std::to_string(spec.nchannels), all_channels());
    }
}

}  // namespace

void check_map_size(const std::filesystem::path& where, std::int64_t width, std::int64_t height) {
    constexpr auto most = static_cast<std::int64_t>(max_map_size);
    constexpr auto most_texels = static_cast<std::int64_t>(max_map_texels);
    if (width > 0 && height > 0 && width <= most && height <= most && width * height <= most_texels)
        return;
    throw InputError(where.string(), "map size",
                     std::to_string(width) + " x " + std::to_string(height),
                     "1 to 32768 texels either way, 67108864 in all");
}

void write_map_file(const std::filesystem::path& path, const PropertyMaps& maps,
                    const MapFileInfo& info, MapPrecision precision) {
    check_map_size(path, static_cast<std::int64_t>(maps.width),
                   static_cast<std::int64_t>(maps.height));
    const MapView view = view_of(maps);
    const std::vector<PropertyMaps> coarse = coarser_levels(view);
    if (!is_valid(view)) {
        throw InputError(path.string(), "map", "with NaN, infinity or values out of range",
                         "finite values in the ranges of bake/map_repair.hpp");
    }
    if (path.extension() != ".exr") {
        throw InputError(path.string(), "extension", path.extension().string(), ".exr");
    }
    std::vector<const PropertyMaps*> levels{&maps};
    for (const PropertyMaps& level : coarse) levels.push_back(&level);
    AtomicFile file(path);
    const std::vector<unsigned char> bytes = encoded_levels(file, levels, info, precision);
    file.write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    file.commit();
}

MapFile read_map_file(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        throw InputError(path.string(), "file", error ? error.message() : "no regular file",
                         "an OpenEXR file");
    }
    const auto in = OIIO::ImageInput::create("openexr");
    OIIO::ImageSpec spec;
    if (!in)
        throw std::runtime_error("OpenImageIO reads no OpenEXR here: " +
                                 one_line(OIIO::geterror()));
    if (!in->open(path.string(), spec)) fail_reading(path, one_line(in->geterror()));
    check_header(path, spec);
    const std::vector<std::size_t> channels = channels_of(path, spec);
    MapFile file;
    file.info.software = spec.get_string_attribute("Software");
    file.info.source = spec.get_string_attribute(source_key);
    (void)spec.getattribute(chart_key, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC2),
                            file.info.chart_mm.data());
    const std::string constant = spec.get_string_attribute(constant_key);

    auto width = static_cast<std::size_t>(spec.width),
         height = static_cast<std::size_t>(spec.height);
    for (int level = 0;; ++level) {
        const OIIO::ImageSpec own = in->spec(0, level);
        if (own.width != static_cast<int>(width) || own.height != static_cast<int>(height)) {
            throw InputError(path.string(), "level " + std::to_string(level),
                             own.width == 0
                                 ? "missing"
                                 : std::to_string(own.width) + " x " + std::to_string(own.height),
                             size_text(width, height) + ": sizes halve, rounded down, to 1 x 1");
        }
        file.levels.push_back(read_level(path, *in, level, channels, width, height));
        collapse_constants(file.levels.back(), constant);
        if (width == 1 && height == 1) break;
        width = std::max<std::size_t>(1, width / 2);
        height = std::max<std::size_t>(1, height / 2);
    }
    PropertyMaps& map = file.levels.front();
    for (const MapChannel needed :
         {MapChannel::ji_ln_mu_deg, MapChannel::ha_ln_mu_deg, MapChannel::w}) {
        if (!map[needed].empty()) continue;
        throw InputError(
            path.string(), "channel",
            std::string(map_channel_names[static_cast<std::size_t>(needed)]) + " missing",
            "at least ji.ln_mu_deg, ha.ln_mu_deg and w");
    }
    const bool valid =
        std::all_of(file.levels.begin(), file.levels.end(),
                    [](const PropertyMaps& level) { return is_valid(view_of(level)); });
    if (!valid) {
        file.repair = repair_map(map);
        PropertyMaps first = std::move(map);
        file.levels = coarser_levels(view_of(first));
        file.levels.insert(file.levels.begin(), std::move(first));
    }
    return file;
}

}  // namespace togishi
