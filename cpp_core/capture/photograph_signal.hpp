// What a photograph's stored numbers mean: the signal that a fit works on.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace togishi {

enum class Transfer : std::uint8_t {
    linear,
    srgb  ///< of IEC 61966-2-1, as cameras write 8-bit JPEG; made linear
};

struct SignalOptions {
    Transfer transfer = Transfer::linear;
    double black = 0;  ///< of full scale, taken off
    double clip = 0;   ///< of full scale, where samples count as clipped; 0: 1 - 1/2 step
};

/// Throws InputError for a black level outside 0 to 0.5, a clip below 0.
void check_signal(const SignalOptions& options);

/// Rows as a file has them, full scale 1.
struct StoredRows {
    const float* values = nullptr;
    std::size_t pixels = 0;
    std::size_t stride = 1;             ///< numbers a pixel
    std::vector<std::size_t> channels;  ///< of a pixel: one, or red, green and blue
    double step = 0;                    ///< of quantisation; 0: float
};

/// Linear luminance 0.2126 R + 0.7152 G + 0.0722 B (or the one channel) into values, and 1 into
/// clipped where a channel is at full scale.
void to_signal(const StoredRows& rows, const SignalOptions& options, float* values,
               std::uint8_t* clipped);

}  // namespace togishi
