#include "plot/fit_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace togishi {
namespace {

constexpr PlotColour ground{252, 251, 247};
constexpr PlotColour ink{38, 36, 32};
constexpr PlotColour soft{112, 107, 97};
constexpr PlotColour faint{229, 225, 215};
constexpr PlotColour band{240, 236, 226};
constexpr PlotColour model{20, 18, 16};
constexpr PlotColour wrong{186, 52, 30};
// Measured curves, one colour a channel; told apart by the colour-blind too.
constexpr std::array<PlotColour, 6> measured{{{74, 132, 186},
                                              {214, 138, 40},
                                              {70, 150, 110},
                                              {176, 108, 160},
                                              {150, 130, 60},
                                              {110, 120, 135}}};
constexpr std::size_t most_panels = 24;
constexpr double residual_reach = 5;  // in sigma
constexpr double pi = 3.14159265358979323846;

void check_scale(double scale) {
    if (!(scale >= 0.25 && scale <= 4))
        throw InputError("plot", "scale", std::to_string(scale), "0.25 to 4");
}

std::string digits(double value, int significant) {
    std::array<char, 40> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*g", significant, value);
    return buffer.data();
}

std::string decimals(double value, int places) {
    std::array<char, 64> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*f", places, value);
    return buffer.data();
}

// 1, 2 or 5 times a power of ten, so that about `count` of them fill the span.
double tick_step(double span, double count) {
    const double rough = std::max(span, 1e-30) / count;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    for (const double step : {1.0, 2.0, 5.0}) {
        if (rough <= step * power * 1.0001) return step * power;
    }
    return 10 * power;
}

std::string tick_label(double value, double step) {
    if (std::abs(value) < 1e-9 * step) value = 0;
    const int places = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
    return places <= 4 && std::abs(value) < 1e6 ? decimals(value, places) : digits(value, 3);
}

struct Range {
    double low = 0, high = 1;
    [[nodiscard]] double span() const { return high - low; }
};

struct Box {
    double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] PlotPoint at(Range x, Range y, double vx, double vy) const {
        return {x0 + (vx - x.low) / x.span() * (x1 - x0), y1 - (vy - y.low) / y.span() * (y1 - y0)};
    }
};

// The receive angles where the signal stands out of the stray light, and its surroundings.
Range signal_range(const Scan& scan, const FittedScan& fitted, std::size_t channels) {
    double low = INFINITY, high = -INFINITY;
    for (const double value : fitted.modelled) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    Range all{scan.rows.front().receive_deg, scan.rows.front().receive_deg};
    Range peak{INFINITY, -INFINITY};
    for (std::size_t i = 0; i < scan.rows.size(); ++i) {
        const double at = scan.rows[i].receive_deg;
        all = {std::min(all.low, at), std::max(all.high, at)};
        if (fitted.modelled[i * channels] < low + 0.01 * (high - low)) continue;
        peak = {std::min(peak.low, at), std::max(peak.high, at)};
    }
    if (!(peak.low <= peak.high)) return all;
    const double margin = std::max(0.25 * peak.span(), 0.8);
    return {std::max(all.low, peak.low - margin), std::min(all.high, peak.high + margin)};
}

struct Layout {
    std::size_t columns = 1, rows = 1;
    double panel_width = 0, panel_height = 0, header = 0;
};

class ScanPlot {
  public:
    ScanPlot(const Fit& fit, double scale)
        : fit_(fit),
          s_(scale),
          channels_(fit.scans.channels.size()),
          shown_(std::min(fit.scans.scans.size(), most_panels)),
          layout_(arrange(shown_, scale)),
          canvas_(static_cast<int>(std::lround(1600 * scale)),
                  static_cast<int>(std::lround(layout_.header + static_cast<double>(layout_.rows) *
                                                                    layout_.panel_height)),
                  ground) {
        share_scales();
    }

