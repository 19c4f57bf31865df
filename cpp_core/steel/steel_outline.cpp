#include "steel/steel_outline.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace togishi {
namespace {

void check_samples(const char* name, const std::vector<double>& samples, std::size_t expected) {
    if (samples.size() != expected || expected < 2) {
        throw InputError("blade frame", name, std::to_string(samples.size()) + " samples",
                         "as many as the other outlines, at least 2");
    }
    for (const double x : samples) {
        if (!(x >= 0.0 && x < 1e4)) {
            throw InputError("blade frame", name, std::to_string(x), "0 to 10000 mm");
        }
    }
}

}  // namespace

SteelOutline::SteelOutline(const BladeFrame& frame) : frame_(&frame) {
    const auto check_length = [](const char* name, double x, double low) {
        if (!(x >= low && x < 1e5)) {
            throw InputError("blade frame", name, std::to_string(x), "a length in mm below 100000");
        }
    };
    check_length("nagasa_mm", frame.nagasa_mm, 1.0);
    check_length("nakago_mm", frame.nakago_mm, 0.0);
    check_length("chart_height_mm", frame.chart_height_mm, 1.0);
    check_samples("edge_mm", frame.edge_mm, frame.edge_mm.size());
    check_samples("shinogi_mm", frame.shinogi_mm, frame.edge_mm.size());
    check_samples("mune_mm", frame.mune_mm, frame.edge_mm.size());

    const double nagasa = frame.nagasa_mm;
    has_yokote_ = frame.yokote_s_mm > 0.0 && frame.yokote_s_mm < nagasa - 1.0;
    kissaki_s_ = has_yokote_ ? frame.yokote_s_mm
                             : std::max(0.5 * nagasa, nagasa - 1.6 * edge(0.85 * nagasa));
    const double span = std::min(40.0, 0.5 * kissaki_s_);
    edge_at_kissaki_ = edge(kissaki_s_);
    edge_slope_ = (edge_at_kissaki_ - edge(kissaki_s_ - span)) / span;
}

double SteelOutline::straight_edge(double s) const {
    if (s <= kissaki_s_) return edge(std::max(s, 0.0));
    return edge_at_kissaki_ + (s - kissaki_s_) * edge_slope_;
}

double SteelOutline::relative_width(double s) const {
    const double at_machi = edge(0.02 * frame_->nagasa_mm);
    return at_machi > 0.0 ? straight_edge(s) / at_machi : 1.0;
}

}  // namespace togishi
