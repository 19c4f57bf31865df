// The hadori: the polisher whitens the ha along an outline of his own, which covers the hamon's
// crests, is smoother than it, fades towards the ji and ends at the yokote.
#pragma once
#include <vector>

#include "steel/quench.hpp"

namespace togishi {

class Hadori {
  public:
    Hadori(const SteelOutline& outline, const SteelParameters& p, const QuenchedSide& side,
           bool omote);
    /// Height (mm over the edge) of the hadori's outline at s; at or above every crest of the
    /// hamon.
    [[nodiscard]] double outline_q(double s) const;
    /// Mask in [0, 1] before its strength, at (s, q).
    [[nodiscard]] float mask(double s, double q) const;

  private:
    double s0_;
    double step_;
    double end_s_;
    double softness_mm_;
    bool has_yokote_;
    std::vector<double> outline_q_;
};

}  // namespace togishi