    Picture draw() {
        header();
        for (std::size_t i = 0; i < shown_; ++i) panel(i);
        return canvas_.picture();
    }

  private:
    static Layout arrange(std::size_t count, double scale) {
        Layout layout;
        layout.columns = count <= 1 ? 1 : count <= 4 ? 2 : count <= 12 ? 3 : 4;
        layout.rows = (count + layout.columns - 1) / layout.columns;
        layout.panel_width = 1600 * scale / static_cast<double>(layout.columns);
        layout.panel_height = (layout.columns == 1 ? 760 : layout.columns == 2 ? 470 : 400) * scale;
        layout.header = 112 * scale;
        return layout;
    }

    // One height and one width for all panels, so that they can be compared by eye.
    void share_scales() {
        double low = 0, high = 0;
        for (std::size_t i = 0; i < shown_; ++i) {
            const Scan& scan = fit_.scans.scans[i];
            const FittedScan& fitted = fit_.fitted[i];
            for (std::size_t k = 0; k < scan.intensity.size(); ++k) {
                for (const double value : {scan.intensity[k], fitted.modelled[k]}) {
                    if (!std::isfinite(value) || fitted.state[k] == ReadingState::outlier) continue;
                    low = std::min(low, value);
                    high = std::max(high, value);
                }
            }
            ranges_.push_back(scan.rows.empty() ? Range{} : signal_range(scan, fitted, channels_));
            reach_ = std::max(reach_, ranges_.back().span() / 2);
        }
        if (!(high > low)) high = low + 1;
        intensity_ = {low - 0.02 * (high - low), high + 0.06 * (high - low)};
        reach_ = std::max(reach_, 0.5);
    }

    void header() {
        const FitRecord& record = fit_.record;
        std::string title = fit_.scans.name.empty() ? "Goniometer fit" : fit_.scans.name;
        title += record.model == "ji" ? ": ji" : ": hamon";
        canvas_.text({34 * s_, 46 * s_}, title, 20 * s_, ink);
        std::string said = record.metal;
        for (const FitParameter& p : record.parameters) {
            const char* label = p.name == "mu_t_deg"   ? "μ wide"
                                : p.name == "mu_b_deg" ? "μ narrow"
                                : p.name == "rho_deg"  ? "ρ"
                                : p.name == "chi"      ? "χ"
                                : p.name == "beta"     ? "β"
                                                       : nullptr;
            if (label == nullptr) continue;
            const std::string unit = p.unit == "deg" ? "°" : p.unit == "1" ? "" : " " + p.unit;
            said += "    " + std::string(label) + " ";
            said += p.determined ? digits(p.value, 4) + " ± " + digits(p.sigma, 2) + unit
                                 : "undetermined";
        }
        said += "    reduced χ² " + decimals(record.chi2_reduced, 2);
        canvas_.text({34 * s_, 82 * s_}, said, 13 * s_, soft);

        const double y = 40 * s_;
        double x = 1566 * s_;
        const auto key = [&](const std::string& text, PlotColour colour, double width,
                             double dash) {
            canvas_.text({x, y + 6 * s_}, text, 13 * s_, soft, TextAlign::right);
            x -= Canvas::text_width(text, 13 * s_) + 10 * s_;
            canvas_.stroke({{x - 44 * s_, y}, {x, y}}, width, colour, dash);
            x -= 74 * s_;
        };
        key("model", model, 2.2 * s_, 7 * s_);
        for (std::size_t c = std::min(channels_, measured.size()); c-- > 0;) {
            key(channels_ == 1 ? "measured" : fit_.scans.channels[c].name, measured[c], 4 * s_, 0);
        }
        if (shown_ < fit_.scans.scans.size()) {
            canvas_.text({1566 * s_, 82 * s_},
                         "first " + std::to_string(shown_) + " of " +
                             std::to_string(fit_.scans.scans.size()) + " scans",
                         13 * s_, soft, TextAlign::right);
        }
    }

