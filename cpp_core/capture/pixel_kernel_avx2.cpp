#include "capture/pixel_kernel.inl"

namespace togishi {
extern const PixelKernel pixel_kernel_avx2;
const PixelKernel pixel_kernel_avx2{"avx2", fit_block, block_slopes};
}  // namespace togishi
