#include "capture/pixel_kernel.hpp"

#include <cstdlib>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace togishi {

extern const PixelKernel pixel_kernel_baseline;
#ifdef TOGISHI_X86_KERNELS
extern const PixelKernel pixel_kernel_avx2;
#endif

const PixelKernel& pixel_kernel(const char* name) {
    const std::string_view asked(name);
#ifdef TOGISHI_X86_KERNELS
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (avx2 && (asked.empty() || asked == "avx2")) return pixel_kernel_avx2;
#endif
    if (asked.empty() || asked == "baseline") return pixel_kernel_baseline;
    throw InputError("TOGISHI_SIMD", "instruction set", std::string(asked),
                     "baseline, or avx2 where the processor knows it");
}

const PixelKernel& pixel_kernel() {
    const char* const asked = std::getenv("TOGISHI_SIMD");
    return pixel_kernel(asked == nullptr ? "" : asked);
}

}  // namespace togishi