    void axis_x(const Box& box, Range x, const Box& labelled) {
        const double step = tick_step(x.span(), 6);
        for (double tick = std::ceil(x.low / step - 1e-9) * step; tick <= x.high + 1e-9 * step;
             tick += step) {
            const double px = box.at(x, {0, 1}, tick, 0).x;
            canvas_.stroke({{px, box.y0}, {px, box.y1}}, 1, faint);
            if (box.y1 == labelled.y1) {
                canvas_.text({px, box.y1 + 20 * s_}, tick_label(tick, step) + "°", 11 * s_, soft,
                             TextAlign::centre);
            }
        }
    }

    void axis_y(const Box& box, Range y, double step) {
        for (double tick = std::ceil(y.low / step - 1e-9) * step; tick <= y.high + 1e-9 * step;
             tick += step) {
            const double py = box.at({0, 1}, y, 0, tick).y;
            canvas_.stroke({{box.x0, py}, {box.x1, py}}, 1, faint);
            canvas_.text({box.x0 - 9 * s_, py + 4.5 * s_}, tick_label(tick, step), 11 * s_, soft,
                         TextAlign::right);
        }
    }

    void curves(std::size_t index, const Box& box, Range x) {
        const Scan& scan = fit_.scans.scans[index];
        const FittedScan& fitted = fit_.fitted[index];
        bool in_plane = true;
        for (const ScanRow& row : scan.rows) in_plane = in_plane && row.azimuth_deg == 0;
        for (std::size_t c = 0; c < channels_; ++c) {
            std::vector<std::vector<PlotPoint>> lines(1), dashed(1);
            for (std::size_t i = 0; i < scan.rows.size(); ++i) {
                const ScanRow& row = scan.rows[i];
                if (i > 0 && row.azimuth_deg != scan.rows[i - 1].azimuth_deg) {
                    lines.emplace_back();
                    dashed.emplace_back();
                }
                const double value = scan.intensity[i * channels_ + c];
                if (std::isfinite(value)) {
                    lines.back().push_back(box.at(x, intensity_, row.receive_deg, value));
                } else {
                    lines.emplace_back();
                }
                dashed.back().push_back(
                    box.at(x, intensity_, row.receive_deg, fitted.modelled[i * channels_ + c]));
            }
            for (const auto& line : lines)
                canvas_.stroke(line, 4 * s_, measured[c % measured.size()]);
            if (in_plane) {
                // Between the readings, too: five points make no lobe.
                constexpr std::size_t points = 400;
                std::vector<double> receive(points);
                for (std::size_t i = 0; i < points; ++i) {
                    receive[i] = std::clamp(
                        x.low + x.span() * static_cast<double>(i) / (points - 1.0), -89.9, 89.9);
                }
                const std::vector<double> values = modelled_curve(fit_, index, receive);
                dashed.assign(1, {});
                for (std::size_t i = 0; i < points; ++i) {
                    dashed.front().push_back(
                        box.at(x, intensity_, receive[i], values[i * channels_ + c]));
                }
            }
            for (const auto& line : dashed) canvas_.stroke(line, 2 * s_, model, 7 * s_);
        }
    }

    // Readings that the fit left out are marked in both parts of the panel.
    void points(std::size_t index, const Box& upper, const Box& lower, Range x) {
        const Scan& scan = fit_.scans.scans[index];
        const FittedScan& fitted = fit_.fitted[index];
        for (std::size_t i = 0; i < scan.rows.size(); ++i) {
            const double at = scan.rows[i].receive_deg;
            if (at < x.low || at > x.high) continue;
            for (std::size_t c = 0; c < channels_; ++c) {
                const std::size_t k = i * channels_ + c;
                const ReadingState state = fitted.state[k];
                if (state == ReadingState::gap) continue;
                const double residual =
                    std::clamp(fitted.residual_sigma[k], -residual_reach, residual_reach);
                const PlotPoint below =
                    lower.at(x, {-residual_reach, residual_reach}, at, residual);
                if (state == ReadingState::used) {
                    canvas_.disc(below, 1.6 * s_, measured[c % measured.size()]);
                    continue;
                }
                canvas_.ring(below, 3 * s_, 1.3 * s_, wrong);
                canvas_.clip(upper.x0, upper.y0, upper.x1, upper.y1);
                canvas_.ring(
                    upper.at(x, intensity_, at,
                             std::clamp(scan.intensity[k], intensity_.low, intensity_.high)),
                    4 * s_, 1.5 * s_, wrong);
                canvas_.unclip();
            }
        }
    }

