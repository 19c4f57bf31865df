#include "scanned/chart.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "blade/development.hpp"

namespace togishi {
namespace {

// Over which neighbouring cross-sections are evened out, to either side: on the body of the blade,
// whose sections change slowly, and in nakago and kissaki.
constexpr double smooth_mm = 8;
constexpr double smooth_ends_mm = 3;
// Over which an outline is evened out, to either side, never across a ridge.
constexpr double smooth_across_mm = 1.5;
// Within this of the tip, where a section is hardly larger than the scan's noise, all of them are
// known to come to nothing at the tip.
constexpr double tip_mm = 4;
// By how much the chart goes on beyond the tip and the edge line that the cross-sections tell: the
// scan's own points there keep their lengths too.
constexpr double overhang_mm = 0.5;

std::vector<double> running_mean(const std::vector<double>& values, std::size_t reach) {
    std::vector<double> result(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t n = std::min({reach, i, values.size() - 1 - i});
        double sum = 0;
        for (std::size_t j = i - n; j <= i + n; ++j) sum += values[j];
        result[i] = sum / static_cast<double>(2 * n + 1);
    }
    return result;
}

// Weights of values at xs, whose sum is the value at 0 of the parabola that fits them best; of the
// line where they are fewer than four.
std::vector<double> fit_weights(const std::vector<double>& xs) {
    std::array<double, 5> sum{};
    for (const double x : xs) {
        double power = 1;
        for (double& s : sum) {
            s += power;
            power *= x;
        }
    }
    // First row of the inverse of the normal equations' matrix.
    std::array<double, 3> row{};
    if (xs.size() >= 4) {
        row = {sum[2] * sum[4] - sum[3] * sum[3], sum[2] * sum[3] - sum[1] * sum[4],
               sum[1] * sum[3] - sum[2] * sum[2]};
    } else {
        row = {sum[2], -sum[1], 0};
    }
    const double determinant = row[0] * sum[0] + row[1] * sum[1] + row[2] * sum[2];
    std::vector<double> weights;
    weights.reserve(xs.size());
    for (const double x : xs)
        weights.push_back((row[0] + row[1] * x + row[2] * x * x) / determinant);
    return weights;
}

// A raw outline by its share of the developed length.
class Developed {
  public:
    explicit Developed(const std::vector<glm::dvec2>& outline) : outline_(outline) {
        length_.reserve(outline.size());
        double length = 0;
        for (std::size_t i = 0; i < outline.size(); ++i) {
            if (i > 0) length += glm::distance(outline[i - 1], outline[i]);
            length_.push_back(length);
        }
    }
    /// A place on the strip of the outline between two shares, by the parabola that fits the points
    /// of that strip within half_width of it best; straight between two points where they are few.
    [[nodiscard]] glm::dvec2 at(double share, double from, double to, double half_width_mm) const {
        if (outline_.empty()) return {0, 0};
        if (outline_.size() == 1) return outline_[0];
        const double target = share * length_.back();
        const double first = std::max(target - half_width_mm, from * length_.back());
        const double last = std::min(target + half_width_mm, to * length_.back());
        const auto begin = std::lower_bound(length_.begin(), length_.end(), first);
        const auto end = std::upper_bound(begin, length_.end(), last);
        if (end - begin >= 5) {
            std::vector<double> xs(begin, end);
            for (double& x : xs) x = (x - target) / half_width_mm;
            const std::vector<double> weights = fit_weights(xs);
            glm::dvec2 sum(0);
            for (std::size_t j = 0; j < xs.size(); ++j)
                sum += weights[j] * outline_[static_cast<std::size_t>(begin - length_.begin()) + j];
            return sum;
        }
        const auto next = static_cast<std::size_t>(
            std::upper_bound(length_.begin() + 1, length_.end() - 1, target) - length_.begin());
        const double piece = length_[next] - length_[next - 1];
        const double f = piece > 0 ? std::clamp((target - length_[next - 1]) / piece, 0.0, 1.0) : 0;
        return glm::mix(outline_[next - 1], outline_[next], f);
    }

