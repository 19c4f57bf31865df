// Seeded random numbers for drawing shapes: one stream per purpose, so that changing how many
// numbers one purpose takes leaves the others as they were.
#pragma once
#include <cmath>
#include <cstdint>

namespace togishi {

/// splitmix64 (Steele, Lea, Flood 2014); the same numbers on every machine.
class RandomStream {
  public:
    RandomStream(std::uint64_t seed, std::uint64_t purpose)
        : state_(seed * 0x9E3779B97F4A7C15ULL + purpose * 0xD1B54A32D192ED03ULL) {}

    /// In [0, 1).
    double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
    /// Mean 0, variance 1, cut at +-2.5, so that no shape is ever absurd.
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
        const double z = radius * std::cos(6.283185307179586 * uniform());
        return std::fmin(2.5, std::fmax(-2.5, z));
    }

  private:
    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
        return z ^ (z >> 31);
    }
    std::uint64_t state_;
};

/// Numbers for one side of a blade: partly those of the other side. The smith draws both sides
/// alike, not equal.
class SideStream {
  public:
    /// asymmetry: 0, both sides equal; 1, nothing in common.
    SideStream(std::uint64_t seed, std::uint64_t purpose, bool omote, double asymmetry)
        : common_(seed, purpose),
          own_(seed, purpose * 2 + (omote ? 1001 : 2002)),
          shared_(std::sqrt(1.0 - asymmetry)),
          apart_(std::sqrt(asymmetry)) {}

    /// Mean 0, variance 1, correlated between the sides by 1 - asymmetry.
    double normal() { return shared_ * common_.normal() + apart_ * own_.normal(); }
    /// In [0, 1); the same on both sides.
    double common_uniform() { return common_.uniform(); }
    /// Mean 0, variance 1; the same on both sides.
    double common_normal() { return common_.normal(); }

  private:
    RandomStream common_;
    RandomStream own_;
    double shared_;
    double apart_;
};

}  // namespace togishi