    void panel(std::size_t index) {
        const double left = static_cast<double>(index % layout_.columns) * layout_.panel_width;
        const std::size_t row = index / layout_.columns;
        const double top = layout_.header + static_cast<double>(row) * layout_.panel_height;
        const double bottom = top + layout_.panel_height - 58 * s_;
        const double residual_height = 74 * s_;
        const Box upper{left + 92 * s_, top + 34 * s_, left + layout_.panel_width - 30 * s_,
                        bottom - residual_height - 14 * s_};
        const Box lower{upper.x0, bottom - residual_height, upper.x1, bottom};
        const Scan& scan = fit_.scans.scans[index];
        const FittedScan& fitted = fit_.fitted[index];

        std::string title = digits(scan.incidence_deg, 4) + "° incidence";
        title += ", turned " + digits(scan.turn_deg, 4) + "°";
        canvas_.text({upper.x0, top + 20 * s_}, title, 13 * s_, ink);
        std::string note = "rms " + decimals(fitted.residual_rms_sigma, 2) + " σ";
        const std::string more = "gain " + decimals(fitted.gain, 4) + "    " + note;
        const double left_over = upper.x1 - upper.x0 - Canvas::text_width(title, 13 * s_) - 16 * s_;
        if (Canvas::text_width(more, 11 * s_) < left_over) note = more;
        canvas_.text({upper.x1, top + 20 * s_}, note, 11 * s_, soft, TextAlign::right);

        const double middle = (ranges_[index].low + ranges_[index].high) / 2;
        const Range x{middle - reach_, middle + reach_};
        const Range residual{-residual_reach, residual_reach};
        const double y0 = lower.at({0, 1}, residual, 0, 2).y;
        canvas_.fill(lower.x0, y0, lower.x1, lower.at({0, 1}, residual, 0, -2).y, band);
        axis_x(upper, x, lower);
        axis_x(lower, x, lower);
        axis_y(upper, intensity_, tick_step(intensity_.span(), 5));
        axis_y(lower, residual, 4);
        canvas_.clip(upper.x0, upper.y0, upper.x1, upper.y1);
        if (!scan.rows.empty()) curves(index, upper, x);
        canvas_.unclip();
        points(index, upper, lower, x);
        canvas_.stroke({{upper.x0, upper.y0}, {upper.x0, upper.y1}, {upper.x1, upper.y1}}, 1.4 * s_,
                       soft);
        canvas_.stroke({{lower.x0, lower.y0}, {lower.x0, lower.y1}, {lower.x1, lower.y1}}, 1.4 * s_,
                       soft);
        const bool first = index % layout_.columns == 0;
        if (first) {
            canvas_.text({left + 16 * s_, top + 20 * s_}, fit_.scans.unit, 11 * s_, soft);
            canvas_.text({left + 30 * s_, lower.y0 + 41 * s_}, "σ", 12 * s_, soft);
        }
        if (index + layout_.columns >= shown_) {
            canvas_.text({(lower.x0 + lower.x1) / 2, lower.y1 + 44 * s_}, "receive angle", 12 * s_,
                         soft, TextAlign::centre);
        }
    }

