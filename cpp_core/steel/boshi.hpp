// The boshi: the hamon within the kissaki, parallel to the fukura, turning back along the mune.
#pragma once
#include "steel/field_grid.hpp"
#include "steel/steel_outline.hpp"
#include "steel/steel_parameters.hpp"

namespace togishi {

/// The boshi of one side as a distance to its line.
class Boshi {
  public:
    Boshi(const SteelOutline& outline, const SteelParameters& p, bool omote, unsigned threads);

    /// How much the boshi's line, and not the body's, holds at s: 0 well before the yokote, 1
    /// beyond it.
    [[nodiscard]] double share(double s) const;
    /// Signed distance (mm) to the boshi's line at (s, q), negative in the hardened steel. Valid
    /// where share > 0.
    [[nodiscard]] double distance(double s, double q) const;
    /// Where the ji ends within the kissaki (the boshi's top), and where the turn-back ends on the
    /// mune; mm.
    [[nodiscard]] double top_s() const { return top_s_; }
    [[nodiscard]] double kaeri_end_s() const { return kaeri_end_s_; }

  private:
    [[nodiscard]] double height(double s) const;
    [[nodiscard]] double turn_width(double s) const;

    const SteelOutline* outline_;
    const SteelParameters* p_;
    std::uint32_t seed_;
    double start_s_;
    double height_at_start_;
    double strip_mm_;
    double rounding_mm_;
    double top_s_ = 0;
    double kaeri_end_s_ = 0;
    FieldGrid from_edge_;
};

}  // namespace togishi
