#include "cli/capture_camera.hpp"

#include "base/error.hpp"
#include "image/float_image.hpp"

namespace togishi::cli {

void refine_camera_on_picture(CaptureSetup& setup) {
    if (setup.silhouette.file.empty()) return;
    const std::filesystem::path path = setup.path_of(setup.silhouette.file);
    const FloatImage image = read_float_image(path);
    if (!setup.camera || image.width != setup.camera->width_px ||
        image.height != setup.camera->height_px) {
        throw InputError(path.string(), "size",
                         std::to_string(image.width) + " x " + std::to_string(image.height),
                         "that of the camera");
    }
    // Any mean of the channels shows an outline.
    const auto channels = static_cast<std::size_t>(image.channels);
    std::vector<float> picture(image.pixels(), 0.0F);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        picture[i / channels] += image.values[i] / static_cast<float>(channels);
    refine_camera(setup, picture);
}

}  // namespace togishi::cli