  private:
    const std::vector<glm::dvec2>& outline_;
    std::vector<double> length_;
};

// Weights of values at xs, whose sum is the value at x of the parabola through the origin that fits
// them best.
std::vector<double> fit_weights_from_zero(const std::vector<double>& xs, double x) {
    double s2 = 0;
    double s3 = 0;
    double s4 = 0;
    for (const double v : xs) {
        s2 += v * v;
        s3 += v * v * v;
        s4 += v * v * v * v;
    }
    const double determinant = s2 * s4 - s3 * s3;
    std::vector<double> weights;
    weights.reserve(xs.size());
    for (const double v : xs) {
        weights.push_back((x * (s4 * v - s3 * v * v) + x * x * (s2 * v * v - s3 * v)) /
                          determinant);
    }
    return weights;
}

// Where the mune has a ridge of its own (mitsu-mune), as a share of its developed width; its middle
// where it has none.
double mune_bend(const ScannedStations& stations, std::size_t side) {
    constexpr double least_turn = 0.2;  // radians; a round mune turns by less from point to point
    std::vector<double> shares;
    for (const Station& station : stations.stations) {
        const SectionSide& section = station.side[side];
        std::vector<glm::dvec2> p;
        for (const glm::dvec2& point : section.outline_mm) {
            if (p.empty() || glm::distance(p.back(), point) > 1e-6) p.push_back(point);
        }
        double t = 0;
        double most = least_turn;
        double share = 0;
        for (std::size_t i = 1; i + 1 < p.size(); ++i) {
            const glm::dvec2 before = p[i] - p[i - 1];
            const glm::dvec2 after = p[i + 1] - p[i];
            t += glm::length(before);
            if (t + 0.5 * glm::length(after) >= section.mune_t_mm) break;
            const double turn = std::abs(
                std::atan2(before.x * after.y - before.y * after.x, glm::dot(before, after)));
            if (turn <= most) continue;
            most = turn;
            share = t / section.mune_t_mm;
        }
        if (share > 0) shares.push_back(share);
    }
    if (2 * shares.size() < stations.stations.size()) return 0.5;
    return median(shares);
}

void check(const ScannedStations& s) {
    constexpr const char* where = "scanned blade";
    if (s.stations.size() < 8)
        throw InputError(where, "stations", std::to_string(s.stations.size()),
                         "8 or more cross-sections");
    if (!(s.step_mm > 0 && std::isfinite(s.step_mm)))
        throw InputError(where, "step_mm", std::to_string(s.step_mm), "above 0 mm");
    double widest = 0;
    for (std::size_t i = 0; i < s.stations.size(); ++i) {
        const Station& station = s.stations[i];
        const glm::dvec3 sum = station.ridge_mm + station.along + station.across;
        bool good = std::isfinite(station.s_mm + sum.x + sum.y + sum.z);
        for (const SectionSide& side : station.side) {
            good = good && std::isfinite(side.mune_t_mm + side.shinogi_t_mm + side.edge_t_mm);
            for (const glm::dvec2& p : side.outline_mm) {
                good = good && std::isfinite(p.x + p.y);
                widest = std::max(widest, p.x);
            }
        }
        if (!good)
            throw InputError(where, "stations", "no number in cross-section " + std::to_string(i),
                             "numbers");
        if (i > 0 && !(station.s_mm > s.stations[i - 1].s_mm))
            throw InputError(where, "stations", std::to_string(station.s_mm) + " mm",
                             "arc lengths that rise");
    }
    if (!(widest > 1))
        throw InputError(where, "stations", std::to_string(widest) + " mm wide",
                         "a blade more than 1 mm wide");
    if (!(s.stations.back().s_mm > 20))
        throw InputError(where, "stations",
                         std::to_string(s.stations.back().s_mm) + " mm from machi to tip",
                         "a blade longer than 20 mm");
}

}  // namespace

void ScannedChart::Outline::develop() {
    t[0] = 0;
    for (std::size_t k = 1; k < points; ++k)
        t[k] = t[k - 1] + std::hypot(across[k] - across[k - 1], out[k] - out[k - 1]);
}

glm::dvec2 ScannedChart::Outline::at(double t_mm) const {
    auto next = static_cast<std::size_t>(
        std::upper_bound(t.begin() + 1, t.end() - 1, static_cast<float>(t_mm)) - t.begin());
    while (next > 1 && !(t[next] > t[next - 1])) --next;
    const double piece = double(t[next]) - double(t[next - 1]);
    const double f = piece > 0 ? (t_mm - double(t[next - 1])) / piece : 0;
    return {across[next - 1] + f * (double(across[next]) - double(across[next - 1])),
            out[next - 1] + f * (double(out[next]) - double(out[next - 1]))};
}

ScannedChart::ScannedChart(const ScannedStations& stations, const ChartOptions& options) {
    check(stations);
    make_rows(stations);
    make_frame(stations, options);
}

void ScannedChart::make_rows(const ScannedStations& stations) {
    const std::size_t n = stations.stations.size();
    const auto machi = static_cast<std::size_t>(
        std::lower_bound(stations.stations.begin(), stations.stations.end(), -1e-9,
                         [](const Station& s, double arc) { return s.s_mm < arc; }) -
        stations.stations.begin());
    std::vector<std::array<Outline, 2>> raw(n);
    for (const std::size_t side : {0U, 1U}) {
        std::vector<double> mune(n);
        std::vector<double> shinogi(n);
        for (std::size_t i = 0; i < n; ++i) {
            const SectionSide& section = stations.stations[i].side[side];
            const double edge = std::max(section.edge_t_mm, 1e-9);
            mune[i] = std::clamp(section.mune_t_mm / edge, 0.0, 1.0);
            shinogi[i] = std::clamp(section.shinogi_t_mm / edge, mune[i], 1.0);
        }
        mune = running_median(mune, 4);
        shinogi = running_median(shinogi, 4);
        const double bend = mune_bend(stations, side);
        for (std::size_t i = 0; i < n; ++i) {
            const Developed developed(stations.stations[i].side[side].outline_mm);
            Outline& outline = raw[i][side];
            auto take = [&](std::size_t first, std::size_t last, double from, double to) {
                for (std::size_t k = first; k <= last; ++k) {
                    const double f =
                        static_cast<double>(k - first) / static_cast<double>(last - first);
                    const glm::dvec2 p =
                        developed.at(from + (to - from) * f, from, to, smooth_across_mm);
                    outline.across[k] = static_cast<float>(p.x);
                    outline.out[k] = static_cast<float>(p.y);
                }
            };
            const double corner = std::max(mune[i], shinogi[i]);
            take(0, mune_bend_point, 0, bend * mune[i]);
            take(mune_bend_point, mune_point, bend * mune[i], mune[i]);
            take(mune_point, shinogi_point, mune[i], corner);
            take(shinogi_point, edge_point, corner, 1);
        }
    }

    // Each row by parabolas through the sections around it, not across the machi, where the shape
    // breaks; over fewer where it bends at the yokote. Towards the tip, the nakago's end and its
    // walls at the machi the reach shrinks: they stay in their places.
    const double step = stations.step_mm;
    auto sum_of = [&](const std::vector<std::size_t>& which, const std::vector<double>& weights,
                      std::size_t side) {
        Outline sum;
        for (std::size_t k = 0; k < points; ++k) {
            double across = 0;
            double out = 0;
            for (std::size_t j = 0; j < which.size(); ++j) {
                const Outline& from = raw[which[j]][side];
                across += weights[j] * double(from.across[k]);
                out += weights[j] * double(from.out[k]);
            }
            sum.across[k] = static_cast<float>(across);
            sum.out[k] = static_cast<float>(out);
        }
        return sum;
    };
    auto add_row = [&](double arc, std::size_t first, std::size_t last, double reach) {
        reach = std::max(reach, 1.01 * step);
        std::vector<std::size_t> near;
        std::vector<double> xs;
        auto gather = [&] {
            near.clear();
            xs.clear();
            for (std::size_t i = first; i < last; ++i) {
                const double x = stations.stations[i].s_mm - arc;
                if (std::abs(x) > reach) continue;
                near.push_back(i);
                xs.push_back(x / step);
            }
        };
        gather();
        while (near.size() < std::min<std::size_t>(3, last - first)) {
            reach += step;
            gather();
        }
        const std::vector<double> weights =
            near.size() > 1 ? fit_weights(xs) : std::vector<double>(near.size(), 1.0);
        Row& row = rows_.emplace_back();
        row.arc_mm = arc;
        for (const std::size_t side : {0U, 1U}) row.side[side] = sum_of(near, weights, side);
        for (std::size_t j = 0; j < near.size(); ++j) {
            const Station& s = stations.stations[near[j]];
            row.ridge += weights[j] * s.ridge_mm;
            row.along += weights[j] * s.along;
            row.across += weights[j] * s.across;
        }
        row.along = glm::normalize(row.along);
        row.across = glm::normalize(row.across - row.along * glm::dot(row.along, row.across));
        row.out = glm::cross(row.along, row.across);
    };
    const double begin = stations.stations.front().s_mm;
    const double end = stations.stations.back().s_mm;
    std::vector<std::size_t> at_tip;
    std::vector<double> before_tip;
    for (std::size_t i = machi; i < n; ++i) {
        const double x = end - stations.stations[i].s_mm;
        if (x <= 0 || x > 1.5 * tip_mm) continue;
        at_tip.push_back(i);
        before_tip.push_back(x);
    }
    const bool pointed = at_tip.size() >= 4 && stations.stations.back().side[0].edge_t_mm < 2 &&
                         stations.stations.back().side[1].edge_t_mm < 2;
    auto sharpen = [&](Row& row) {
        const double x = end - row.arc_mm;
        if (!pointed || x >= tip_mm) return;
        const std::vector<double> weights = fit_weights_from_zero(before_tip, x);
        const auto share = static_cast<float>(std::min(1.0, 2 - 2 * x / tip_mm));
        for (const std::size_t side : {0U, 1U}) {
            const Outline to = sum_of(at_tip, weights, side);
            Outline& outline = row.side[side];
            for (std::size_t k = 0; k < points; ++k) {
                outline.across[k] += share * (to.across[k] - outline.across[k]);
                outline.out[k] += share * (to.out[k] - outline.out[k]);
            }
        }
    };
    auto add_segment = [&](Segment& segment, double begin_mm, double end_mm, auto&& at) {
        segment.first_row = rows_.size();
        const double cells = std::ceil((end_mm - begin_mm) / development_step_mm);
        segment.rows = static_cast<std::size_t>(cells) + 1;
        segment.begin_mm = begin_mm;
        segment.step_mm = (end_mm - begin_mm) / cells;
        for (std::size_t i = 0; i < segment.rows; ++i)
            at(i + 1 < segment.rows ? begin_mm + segment.step_mm * static_cast<double>(i) : end_mm);
    };
    const bool tang = machi >= 4 && begin < -1;
    if (tang) {
        add_segment(nakago_, begin, 0, [&](double arc) {
            add_row(arc, 0, machi, std::min({smooth_ends_mm, arc - begin, -arc}));
        });
    }
    add_segment(blade_, 0, end, [&](double arc) {
        const double wide = std::clamp(stations.yokote_s_mm - arc, smooth_ends_mm, smooth_mm);
        add_row(arc, machi, n, std::min(wide, end - arc));
        sharpen(rows_.back());
    });
    // The walls of the machi lead up to the blade's first section.
    if (tang) rows_[blade_.first_row - 1] = rows_[blade_.first_row];
    for (Row& row : rows_) {
        for (Outline& outline : row.side) outline.develop();
    }
}

std::vector<SurfaceMetric> ScannedChart::metric_of_rows() const {
    std::vector<SurfaceMetric> result(rows_.size() - 1);
    for (std::size_t i = 0; i + 1 < rows_.size(); ++i) {
        const Row& r0 = rows_[i];
        const Row& r1 = rows_[i + 1];
        const double step = r1.arc_mm - r0.arc_mm;
        if (!(step > 0)) continue;  // the machi, of which both sides have a row
        SurfaceMetric& m = result[i];
        auto mean_t = [&](std::size_t point) {
            return 0.5 * (r0.mean_t(point) + r1.mean_t(point));
        };
        const double mune = mean_t(mune_point);
        double shear_sum = 0;
        double weight = 0;
        for (const std::size_t side : {0U, 1U}) {
            auto point = [&](const Row& row, double t) {
                const glm::dvec2 p = row.side[side].at(t);
                return row.ridge + row.across * p.x + row.out * (side == 0 ? p.y : -p.y);
            };
            auto strip = [&](std::size_t first, std::size_t last) {
                const double from = mean_t(first);
                const double width = mean_t(last) - from;
                if (!(width > 1e-6)) return;
                for (const double f : {0.02, 0.5, 0.98}) {
                    const double t = from + f * width;
                    const double h = 0.01 * width;
                    const glm::dvec3 by_t =
                        point(r0, t + h) - point(r0, t - h) + point(r1, t + h) - point(r1, t - h);
                    const glm::dvec3 pt = by_t / std::max(glm::length(by_t), 1e-12);
                    const glm::dvec3 by_arc = (point(r1, t) - point(r0, t)) / step;
                    const double shear = glm::dot(by_arc, pt);
                    m.points.push_back({t - mune, glm::length(by_arc - pt * shear), shear});
                    if (first != 0) {
                        shear_sum += shear * width;
                        weight += width;
                    }
                }
            };
            strip(0, mune_point);
            strip(mune_point, shinogi_point);
            strip(shinogi_point, (shinogi_point + edge_point) / 2);
            strip((shinogi_point + edge_point) / 2, edge_point);
        }
        m.shear = weight > 0 ? shear_sum / weight : 0;
        m.mune_slope = (r1.mean_t(mune_point) - r0.mean_t(mune_point)) / step;
        m.half_width = 0.5 * mean_t(edge_point);
        m.mune_half_width = 0.5 * mune;
    }
    return result;
}

void ScannedChart::make_frame(const ScannedStations& stations, const ChartOptions& options) {
    const std::vector<SurfaceMetric> of_interval = metric_of_rows();
    const double begin = rows_.front().arc_mm;
    const double end = rows_.back().arc_mm;
    const std::size_t before = nakago_.rows > 0 ? nakago_.rows - 1 : 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        if (i + 1 != blade_.first_row) sample_arc_mm_.push_back(rows_[i].arc_mm);
    }
    const std::size_t n = sample_arc_mm_.size();
    // The walls of the machi and of the nakago's end lie across the chart, and the tip is too small
    // to tell: what lies before them counts there.
    const double wall_mm = std::min(12.0, -0.4 * begin);
    const double ramp_mm = std::min(1.5, -0.1 * begin);
    std::vector<SurfaceMetric> metric(n - 1);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        double arc = 0.5 * (sample_arc_mm_[i] + sample_arc_mm_[i + 1]);
        arc = std::min(arc, end - 0.25 * tip_mm);
        if (arc < 0) arc = std::clamp(arc, begin + wall_mm, -ramp_mm);
        metric[i] = of_interval[between(arc).row];
        if (arc < 0) metric[i].shear = 0;
    }
    // The chart follows what the shape does over millimetres, not one section's error.
    std::vector<double> shear(n - 1 - before);
    for (std::size_t i = before; i + 1 < n; ++i) shear[i - before] = metric[i].shear;
    shear = running_mean(running_median(shear, 8), 4);
    for (std::size_t i = before; i + 1 < n; ++i) metric[i].shear = shear[i - before];

    // Without a yokote the ridge opens where it serves best.
    std::vector<double> lift_from{stations.yokote_s_mm};
    if (!(stations.yokote_s_mm < end - 1)) {
        const double width = curve(edge_point, 0.9 * end);
        lift_from = {end - width, end - 1.5 * width, end - 2 * width, end - 3 * width};
    }
    Development best;
    for (const double from : lift_from) {
        Development tried = develop_blade(metric, sample_arc_mm_, std::max(0.0, from));
        if (tried.worst < best.worst) best = std::move(tried);
    }
    if (best.s_mm.empty())
        throw InputError("scanned blade", "stations", "cross-sections of no size",
                         "cross-sections whose outlines can be laid flat");
    sample_s_mm_ = best.s_mm;
    const double machi = sample_s_mm_[before];
    for (double& value : sample_s_mm_) value -= machi;
    frame_.nakago_mm = -sample_s_mm_.front();
    frame_.nagasa_mm = sample_s_mm_.back();
    frame_.yokote_s_mm =
        stations.yokote_s_mm < end - 1 ? s_mm(stations.yokote_s_mm) : frame_.nagasa_mm;

    const double moto_ji = curve(edge_point, 0) - curve(shinogi_point, 0);
    const double ha_share = std::clamp(options.ha_haba_mm / std::max(moto_ji, 1e-6), 0.0, 1.0);
    const auto samples = static_cast<std::size_t>(frame_.length_mm() / development_step_mm) + 2;
    std::vector<double> middles(best.skew.size());
    for (std::size_t i = 0; i < middles.size(); ++i)
        middles[i] = 0.5 * (sample_arc_mm_[i] + sample_arc_mm_[i + 1]);
    double highest = 0;
    for (std::size_t i = 0; i < samples; ++i) {
        const double here = -frame_.nakago_mm + frame_.length_mm() * static_cast<double>(i) /
                                                    static_cast<double>(samples - 1);
        const double arc = arc_mm(here);
        const double shinogi = curve(shinogi_point, arc);
        const double edge = curve(edge_point, arc);
        frame_.edge_mm.push_back(edge);
        frame_.shinogi_mm.push_back(shinogi);
        frame_.mune_mm.push_back(curve(mune_point, arc));
        frame_.suguha_mm.push_back(edge - ha_share * (edge - shinogi));
        frame_.skew.push_back(interpolated(middles, best.skew, arc));
        frame_.mune_skew.push_back(interpolated(middles, best.mune_skew, arc));
        frame_.lift_mm.push_back(interpolated(sample_arc_mm_, best.lift_mm, arc));
        highest = std::max(highest, edge + frame_.lift_mm.back());
    }
    // Some room beyond the edge lines, so that a map can be padded there.
    frame_.chart_height_mm = 2 * highest * 1.03;
}

