// Points at the same place, found while they come in.
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace togishi {

/// Numbers different points in the order in which they come; 0 and -0 are one place. A table of
/// 8 bytes and less per point beside the points themselves.
class PointIndex {
  public:
    explicit PointIndex(std::size_t expected = 0) { grow(std::bit_ceil(2 * expected + 64)); }

    /// The number of `point`; points.size() - 1 where it is new: it has then been appended.
    std::uint32_t add(const glm::vec3& point, std::vector<glm::vec3>& points) {
        if (2 * (points.size() + 1) > slots_.size()) {
            grow(2 * slots_.size());
            for (std::size_t i = 0; i < points.size(); ++i)
                slots_[free_slot(points[i], points)] = static_cast<std::uint32_t>(i);
        }
        const std::size_t slot = free_slot(point, points);
        if (slots_[slot] == none) {
            slots_[slot] = static_cast<std::uint32_t>(points.size());
            points.push_back(point);
        }
        return slots_[slot];
    }

  private:
    static constexpr std::uint32_t none = 0xffffffffU;

    static std::uint64_t hash(const glm::vec3& p) {
        const auto bits = [](float v) { return std::bit_cast<std::uint32_t>(v + 0.0F); };
        std::uint64_t h = bits(p.x) * 0x9e3779b97f4a7c15ULL;
        h = (h ^ (h >> 32U) ^ bits(p.y)) * 0xbf58476d1ce4e5b9ULL;
        h = (h ^ (h >> 29U) ^ bits(p.z)) * 0x94d049bb133111ebULL;
        return h ^ (h >> 32U);
    }
    /// Where the point is, or else belongs.
    std::size_t free_slot(const glm::vec3& p, const std::vector<glm::vec3>& points) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = hash(p) & mask;
        while (slots_[slot] != none && points[slots_[slot]] != p) slot = (slot + 1) & mask;
        return slot;
    }
    void grow(std::size_t size) { slots_.assign(size, none); }

    std::vector<std::uint32_t> slots_;
};

}  // namespace togishi
