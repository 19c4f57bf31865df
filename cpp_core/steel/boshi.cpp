#include "steel/boshi.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "steel/hamon_line.hpp"
#include "steel/noise.hpp"

namespace togishi {
namespace {

constexpr double lead_in_mm = 8.0;  // before the yokote, where body and boshi are blended

/// Minimum with a rounded corner of radius about `radius`.
double smooth_minimum(double a, double b, double radius) {
    const double h = std::clamp(0.5 + 0.5 * (b - a) / radius, 0.0, 1.0);
    return std::lerp(b, a, h) - radius * h * (1.0 - h);
}

}  // namespace

Boshi::Boshi(const SteelOutline& outline, const SteelParameters& p, bool omote, unsigned threads)
    : outline_(&outline),
      p_(&p),
      seed_(static_cast<std::uint32_t>(p.seed * 0x85EBCA77U) + (omote ? 0U : 500U)),
      start_s_(outline.kissaki_s()),
      height_at_start_(calm_height(outline, p, outline.kissaki_s())) {
    const double width = outline.straight_edge(start_s_);
    strip_mm_ = std::min(2.6, 0.13 * width);
    rounding_mm_ = p.boshi == BoshiStyle::omaru ? 0.5 * width : 0.2 * width;

    // Distance to the edge line, fukura included, on a lattice of a quarter of a millimetre.
    const BladeFrame& frame = outline.frame();
    const double s0 = start_s_ - lead_in_mm - 1.0;
    constexpr double step = 0.25;
    const auto columns = static_cast<std::size_t>((outline.nagasa() + 1.0 - s0) / step) + 2;
    const auto rows = static_cast<std::size_t>((width + 3.0) / step) + 2;
    from_edge_ = FieldGrid(s0, -1.0, step, columns, rows);
    const double middle = omote ? -1.0 : 1.0;
    parallel_for(
        columns, 8,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const double s = from_edge_.s_of(i);
                for (std::size_t j = 0; j < rows; ++j) {
                    const double q = from_edge_.q_of(j);
                    const double r = std::max(outline.straight_edge(s) - q, 0.0);
                    const double u = (frame.chart_x_mm(s, r) + frame.nakago_mm) / frame.length_mm();
                    const ChartPoint at = frame.locate(
                        u, 0.5 + middle * frame.chart_y_mm(s, r) / frame.chart_height_mm);
                    // Outside the outline: below the edge by as much as the column says.
                    const double below = r - outline.edge(s);
                    from_edge_.column(i)[j] =
                        static_cast<float>(below > 0.0 ? -below : at.from_edge_mm);
                }
            }
        },
        threads);

    // The top first, with the turn-back strip at its full width; then where the strip must end.
    kaeri_end_s_ = -1e9;
    top_s_ = start_s_;
    for (double s = start_s_; s < outline.nagasa(); s += 0.1) {
        const double face = outline.edge(s);
        for (double r = outline.mune(s) + 0.05; r < face; r += 0.25) {
            if (distance(s, outline.straight_edge(s) - r) > 0.0) {
                top_s_ = s;
                break;
            }
        }
    }
    kaeri_end_s_ = top_s_ - p.boshi_kaeri_mm;
}

double Boshi::share(double s) const {
    return smooth_step(start_s_ - lead_in_mm, start_s_ + 1.0, s);
}

double Boshi::height(double s) const {
    const double into =
        std::max(0.0, (s - start_s_) / std::max(outline_->nagasa() - start_s_, 1.0));
    double h = height_at_start_ * (1.0 - 0.22 * into);
    const double life = p_->boshi == BoshiStyle::midare_komi ? 0.75 : 0.12;
    h += life * std::min(1.0, p_->hamon_amplitude) *
         noise_1d(s / (p_->boshi == BoshiStyle::midare_komi ? 4.5 : 7.0), seed_);
    return std::max(h, 0.3 * height_at_start_);
}

double Boshi::turn_width(double s) const {
    if (kaeri_end_s_ < -1e8) return strip_mm_;
    const double span = std::max(0.6 * p_->boshi_kaeri_mm, 0.8);
    const double x = (s - kaeri_end_s_) / span;
    if (x < 0.0) return std::max(4.0 * x * span, -20.0);
    const double t = 1.0 - std::min(x, 1.0);
    return strip_mm_ * (1.0 - t * t) + 0.12 * std::min(x, 1.0) * noise_1d(s / 2.2, seed_ + 9);
}

double Boshi::distance(double s, double q) const {
    const double from_line = static_cast<double>(from_edge_.sample(s, q).value) - height(s);
    if (p_->boshi == BoshiStyle::yakizume) return from_line;
    const double from_mune = outline_->straight_edge(s) - q - outline_->mune(s);
    return smooth_minimum(from_line, from_mune - turn_width(s), rounding_mm_);
}

}  // namespace togishi