ScannedChart::Between ScannedChart::between(double arc_mm) const {
    const Segment& segment = arc_mm < 0 && nakago_.rows > 0 ? nakago_ : blade_;
    const double x = (arc_mm - segment.begin_mm) / segment.step_mm;
    const double cell = std::clamp(std::floor(x), 0.0, static_cast<double>(segment.rows - 2));
    return {segment.first_row + static_cast<std::size_t>(cell), std::clamp(x - cell, 0.0, 1.0)};
}

double ScannedChart::curve(std::size_t point, double arc_mm) const {
    const auto [row, share] = between(arc_mm);
    return rows_[row].mean_t(point) * (1 - share) + rows_[row + 1].mean_t(point) * share;
}

double ScannedChart::s_mm(double arc) const {
    return interpolated(sample_arc_mm_, sample_s_mm_, arc);
}

double ScannedChart::arc_mm(double s) const {
    return interpolated(sample_s_mm_, sample_arc_mm_, s);
}

glm::dvec3 ScannedChart::along(double arc) const {
    const auto [row, share] = between(arc);
    return glm::normalize(glm::mix(rows_[row].along, rows_[row + 1].along, share));
}

ChartPlace ScannedChart::place(const glm::dvec3& p) const {
    ChartPlace place;
    const Row& first = rows_.front();
    const Row& last = rows_.back();
    // The section's plane that p lies in: each step leaves the share of the distance to the mune
    // line in the radius of its bend, a hundredth.
    double arc = first.arc_mm + (last.arc_mm - first.arc_mm) * (p.x - first.ridge.x) /
                                    (last.ridge.x - first.ridge.x);
    Between at = between(arc);
    for (int i = 0; i < 5; ++i) {
        const Row& r0 = rows_[at.row];
        const Row& r1 = rows_[at.row + 1];
        const double here = glm::mix(r0.arc_mm, r1.arc_mm, at.share);
        const double ahead = glm::dot(p - glm::mix(r0.ridge, r1.ridge, at.share),
                                      glm::mix(r0.along, r1.along, at.share));
        arc = here + ahead;
        at = between(arc);
        if (std::abs(ahead) < 1e-6) break;
    }
    place.arc_mm = std::clamp(arc, first.arc_mm, last.arc_mm);
    place.beyond_mm = std::abs(arc - place.arc_mm);
    place.s_mm = s_mm(place.arc_mm) + std::clamp(arc - place.arc_mm, -overhang_mm, overhang_mm);

    const Row& r0 = rows_[at.row];
    const Row& r1 = rows_[at.row + 1];
    const auto f = static_cast<float>(at.share);
    const glm::dvec3 from = p - glm::mix(r0.ridge, r1.ridge, at.share);
    const double across = glm::dot(from, glm::mix(r0.across, r1.across, at.share));
    const double out = glm::dot(from, glm::mix(r0.out, r1.out, at.share));
    auto mixed = [&](std::size_t side, const std::array<float, points> Outline::*what,
                     std::size_t k) {
        return (r0.side[side].*what)[k] * (1 - f) + (r1.side[side].*what)[k] * f;
    };
    // The middle plane goes through the ridge and the edge.
    const float edge_across =
        0.5F * (mixed(0, &Outline::across, edge_point) + mixed(1, &Outline::across, edge_point));
    const float edge_out =
        0.5F * (mixed(0, &Outline::out, edge_point) - mixed(1, &Outline::out, edge_point));
    const double share = edge_across > 0 ? std::clamp(across / double(edge_across), 0.0, 1.0) : 0;
    place.middle_mm = out - double(edge_out) * share;

    const std::size_t side = place.omote() ? 0 : 1;
    const auto x = static_cast<float>(across);
    const auto y = static_cast<float>(side == 0 ? out : -out);
    float ax = mixed(side, &Outline::across, 0);
    float ay = mixed(side, &Outline::out, 0);
    float nearest = std::numeric_limits<float>::infinity();
    float t = 0;
    float sign = 1;
    for (std::size_t k = 0; k < edge_point; ++k) {
        const float bx = mixed(side, &Outline::across, k + 1);
        const float by = mixed(side, &Outline::out, k + 1);
        const float ex = bx - ax;
        const float ey = by - ay;
        const float u = std::clamp(
            ((x - ax) * ex + (y - ay) * ey) / std::max(ex * ex + ey * ey, 1e-12F), 0.0F, 1.0F);
        const float dx = x - ax - u * ex;
        const float dy = y - ay - u * ey;
        const float squared = dx * dx + dy * dy;
        if (squared < nearest) {
            nearest = squared;
            const float t0 = mixed(side, &Outline::t, k);
            t = t0 + u * (mixed(side, &Outline::t, k + 1) - t0);
            sign = ex * dy - ey * dx;
        }
        ax = bx;
        ay = by;
    }
    place.off_mm = std::copysign(std::sqrt(double(nearest)), double(sign));
    // The chart has one edge line for both sides.
    const double own = mixed(side, &Outline::t, edge_point);
    const double both = 0.5 * (own + double(mixed(1 - side, &Outline::t, edge_point)));
    place.t_mm = own > 0 ? double(t) * std::clamp(both / own, 0.9, 1.1) : 0;
    if (t >= own) {
        const glm::dvec2 before(mixed(side, &Outline::across, edge_point - 1),
                                mixed(side, &Outline::out, edge_point - 1));
        const glm::dvec2 last_cell = glm::dvec2(ax, ay) - before;
        const double length = glm::length(last_cell);
        const glm::dvec2 onwards = length > 1e-4 ? last_cell / length : glm::dvec2(1, 0);
        place.t_mm +=
            std::clamp(glm::dot(glm::dvec2(x, y) - glm::dvec2(ax, ay), onwards), 0.0, overhang_mm);
    }
    return place;
}

