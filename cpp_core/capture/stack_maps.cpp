#include "capture/stack_maps.hpp"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "capture/tile_run.hpp"

namespace togishi {
namespace {

constexpr std::size_t channel_at(std::string_view name) {
    std::size_t at = 0;
    while (capture_channels[at] != name) ++at;
    return at;
}

}  // namespace

ProjectedMap maps_of_stack(const std::vector<float>& pixels, std::size_t width, std::size_t height,
                           LobeModel model) {
    constexpr std::size_t channels = capture_channels.size();
    if (width == 0 || height == 0 || pixels.size() != width * height * channels) {
        throw InputError("capture lights", "map", std::to_string(pixels.size()),
                         std::to_string(width * height * channels));
    }
    constexpr std::array<std::pair<std::size_t, std::array<MapChannel, 2>>, 3> lobe{
        {{channel_at("lobe.ln_mu_deg"), {MapChannel::ji_ln_mu_deg, MapChannel::ha_ln_mu_deg}},
         {channel_at("lobe.e1"), {MapChannel::ji_e1, MapChannel::ha_e1}},
         {channel_at("lobe.e2"), {MapChannel::ji_e2, MapChannel::ha_e2}}}};
    constexpr std::size_t flags_at = channel_at("flags");
    ProjectedMap out;
    out.frame = MapFrame::image;
    out.maps.width = width;
    out.maps.height = height;
    out.usable.assign(width * height, 0);
    for (const auto& [from, targets] : lobe)
        for (const MapChannel c : targets) out.maps[c].assign(width * height, 0.0F);
    for (std::size_t row = 0; row < height; ++row) {
        for (std::size_t x = 0; x < width; ++x) {
            const float* pixel = pixels.data() + (row * width + x) * channels;
            const bool known = pixel[flags_at] >= 0 && pixel[flags_at] < 256;
            const int flags = known ? static_cast<int>(pixel[flags_at]) : int{flag_missing};
            bool good = (flags & flag_missing) == 0 &&
                        ((flags & unusable_flags) == 0 || (flags & flag_inferred) != 0);
            for (const auto& [from, targets] : lobe) good = good && std::isfinite(pixel[from]);
            out.usable[row * width + x] = good ? 1 : 0;
            if (!good) continue;
            for (const auto& [from, targets] : lobe)
                for (const MapChannel c : targets)
                    out.maps[c][(height - 1 - row) * width + x] = pixel[from];
        }
    }
    out.maps[MapChannel::w] = {model == LobeModel::hamon ? 1.0F : 0.0F};
    out.maps[MapChannel::h] = {0.0F};
    return out;
}

}  // namespace togishi
