// A few floats side by side, as wide as the instruction set that the including file is compiled
// for. Everything here has internal linkage and calls nothing of the standard library: a function
// that one file compiles for AVX2 must never be the one that the linker hands to another file.
#pragma once
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {
namespace lanes {

#if defined(__AVX2__)
inline constexpr int width = 8;
#else
inline constexpr int width = 4;
#endif

// Vector extensions of GCC and Clang: arithmetic, comparison and ?: work lane by lane.
using V = float __attribute__((vector_size(4 * width)));
using I = std::int32_t __attribute__((vector_size(4 * width)));
using U = std::uint32_t __attribute__((vector_size(4 * width)));

inline V all(float x) {
    return V{} + x;
}
inline V load(const float* from) {
    V v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
inline void store(float* to, V v) {
    __builtin_memcpy(to, &v, sizeof v);
}
inline V min(V a, V b) {
    return a < b ? a : b;
}
inline V max(V a, V b) {
    return a > b ? a : b;
}
inline V abs(V a) {
    return (V)((U)a & 0x7fffffffU);
}
inline bool any(I mask) {
#if defined(__AVX2__)
    return _mm256_movemask_ps((__m256)mask) != 0;
#elif defined(__SSE2__)
    return _mm_movemask_ps((__m128)mask) != 0;
#else
    std::int32_t found = 0;
    for (int i = 0; i < width; ++i) found |= mask[i];
    return found != 0;
#endif
}
inline V sqrt(V a) {
#if defined(__AVX2__)
    return (V)_mm256_sqrt_ps((__m256)a);
#elif defined(__SSE2__)
    return (V)_mm_sqrt_ps((__m128)a);
#else
    for (int i = 0; i < width; ++i) a[i] = __builtin_sqrtf(a[i]);
    return a;
#endif
}

/// e^x, x clamped to |x| <= 80: Taylor's series to the 6th power over |r| <= ln2/2, times a power
/// of two set by bits. Error 2e-7 of the value.
inline V exp(V x) {
    x = min(max(x, all(-80.0F)), all(80.0F));
    const V shifted = x * 1.44269504F + 12582912.0F;  // the sum's last bits are round(x/ln2)
    const V n = shifted - 12582912.0F;
    const V r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
    const V series =
        1.0F +
        r * (1.0F + r * (0.5F + r * (0.16666667F + r * (0.041666668F +
                                                        r * (0.0083333338F + r * 0.0013888889F)))));
    return (V)((U)series + (((U)shifted - 0x4b400000U) << 23U));
}

/// ln x for normal x > 0; error 2e-7.
inline V log(V x) {
    const U bits = (U)x;
    const I e = (I)(bits - 0x3f3504f3U) >> 23;
    const V m = (V)(bits - ((U)e << 23U));
    const V s = (m - 1.0F) / (m + 1.0F), s2 = s * s;
    const V series =
        0.66666667F + s2 * (0.4F + s2 * (0.28571429F + s2 * (0.22222222F + s2 * 0.18181818F)));
    const V power = __builtin_convertvector(e, V);
    return (s + s) + (s * s2 * series + (power * 0.693359375F - power * 2.12194440e-4F));
}

}  // namespace lanes
}  // namespace
