#include "capture/pixel_kernel.inl"

namespace togishi {
extern const PixelKernel pixel_kernel_baseline;
const PixelKernel pixel_kernel_baseline{"baseline", fit_block, block_slopes};
}  // namespace togishi
