// The camera of a set-up, refined on the outline in the picture that the set-up names.
#pragma once
#include "capture/diffuse_setup.hpp"

namespace togishi::cli {

/// Nothing where the set-up names no camera.silhouette. Throws InputError as read_float_image and
/// refine_camera.
void refine_camera_on_picture(CaptureSetup& setup);

}  // namespace togishi::cli
