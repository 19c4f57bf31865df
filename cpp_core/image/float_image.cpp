#include "image/float_image.hpp"

#include <cstdint>
#include <string_view>
#include <system_error>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace togishi {
namespace {

constexpr std::int64_t most_values = std::int64_t{1} << 28;

std::string first_line(std::string text) {
    const auto end = text.find('\n');
    if (end != std::string::npos) text.resize(end);
    return text.empty() ? "no reason given" : text;
}

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
    throw InputError(path.string(), "picture", "unreadable (" + first_line(reason) + ")",
                     "a whole TIFF, PNG or OpenEXR picture");
}

}  // namespace

FloatImage read_float_image(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        throw InputError(path.string(), "file", error ? error.message() : "no regular file",
                         "a picture");
    }
    const auto in = OIIO::ImageInput::open(path.string());
    if (!in) fail(path, OIIO::geterror());
    const OIIO::ImageSpec& spec = in->spec();
    FloatImage image;
    image.width = spec.width;
    image.height = spec.height;
    image.channels = spec.nchannels;
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 ||
        std::int64_t{spec.width} * spec.height * spec.nchannels > most_values) {
        throw InputError(path.string(), "size",
                         std::to_string(spec.width) + " x " + std::to_string(spec.height) + " x " +
                             std::to_string(spec.nchannels),
                         "up to 2^28 values");
    }
    image.names.assign(spec.channelnames.begin(), spec.channelnames.end());
    image.whole_numbers = !spec.format.is_floating_point();
    image.values.resize(image.pixels() * static_cast<std::size_t>(image.channels));
    if (!in->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::FLOAT, image.values.data()))
        fail(path, in->geterror());
    return image;
}

void write_float_image(const std::filesystem::path& path, const FloatImage& image) {
    const std::string extension = path.extension().string();
    const bool exr = extension == ".exr";
    if (!exr && extension != ".tif" && extension != ".tiff")
        throw InputError(path.string(), "extension", extension, ".exr, .tif or .tiff");
    AtomicFile file(path);
    const auto out = OIIO::ImageOutput::create(exr ? "openexr" : "tiff");
    // To memory first: the writers do not notice a full disk.
    OIIO::Filesystem::IOVecOutput bytes;
    if (!out) file.fail_writing(OIIO::geterror());
    OIIO::ImageSpec spec(image.width, image.height, image.channels,
                         exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT16);
    if (!image.names.empty()) spec.channelnames.assign(image.names.begin(), image.names.end());
    spec.alpha_channel = -1;
    spec.z_channel = -1;
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    for (const auto& [key, value] : image.notes) spec.attribute(key, value);
    if (!out->set_ioproxy(&bytes) || !out->open(file.path().string(), spec) ||
        !out->write_image(OIIO::TypeDesc::FLOAT, image.values.data()) || !out->close())
        file.fail_writing(out->geterror());
    const auto& buffer = bytes.buffer();
    file.write(std::string_view(reinterpret_cast<const char*>(buffer.data()), buffer.size()));
    file.commit();
}

}  // namespace togishi
