// What was measured under many known lights as property maps, ready to be brought onto a blade.
#pragma once
#include <cstddef>
#include <vector>

#include "capture/light_stack.hpp"
#include "capture/project.hpp"

namespace togishi {

/// pixels: (height, width, capture_channels), the top row first. Each pixel has one lobe: it is
/// that of both ji and ha, and w says by which model it was fitted (ji: 0, hamon: 1), so the blend
/// of the two is what was measured. Usable are pixels without a flag, and those that a prior
/// filled. The lobes count from the picture's x axis; the camera is the caller's. Throws InputError
/// where the sizes do not agree.
[[nodiscard]] ProjectedMap maps_of_stack(const std::vector<float>& pixels, std::size_t width,
                                         std::size_t height, LobeModel model);

}  // namespace togishi