glm::dvec3 ScannedChart::point(double s, double t, bool omote) const {
    const double on_blade = std::clamp(s, sample_s_mm_.front(), sample_s_mm_.back());
    const Between at = between(arc_mm(on_blade));
    const Row& r0 = rows_[at.row];
    const Row& r1 = rows_[at.row + 1];
    const auto f = static_cast<float>(at.share);
    const std::size_t side = omote ? 0 : 1;
    auto mixed = [&](std::size_t of_side, const std::array<float, points> Outline::*what,
                     std::size_t k) {
        return (r0.side[of_side].*what)[k] * (1 - f) + (r1.side[of_side].*what)[k] * f;
    };
    const double own = mixed(side, &Outline::t, edge_point);
    const double both = 0.5 * (own + double(mixed(1 - side, &Outline::t, edge_point)));
    const double scale = own > 0 ? std::clamp(both / own, 0.9, 1.1) : 1;
    const double along_outline = std::min(t / scale, own);
    std::size_t k = 1;
    while (k < edge_point && double(mixed(side, &Outline::t, k)) < along_outline) ++k;
    const double t0 = mixed(side, &Outline::t, k - 1);
    const double cell = double(mixed(side, &Outline::t, k)) - t0;
    const glm::dvec2 from(mixed(side, &Outline::across, k - 1), mixed(side, &Outline::out, k - 1));
    const glm::dvec2 to(mixed(side, &Outline::across, k), mixed(side, &Outline::out, k));
    glm::dvec2 place = cell > 0 ? glm::mix(from, to, (along_outline - t0) / cell) : from;
    const double beyond = t - own * scale;
    if (beyond > 0) {
        const double length = glm::distance(from, to);
        place += (length > 1e-4 ? (to - from) / length : glm::dvec2(1, 0)) * beyond;
    }
    return glm::mix(r0.ridge, r1.ridge, at.share) +
           glm::mix(r0.across, r1.across, at.share) * place.x +
           glm::mix(r0.out, r1.out, at.share) * (omote ? place.y : -place.y) +
           glm::normalize(glm::mix(r0.along, r1.along, at.share)) * (s - on_blade);
}

glm::dvec2 ScannedChart::uv(double s, double t, bool omote) const {
    const double y = frame_.chart_y_mm(s, t) / frame_.chart_height_mm;
    return {(frame_.chart_x_mm(s, t) + frame_.nakago_mm) / frame_.length_mm(),
            omote ? 0.5 - y : 0.5 + y};
}

}  // namespace togishi
