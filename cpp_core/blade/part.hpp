// The parts of a blade. One numbering for meshes, maps, shaders and Python:
// shaders/shared/parts.glsl.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "shared/parts.glsl"

namespace togishi {

enum class Part : std::uint8_t {
    other = TG_PART_OTHER,
    ji = TG_PART_JI,
    shinogi_ji = TG_PART_SHINOGI_JI,
    ha = TG_PART_HA,
    mune = TG_PART_MUNE,
    kissaki = TG_PART_KISSAKI,
    boshi = TG_PART_BOSHI,
    nakago = TG_PART_NAKAGO,
};

inline constexpr std::array<std::string_view, TG_PART_COUNT> part_names{
    "other", "ji", "shinogi_ji", "ha", "mune", "kissaki", "boshi", "nakago"};

}  // namespace togishi
