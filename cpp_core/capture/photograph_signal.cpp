#include "capture/photograph_signal.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"

namespace togishi {
namespace {

float from_srgb(float v) {
    return v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F);
}

}  // namespace

void check_signal(const SignalOptions& options) {
    if (!(options.black >= 0 && options.black < 0.5))
        throw InputError("photographs", "black", std::to_string(options.black), "0 to 0.5");
    if (!(options.clip >= 0 && options.clip <= 1e6))
        throw InputError("photographs", "clip", std::to_string(options.clip), "0 or more");
}

void to_signal(const StoredRows& rows, const SignalOptions& options, float* values,
               std::uint8_t* clipped) {
    const auto clip =
        static_cast<float>(options.clip > 0 ? options.clip : 1 - 0.5 * rows.step - 1e-7);
    const auto black = static_cast<float>(options.black), scale = 1 / (1 - black);
    const bool srgb = options.transfer == Transfer::srgb;
    const std::size_t used = rows.channels.size();
    constexpr std::array<float, 3> weights{0.2126F, 0.7152F, 0.0722F};
    for (std::size_t i = 0; i < rows.pixels; ++i) {
        float sum = 0;
        bool over = false;
        for (std::size_t c = 0; c < used; ++c) {
            const float stored = rows.values[i * rows.stride + rows.channels[c]];
            over |= stored >= clip;
            const float linear = srgb ? from_srgb(stored) : stored;
            sum += (linear - black) * scale * (used == 1 ? 1.0F : weights[c]);
        }
        values[i] = sum;
        clipped[i] = over ? 1 : 0;
    }
}

}  // namespace togishi
