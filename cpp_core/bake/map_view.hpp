// Property maps where they lie: our own planes, or a channel of somebody's interleaved image.
#pragma once
#include <array>
#include <cstddef>

#include "brdf/property_maps.hpp"

namespace togishi {

/// One channel, rows from v = 0 upwards.
struct ChannelView {
    const float* data = nullptr;   ///< nullptr: the channel is absent
    std::size_t texel_stride = 0;  ///< floats from texel to texel; 0: constant over the blade
    [[nodiscard]] bool present() const { return data != nullptr; }
    [[nodiscard]] bool constant() const { return texel_stride == 0; }
};

/// All channels of a map; rows follow each other without gaps.
struct MapView {
    std::size_t width = 0;
    std::size_t height = 0;
    std::array<ChannelView, map_channel_count> channels;

    [[nodiscard]] const ChannelView& operator[](MapChannel c) const {
        return channels[static_cast<std::size_t>(c)];
    }
    [[nodiscard]] ChannelView& operator[](MapChannel c) {
        return channels[static_cast<std::size_t>(c)];
    }
    [[nodiscard]] bool present(MapChannel c) const { return (*this)[c].present(); }
    [[nodiscard]] float at(MapChannel c, std::size_t x, std::size_t y) const {
        const ChannelView& view = (*this)[c];
        return view.data[view.texel_stride * (y * width + x)];
    }
};

/// The planes of `maps`, which must outlive the view. A channel without values is absent.
[[nodiscard]] inline MapView view_of(const PropertyMaps& maps) {
    MapView view;
    view.width = maps.width;
    view.height = maps.height;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        const auto& plane = maps.channels[c];
        if (plane.empty()) continue;
        view.channels[c] = {plane.data(), plane.size() == 1 ? std::size_t{0} : std::size_t{1}};
    }
    return view;
}

}  // namespace togishi
