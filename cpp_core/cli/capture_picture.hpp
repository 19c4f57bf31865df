// A photograph's file as the capture takes it.
#pragma once
#include <filesystem>

#include "capture/diffuse_run.hpp"

namespace togishi::cli {

/// Throws InputError as read_float_image.
[[nodiscard]] CapturePicture read_capture_picture(const std::filesystem::path& path);

}  // namespace togishi::cli