    const Fit& fit_;
    double s_;
    std::size_t channels_, shown_;
    Layout layout_;
    Canvas canvas_;
    Range intensity_;
    std::vector<Range> ranges_;
    double reach_ = 0;  // half of each panel's range of receive angles
};

}  // namespace

Picture plot_scans(const Fit& fit, double scale) {
    check_scale(scale);
    return ScanPlot(fit, scale).draw();
}

Picture plot_mu_eff(const Fit& fit, double scale) {
    check_scale(scale);
    const double s = scale;
    const auto pixels = static_cast<int>(std::lround(1000 * s));
    Canvas canvas(pixels, pixels, ground);
    std::vector<double> turns;
    for (int i = 0; i <= 360; ++i) turns.push_back(i);
    const std::vector<double> mu = mu_eff_deg(fit, turns);
    double largest = *std::max_element(mu.begin(), mu.end());
    for (const FittedScan& scan : fit.fitted) {
        if (scan.mu_eff_sigma_deg > 0)
            largest = std::max(largest, scan.mu_eff_deg + scan.mu_eff_sigma_deg);
    }
    const double step = tick_step(1.08 * largest, 5);
    const double outer = std::ceil(1.02 * largest / step) * step;
    const PlotPoint centre{500 * s, 540 * s};
    const double radius = 372 * s;
    const auto at = [&](double turn_deg, double value) {
        const double angle = turn_deg * pi / 180;
        return PlotPoint{centre.x + radius * value / outer * std::cos(angle),
                         centre.y - radius * value / outer * std::sin(angle)};
    };

    canvas.text({40 * s, 50 * s}, "Half width μ against the sample's turn", 20 * s, ink);
    canvas.text({40 * s, 84 * s}, "each scan by itself; dashed: the fitted lobe", 13 * s, soft);
    for (int i = 0; i < 12; ++i) {
        canvas.stroke({centre, at(30 * i, outer)}, 1, faint);
        canvas.text({at(30 * i, 1.075 * outer).x, at(30 * i, 1.075 * outer).y + 6 * s},
                    std::to_string(30 * i) + "°", 13 * s, soft, TextAlign::centre);
    }
    for (double value = step; value <= outer * 1.0001; value += step) {
        std::vector<PlotPoint> circle;
        circle.reserve(turns.size());
        for (const double turn : turns) circle.push_back(at(turn, value));
        canvas.stroke(circle, value > 0.999 * outer ? 1.4 * s : 1,
                      value > 0.999 * outer ? soft : faint);
    }
    // On a ground of their own: a circle must not run through its figure.
    for (double value = step; value <= outer * 1.0001; value += step) {
        const std::string label = tick_label(value, step) + "°";
        const PlotPoint spot = at(75, value);
        const double width = Canvas::text_width(label, 12 * s);
        canvas.fill(spot.x - width / 2 - 4 * s, spot.y - 11 * s, spot.x + width / 2 + 2 * s,
                    spot.y + 9 * s, ground);
        canvas.text({spot.x, spot.y + 5 * s}, label, 12 * s, soft, TextAlign::centre);
    }
    std::vector<PlotPoint> curve;
    for (std::size_t i = 0; i < turns.size(); ++i) curve.push_back(at(turns[i], mu[i]));
    canvas.stroke(curve, 2.4 * s, model, 8 * s);
    for (std::size_t i = 0; i < fit.fitted.size(); ++i) {
        const FittedScan& scan = fit.fitted[i];
        if (!(scan.mu_eff_sigma_deg > 0)) continue;
        const double turn = fit.scans.scans[i].turn_deg;
        canvas.stroke({at(turn, std::max(0.0, scan.mu_eff_deg - scan.mu_eff_sigma_deg)),
                       at(turn, std::min(outer, scan.mu_eff_deg + scan.mu_eff_sigma_deg))},
                      3 * s, measured[0]);
        canvas.disc(at(turn, scan.mu_eff_deg), 6.5 * s, measured[0]);
    }
    return canvas.picture();
}

}  // namespace togishi
