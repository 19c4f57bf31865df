// The reflection-property maps: what varies over the blade, one plane of floats per channel.
#pragma once
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

namespace togishi {

/// Channels of a property map, in file order. Lobes are stored as shaders/shared/lobe.glsl states:
/// ln of the geometric-mean half width in degrees, and (e1, e2) of its shape.
enum class MapChannel { ji_ln_mu_deg, ji_e1, ji_e2, ha_ln_mu_deg, ha_e1, ha_e2, w, h, part };
inline constexpr std::size_t map_channel_count = 9;
inline constexpr std::array<std::string_view, map_channel_count> map_channel_names{
    "ji.ln_mu_deg", "ji.e1", "ji.e2", "ha.ln_mu_deg", "ha.e1", "ha.e2", "w", "h", "part"};

/// Row-major, row 0 at v = 0 (the bottom, as Blender holds images), centres at (i + 0.5)/size.
/// A channel that is constant over the blade holds one value instead of width * height.
struct PropertyMaps {
    std::size_t width = 0;
    std::size_t height = 0;
    std::array<std::vector<float>, map_channel_count> channels;

    [[nodiscard]] const std::vector<float>& operator[](MapChannel c) const {
        return channels[static_cast<std::size_t>(c)];
    }
    [[nodiscard]] std::vector<float>& operator[](MapChannel c) {
        return channels[static_cast<std::size_t>(c)];
    }
    [[nodiscard]] bool constant(MapChannel c) const { return (*this)[c].size() == 1; }
    /// Value at texel (x, y), whether the channel is constant or not.
    [[nodiscard]] float at(MapChannel c, std::size_t x, std::size_t y) const {
        return constant(c) ? (*this)[c][0] : (*this)[c][y * width + x];
    }
};

}  // namespace togishi
