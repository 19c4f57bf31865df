#include "blade/katana_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace togishi {
namespace {

constexpr double sample_step_mm = 0.2;

// The stretch that an arc length of the mune line falls in, and its q there.
std::pair<Stretch, double> find(const KatanaShape& shape, double arc) {
    const MuneLine& line = shape.mune_line();
    if (arc >= shape.range(Stretch::kissaki)[0])
        return {Stretch::kissaki, std::min(arc, line.blade_arc_mm())};
    if (arc >= 0) return {Stretch::blade, arc};
    if (arc > shape.range(Stretch::machi)[0]) return {Stretch::machi, arc};
    const double jiri_start = shape.range(Stretch::nakago)[0];
    if (arc >= jiri_start) return {Stretch::nakago, arc};
    const double share = (arc + line.nakago_arc_mm()) / (jiri_start + line.nakago_arc_mm());
    return {Stretch::jiri, std::acos(std::clamp(1 - share, 0.0, 1.0))};
}

}  // namespace

ChartRow KatanaChart::row(const KatanaShape& shape, Stretch stretch, double q) {
    const Section section = shape.section(stretch, Dual(q));
    ChartRow row;
    double t = 0;
    for (const Strip strip : strips) {
        if (shape.has(strip, stretch))
            t += KatanaShape::developed_mm(section, strip, shape.parameters().mune, 1);
        row.strip_end_mm[static_cast<std::size_t>(strip)] = t;
    }
    row.mune_mm = row.strip_end_mm[static_cast<std::size_t>(Strip::mune_side)];
    row.shinogi_mm = row.strip_end_mm[static_cast<std::size_t>(Strip::shinogi_ji)];
    row.suguha_mm = row.strip_end_mm[static_cast<std::size_t>(Strip::ji)];
    row.edge_mm = t;
    return row;
}

KatanaChart::KatanaChart(const KatanaShape& shape) {
    const MuneLine& line = shape.mune_line();
    sample_arc_mm_ = {-line.nakago_arc_mm(), 0, line.blade_arc_mm()};
    sample_s_mm_ = sample_arc_mm_;
    frame_.nakago_mm = -sample_s_mm_.front();
    frame_.nagasa_mm = sample_s_mm_.back();
    frame_.yokote_s_mm =
        shape.has_yokote() ? s_mm(shape.range(Stretch::kissaki)[0]) : frame_.nagasa_mm;

    const auto samples = static_cast<std::size_t>(frame_.length_mm() / sample_step_mm) + 2;
    double highest = 0;
    for (std::size_t i = 0; i < samples; ++i) {
        const double s = -frame_.nakago_mm + frame_.length_mm() * static_cast<double>(i) /
                                                 static_cast<double>(samples - 1);
        const auto [stretch, q] = find(shape, arc_mm(s));
        const ChartRow r = row(shape, stretch, q);
        frame_.edge_mm.push_back(r.edge_mm);
        frame_.shinogi_mm.push_back(r.shinogi_mm);
        frame_.mune_mm.push_back(r.mune_mm);
        frame_.suguha_mm.push_back(r.suguha_mm);
        frame_.skew.push_back(0);
        frame_.skew_pivot_mm.push_back(0);
        highest = std::max(highest, r.edge_mm);
    }
    // Some room beyond the edge lines, so that a map can be padded there.
    frame_.chart_height_mm = 2 * highest * 1.03;
}

double KatanaChart::s_mm(double arc) const {
    const auto next = std::clamp<std::ptrdiff_t>(
        std::upper_bound(sample_arc_mm_.begin(), sample_arc_mm_.end(), arc) -
            sample_arc_mm_.begin(),
        1, static_cast<std::ptrdiff_t>(sample_arc_mm_.size()) - 1);
    const auto i = static_cast<std::size_t>(next) - 1;
    return sample_s_mm_[i] + (arc - sample_arc_mm_[i]) * (sample_s_mm_[i + 1] - sample_s_mm_[i]) /
                                 (sample_arc_mm_[i + 1] - sample_arc_mm_[i]);
}

double KatanaChart::arc_mm(double s) const {
    const auto next = std::clamp<std::ptrdiff_t>(
        std::upper_bound(sample_s_mm_.begin(), sample_s_mm_.end(), s) - sample_s_mm_.begin(), 1,
        static_cast<std::ptrdiff_t>(sample_s_mm_.size()) - 1);
    const auto i = static_cast<std::size_t>(next) - 1;
    return sample_arc_mm_[i] + (s - sample_s_mm_[i]) * (sample_arc_mm_[i + 1] - sample_arc_mm_[i]) /
                                   (sample_s_mm_[i + 1] - sample_s_mm_[i]);
}

BladeFrame make_blade_frame(const KatanaParameters& parameters) {
    return KatanaChart(KatanaShape(parameters)).frame();
}

}  // namespace togishi
