#include "image/picture_file.hpp"

#include <string>
#include <string_view>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "base/atomic_file.hpp"

namespace togishi {

void write_png(const std::filesystem::path& path, int width, int height,
               const std::vector<std::uint8_t>& rgb) {
    AtomicFile file(path);
    const auto out = OIIO::ImageOutput::create("png");
    // To memory first: the writer does not notice a full disk.
    OIIO::Filesystem::IOVecOutput bytes;
    if (!out) file.fail_writing(OIIO::geterror());
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    if (!out->set_ioproxy(&bytes) || !out->open(file.path().string(), spec) ||
        !out->write_image(OIIO::TypeDesc::UINT8, rgb.data()) || !out->close())
        file.fail_writing(out->geterror());
    const auto& buffer = bytes.buffer();
    file.write(std::string_view(reinterpret_cast<const char*>(buffer.data()), buffer.size()));
    file.commit();
}

}  // namespace togishi
