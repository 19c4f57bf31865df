// Random numbers that are the same on every compiler: the standard library's normal distribution is
// not.
#pragma once
#include <cmath>
#include <cstdint>

namespace togishi {

/// SplitMix64 (Steele, Lea and Flood, 2014) with the Box-Muller transform.
class RandomNormal {
  public:
    explicit RandomNormal(std::uint64_t seed) : state_(seed) {}

    /// In [0, 1).
    double uniform() {
        state_ += 0x9e3779b97f4a7c15U;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
        z ^= z >> 31U;
        return static_cast<double>(z >> 11U) * 0x1.0p-53;
    }
    /// Mean 0, standard deviation 1.
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
        return radius * std::cos(6.283185307179586477 * uniform());
    }

  private:
    std::uint64_t state_;
};

}  // namespace togishi
