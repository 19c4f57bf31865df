#include "steel/hadori.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "steel/noise.hpp"

namespace togishi {

Hadori::Hadori(const SteelOutline& outline, const SteelParameters& p, const QuenchedSide& side,
               bool omote)
    : s0_(side.depth_mm.s_of(0)),
      step_(0.5),
      end_s_(outline.kissaki_s()),
      softness_mm_(p.hadori_softness_mm),
      has_yokote_(outline.has_yokote()) {
    const auto seed = static_cast<std::uint32_t>(p.seed * 0x165667B1U) + (omote ? 1U : 2U);
    const auto count = static_cast<std::size_t>((outline.nagasa() - s0_) / step_) + 2;
    const auto reach = static_cast<std::ptrdiff_t>(std::ceil(p.hadori_smoothing_mm / step_));
    const auto last = static_cast<std::ptrdiff_t>(count) - 1;
    std::vector<double> crest(count);
    for (std::size_t i = 0; i < count; ++i) {
        // The highest of the finer columns that this one stands for, so that no crest slips
        // through.
        const double s = s0_ + static_cast<double>(i) * step_;
        for (double t = -step_; t <= step_; t += 0.5 * side.depth_mm.step()) {
            crest[i] = std::max(crest[i], side.crest_at(std::min(s + t, end_s_)));
        }
    }
    // The highest crest within reach, then a mean over no more than that reach: never below a
    // crest.
    std::vector<double> highest(count);
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
        for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - reach);
             k <= std::min(last, i + reach); ++k) {
            highest[static_cast<std::size_t>(i)] =
                std::max(highest[static_cast<std::size_t>(i)], crest[static_cast<std::size_t>(k)]);
        }
    }
    outline_q_.resize(count);
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
        double sum = 0;
        double weights = 0;
        for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
            const double x = static_cast<double>(k) / static_cast<double>(reach + 1);
            const double w = (1.0 - x * x) * (1.0 - x * x);
            sum +=
                w * highest[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + k, 0, last))];
            weights += w;
        }
        const double s = s0_ + static_cast<double>(i) * step_;
        // The finger stone's own hand: never less than the margin asked for.
        const double own = 0.35 * std::abs(static_cast<double>(noise_1d(s / 13.0, seed)));
        outline_q_[static_cast<std::size_t>(i)] = sum / weights + p.hadori_margin_mm + own;
    }
}

double Hadori::outline_q(double s) const {
    const double last = static_cast<double>(outline_q_.size() - 1);
    const double x = std::clamp((s - s0_) / step_, 0.0, last);
    const auto i = std::min(static_cast<std::size_t>(x), outline_q_.size() - 2);
    return std::lerp(outline_q_[i], outline_q_[i + 1], x - static_cast<double>(i));
}

float Hadori::mask(double s, double q) const {
    const double over = (q - outline_q(s)) / softness_mm_;
    // Whitest over the ha; the crests keep more than half of it; a long tail towards the ji.
    const double x = std::clamp((over + 0.35) / 1.349, 0.0, 1.0);
    const double fade = (1.0 - x) * (1.0 - x) * (1.0 + 0.9 * x);
    // Masked at the yokote; on blades without one it runs out before the boshi.
    const double end = has_yokote_ ? 1.0 - smooth_step(end_s_ - 0.5, end_s_, s)
                                   : 1.0 - smooth_step(end_s_ - 12.0, end_s_ + 6.0, s);
    const double start = smooth_step(0.0, 3.0, s);
    return static_cast<float>(fade * end * start);
}

}  // namespace togishi
