// What a texel of a mip level is made of: sizes halve, rounded down, at least 1; an odd size is
// divided by area.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

namespace togishi {

/// Up to three source rows or columns that make one of the level above, with their shares of area.
struct MipTaps {
    std::size_t first = 0, count = 0;
    std::array<float, 3> weight{};
};

/// Of row or column i of the level above one of this size.
[[nodiscard]] inline MipTaps mip_taps(std::size_t i, std::size_t size) {
    if (size == 1) return {0, 1, {1.0F}};
    const std::size_t half = size / 2;
    if (size % 2 == 0) return {2 * i, 2, {0.5F, 0.5F}};
    const auto whole = static_cast<float>(size);
    return {2 * i,
            3,
            {static_cast<float>(half - i) / whole, static_cast<float>(half) / whole,
             static_cast<float>(i + 1) / whole}};
}

[[nodiscard]] inline std::size_t coarser_size(std::size_t size) {
    return std::max<std::size_t>(1, size / 2);
}

}  // namespace togishi
