#include "cli/capture_picture.hpp"

#include <utility>

#include "image/float_image.hpp"

namespace togishi::cli {

CapturePicture read_capture_picture(const std::filesystem::path& path) {
    FloatImage image = read_float_image(path);
    return {image.width, image.height, image.channels, std::move(image.values),
            image.whole_numbers};
}

}  // namespace togishi::cli
