#include "scanned/blade_fit.hpp"

#include <algorithm>
#include <cmath>

#include "base/order_statistics.hpp"
#include "scanned/least_squares.hpp"
#include "scanned/turning_points.hpp"

namespace togishi {
namespace {

bool covered(const BladeFit& fit, double s_mm, double half_mm) {
    return std::any_of(fit.fittings_s.begin(), fit.fittings_s.end(), [&](const auto& f) {
        return s_mm + half_mm > f.first && s_mm - half_mm < f.second;
    });
}

std::vector<std::pair<double, double>> fittings_of(const std::vector<LengthBin>& bins,
                                                   double wider_mm) {
    std::vector<std::pair<double, double>> result;
    for (const LengthBin& bin : bins) {
        if (!bin.fitting) continue;
        const double from = bin.x - 0.5 - wider_mm;
        if (result.empty() || from > result.back().second + 1.5)
            result.emplace_back(from, bin.x + 0.5 + wider_mm);
        else
            result.back().second = bin.x + 0.5 + wider_mm;
    }
    return result;
}

struct Place {
    double s_mm, half_mm;
};

// Where cross-sections are fitted: closer together towards the point.
std::vector<Place> blade_places(const BladeFit& fit) {
    const double close_mm = std::max(90.0, 4.8 * fit.blade_guess.at(body_middle(fit)).edge_d);
    std::vector<Place> places;
    const double close = std::max(fit.machi_s_mm + 6, fit.tip_s_mm - close_mm);
    for (double s = fit.machi_s_mm + 2.3; s < close; s += 4) places.push_back({s, 2});
    for (double s = close + 1; s < fit.tip_s_mm - 2; s += 1) places.push_back({s, 1.2});
    std::erase_if(places, [&](const Place& p) { return covered(fit, p.s_mm, p.half_mm); });
    // What shows of the blade between the machi and the habaki tells more than a long
    // extrapolation.
    for (const auto& f : fit.fittings_s) {
        const double room = f.first - fit.machi_s_mm - 0.2;
        if (room > 1 && room < 4.6)
            places.insert(places.begin(), {fit.machi_s_mm + 0.2 + 0.5 * room, 0.5 * room});
    }
    return places;
}

std::vector<Place> nakago_places(const BladeFit& fit) {
    std::vector<Place> places;
    if (!fit.tang) return places;
    for (double s = fit.begin_s_mm + 3; s < fit.machi_s_mm - 3.5; s += 4) places.push_back({s, 2});
    std::erase_if(places, [&](const Place& p) { return covered(fit, p.s_mm, p.half_mm); });
    return places;
}

// What the sections around each one have in common: single failures move nothing.
SectionGuesses guesses_from(const std::vector<SectionFit>& fits, const SectionGuesses& before,
                            bool ridge, bool blunt) {
    SectionGuesses result;
    const std::size_t n = fits.size();
    for (std::size_t i = 0; i < n; ++i) {
        SectionGuess g = before.at(fits[i].s_mm);
        g.blunt = blunt;
        auto around = [&](auto&& good, auto&& value, double& member) {
            std::vector<double> values;
            const std::size_t reach = std::min({std::size_t{2}, i, n - 1 - i});
            for (std::size_t j = i - reach; j <= i + reach; ++j) {
                if (good(fits[j])) values.push_back(value(fits[j]));
            }
            if (!values.empty()) member = median(values);
        };
        auto mune = [](const SectionFit& f) { return f.mune && f.sides; };
        around(
            mune, [](const SectionFit& f) { return f.top_d; }, g.top_d);
        around(
            mune, [](const SectionFit& f) { return 0.5 * (f.corner_y[0] + f.corner_y[1]); },
            g.corner_y);
        around(
            mune, [](const SectionFit& f) { return 0.5 * (f.corner_d[0] + f.corner_d[1]); },
            g.corner_d);
        if (ridge) {
            around([](const SectionFit& f) { return f.shinogi; },
                   [](const SectionFit& f) { return 0.5 * (f.shinogi_d[0] + f.shinogi_d[1]); },
                   g.shinogi_d);
        }
        around([&](const SectionFit& f) { return blunt ? f.edge_d > 0 : f.edge; },
               [](const SectionFit& f) { return f.edge_d; }, g.edge_d);
        g.corner_y = std::max(g.corner_y, 0.05);
        result.add(fits[i].s_mm, g);
    }
    return result.empty() ? before : result;
}

class Located {
  public:
    Located(std::span<const ScanPoint> points, const BladeCurve& curve) {
        points_.reserve(points.size());
        for (const ScanPoint& p : points) {
            points_.push_back(curve.locate(p.position_mm));
            points_.back().omote = p.omote;
        }
        std::sort(points_.begin(), points_.end(),
                  [](const BladePoint& a, const BladePoint& b) { return a.s_mm < b.s_mm; });
    }
    [[nodiscard]] std::span<const BladePoint> between(double from, double to) const {
        auto by_s = [](const BladePoint& p, double s) { return p.s_mm < s; };
        const auto a = std::lower_bound(points_.begin(), points_.end(), from, by_s);
        const auto b = std::lower_bound(a, points_.end(), std::max(from, to), by_s);
        return {a, b};
    }
    [[nodiscard]] std::span<const BladePoint> all() const { return points_; }

  private:
    std::vector<BladePoint> points_;
};

std::vector<SectionFit> fit_sections(const Located& points, const std::vector<Place>& places,
                                     const SectionGuesses& guesses, const MuneKind& mune) {
    std::vector<SectionFit> fits;
    fits.reserve(places.size());
    std::vector<double> depths;
    for (const Place& place : places) {
        const auto slab = points.between(place.s_mm - place.half_mm, place.s_mm + place.half_mm);
        const SectionGuess guess = guesses.at(place.s_mm);
        SectionFit f = fit_section(slab, place.s_mm, place.half_mm, guess, mune);
        if (guess.blunt && slab.size() > 20) {
            depths.clear();
            for (const BladePoint& p : slab) depths.push_back(p.d_mm);
            f.edge_d = quantile(depths, 0.995);
        }
        fits.push_back(f);
    }
    return fits;
}

// Where the blade's body ends and its point begins.
double body_end(const BladeFit& fit) {
    if (fit.yokote) return fit.yokote_s_mm - 0.7;
    const double width = fit.blade_guess.at(body_middle(fit)).edge_d;
    return std::max(fit.tip_s_mm - 2 * width, 0.5 * (fit.machi_s_mm + fit.tip_s_mm));
}

void find_mune_kind(const Located& points, BladeFit& fit) {
    struct Candidate {
        MuneKind kind;
        double squares = 0, count = 0, height = 0;
    };
    std::vector<Candidate> candidates{{{MuneType::iori, 0}},    {{MuneType::maru, 0}},
                                      {{MuneType::mitsu, 0.3}}, {{MuneType::mitsu, 0.4}},
                                      {{MuneType::mitsu, 0.5}}, {{MuneType::mitsu, 0.6}}};
    const double to = body_end(fit);
    double sections = 0;
    for (double s = fit.machi_s_mm + 6; s < to; s += 12) {
        if (covered(fit, s, 2)) continue;
        const auto slab = points.between(s - 2, s + 2);
        for (Candidate& c : candidates) {
            const MuneMisfit m = mune_misfit(slab, s, 2, fit.blade_guess.at(s), c.kind);
            c.squares += m.squares;
            c.count += m.points;
            c.height += m.height;
        }
        ++sections;
    }
    const auto best =
        std::min_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
            return a.squares / std::max(a.count, 1.0) < b.squares / std::max(b.count, 1.0);
        });
    fit.mune = best->kind;
    // A flat back, whatever shape its noise is most like.
    if (std::abs(candidates[0].height) < 0.12 * std::max(1.0, sections))
        fit.mune = {MuneType::kaku, 0};
}

// The mune line through the sections' ridges on the blade, and the middle between the sides.
void refit_curve(BladeFit& fit, double length) {
    std::vector<CurveSample> mune;
    std::vector<CurveSample> middle;
    auto add = [&](const SectionFit& f, double weight, bool blade) {
        if (!f.mune || !f.sides) return;
        const glm::dvec3 line = fit.curve.at(f.s_mm);
        const glm::dvec3 top = line + fit.curve.across(f.s_mm) * f.top_d;
        if (blade) mune.push_back({top.x, top.z, weight});
        middle.push_back({top.x, line.y + f.middle_y, weight});
    };
    for (const SectionFit& f : fit.blade) {
        // The last of the mune is too narrow to tell.
        const bool near = f.s_mm > fit.tip_s_mm - 90;
        if (f.s_mm < fit.tip_s_mm - 8) add(f, near ? 0.25 : 1, true);
    }
    for (const SectionFit& f : fit.nakago) add(f, 1, false);
    if (mune.size() < 8) return;
    const double tip_x = fit.curve.x_at(fit.tip_s_mm);
    const double begin_x = fit.curve.x_at(0);
    const double machi_x = fit.curve.x_at(fit.machi_s_mm);
    const double from = std::min(mune.front().x, machi_x);
    BladeCurve next(SmoothCurve::fit(mune, from, tip_x, std::max(100.0, length / 5)),
                    SmoothCurve::fit(middle, std::min(middle.back().x, from), tip_x, length / 3),
                    begin_x, tip_x + 5, from);
    // What is kept by arc length moves along.
    auto moved = [&](double s) { return next.s_mm(fit.curve.x_at(s)); };
    fit.machi_s_mm = moved(fit.machi_s_mm);
    fit.tip_s_mm = moved(fit.tip_s_mm);
    for (auto& f : fit.fittings_s) f = {moved(f.first), moved(f.second)};
    fit.yokote_s_mm = moved(fit.yokote_s_mm);
    fit.begin_s_mm = moved(fit.begin_s_mm);
    fit.curve = std::move(next);
}

// The blade's plane goes through mune and edge.
double lean_of(const BladeFit& fit) {
    double sum = 0;
    double weight = 0;
    for (const SectionFit& f : fit.blade) {
        if (!f.mune || !f.sides || !f.edge || f.s_mm > body_end(fit)) continue;
        sum += (f.edge_y - f.middle_y) * f.edge_d;
        weight += f.edge_d * f.edge_d;
    }
    return weight > 0 ? sum / weight : 0;
}

void fit_lines(BladeFit& fit) {
    BladeLines& lines = fit.lines;
    lines.from_s_mm = fit.machi_s_mm;
    lines.to_s_mm = body_end(fit);
    auto line = [&](auto&& good, auto&& value) {
        std::vector<CurveSample> samples;
        for (const SectionFit& f : fit.blade) {
            if (f.s_mm > lines.to_s_mm || !f.sides || !good(f)) continue;
            samples.push_back({f.s_mm, value(f), f.s_mm > fit.tip_s_mm - 90 ? 0.25 : 1});
        }
        const double length = lines.to_s_mm - lines.from_s_mm;
        return SmoothCurve::fit(samples, lines.from_s_mm, lines.to_s_mm,
                                std::max(110.0, length / 3));
    };
    auto mean = [](const std::array<double, 2>& v) { return 0.5 * (v[0] + v[1]); };
    auto mune = [](const SectionFit& f) { return f.mune; };
    lines.top_d = line(mune, [](const SectionFit& f) { return f.top_d; });
    lines.corner_y = line(mune, [&](const SectionFit& f) { return mean(f.corner_y); });
    lines.corner_d = line(mune, [&](const SectionFit& f) { return mean(f.corner_d); });
    auto edge = [](const SectionFit& f) { return f.edge; };
    lines.edge_d.near_d = line(edge, [](const SectionFit& f) { return f.edge_d; });
    auto ji_at = [&](const SectionFit& f, double d) {
        return 0.5 * (f.half_thickness_ji(0, d) + f.half_thickness_ji(1, d));
    };
    auto ji_slope = [&](const SectionFit& f, double d) {
        return 0.5 * (f.ji[0][1] + f.ji[1][1]) + (f.ji[0][2] + f.ji[1][2]) * (d - f.ji_d);
    };
    lines.edge_d.gap =
        line(edge, [&](const SectionFit& f) { return ji_at(f, lines.edge_d.near_d.at(f.s_mm)); });
    lines.edge_d.gap_by_d = line(
        edge, [&](const SectionFit& f) { return ji_slope(f, lines.edge_d.near_d.at(f.s_mm)); });
    if (!fit.ridge) return;
    auto shinogi = [](const SectionFit& f) { return f.shinogi; };
    MeetingLine& meeting = lines.shinogi_d;
    meeting.near_d = line(shinogi, [&](const SectionFit& f) { return mean(f.shinogi_d); });
    auto flat_at = [&](const SectionFit& f, double d) {
        return 0.5 * (f.flat[0][0] + f.flat[1][0] + (f.flat[0][1] + f.flat[1][1]) * d);
    };
    meeting.gap = line(shinogi, [&](const SectionFit& f) {
        const double d = meeting.near_d.at(f.s_mm);
        return ji_at(f, d) - flat_at(f, d);
    });
    meeting.gap_by_d = line(shinogi, [&](const SectionFit& f) {
        return ji_slope(f, meeting.near_d.at(f.s_mm)) - 0.5 * (f.flat[0][1] + f.flat[1][1]);
    });
    lines.shinogi_y =
        line(shinogi, [&](const SectionFit& f) { return flat_at(f, meeting.at(f.s_mm)); });
}

// Share of the width at which the side breaks most, and by how much of the thickness: the shinogi.
// profile: half thickness over 50 equal steps from the mune to the edge, largest 1.
struct Break {
    double share = 0, turn = 0;
};
Break find_break(const std::array<double, 50>& profile, double from) {
    Break best;
    double least = 1e300;
    for (double b = from + 0.06; b < 0.72; b += 0.01) {
        // A line above, a parabola below.
        LeastSquares<4> system;
        std::array<double, 4> x{};
        auto row = [&](double e) {
            const double over = std::max(0.0, e - b);
            return std::array<double, 4>{1, e - b, over, over * over};
        };
        for (std::size_t k = 0; k < profile.size(); ++k) {
            const double e = (static_cast<double>(k) + 0.5) / 50;
            if (e > from && e < 0.94) system.add(row(e), profile[k]);
        }
        if (!system.solve(x)) continue;
        double squares = 0;
        for (std::size_t k = 0; k < profile.size(); ++k) {
            const double e = (static_cast<double>(k) + 0.5) / 50;
            if (!(e > from && e < 0.94)) continue;
            double r = profile[k];
            const std::array<double, 4> a = row(e);
            for (std::size_t i = 0; i < 4; ++i) r -= a[i] * x[i];
            squares += r * r;
        }
        if (squares < least) {
            least = squares;
            best = {b, -x[2]};
        }
    }
    return best;
}

}  // namespace

void SectionGuesses::add(double s_mm, const SectionGuess& guess) {
    s_.push_back(s_mm);
    guess_.push_back(guess);
}

double MeetingLine::at(double s_mm) const {
    const double slope = gap_by_d.at(s_mm);
    const double move = std::abs(slope) > 1e-3 ? -gap.at(s_mm) / slope : 0;
    return near_d.at(s_mm) + std::clamp(move, -1.0, 1.0);
}

SectionGuess SectionGuesses::at(double s) const {
    if (s_.empty()) return {};
    const auto after =
        static_cast<std::size_t>(std::lower_bound(s_.begin(), s_.end(), s) - s_.begin());
    if (after == 0) return guess_.front();
    if (after == s_.size()) return guess_.back();
    const SectionGuess& a = guess_[after - 1];
    const SectionGuess& b = guess_[after];
    const double f = (s - s_[after - 1]) / std::max(1e-9, s_[after] - s_[after - 1]);
    SectionGuess g = a;
    g.top_d = std::lerp(a.top_d, b.top_d, f);
    g.corner_y = std::lerp(a.corner_y, b.corner_y, f);
    g.corner_d = std::lerp(a.corner_d, b.corner_d, f);
    g.shinogi_d = std::lerp(a.shinogi_d, b.shinogi_d, f);
    g.edge_d = std::lerp(a.edge_d, b.edge_d, f);
    return g;
}

bool begin_fit(std::span<const ScanPoint> points, const CoarsePose& pose, BladeFit& fit) {
    const std::vector<LengthBin>& bins = pose.bins;
    if (bins.size() < 40 || points.size() < 1000) return false;
    fit.tang = pose.tang;
    fit.point = pose.point;
    const double begin = bins.front().x - 0.5;
    const double end = bins.back().x + 0.5;
    std::vector<CurveSample> mune;
    std::vector<CurveSample> middle;
    for (const LengthBin& bin : bins) {
        if (bin.fitting || bin.samples < 12 || bin.x > end - 4) continue;
        if (bin.x < pose.machi_x + (pose.tang ? 4 : 1)) continue;
        mune.push_back({bin.x, bin.back_z, 1});
    }
    if (mune.size() < 30) return false;
    const std::size_t skip = std::max<std::size_t>(1, points.size() / 20000);
    for (std::size_t i = 0; i < points.size(); i += skip)
        middle.push_back({points[i].position_mm.x, points[i].position_mm.y, 1});
    const double blade = end - pose.machi_x;
    fit.curve =
        BladeCurve(SmoothCurve::fit(mune, mune.front().x, end, blade / 5),
                   SmoothCurve::fit(middle, begin, end, blade / 2), begin, end + 5, mune.front().x);
    // An upright bin of the rough pose leans against the cross-sections.
    for (const auto& [from, to] : fittings_of(bins, 3.5))
        fit.fittings_s.emplace_back(fit.curve.s_mm(from), fit.curve.s_mm(to));
    fit.begin_s_mm = 0;
    fit.machi_s_mm = fit.curve.s_mm(pose.machi_x);
    fit.tip_s_mm = fit.curve.s_mm(end);

    // The whole blade's section by shares of width and thickness.
    const Located located(points, fit.curve);
    const double body_to = fit.machi_s_mm + 0.72 * (fit.tip_s_mm - fit.machi_s_mm);
    std::array<double, 50> sum{};
    std::array<double, 50> count{};
    std::vector<double> depths;
    std::vector<double> thickness;
    struct Raw {
        double s, top, width, half;
    };
    std::vector<Raw> raw;
    std::vector<double> roof;
    for (double s = fit.machi_s_mm + 6; s < fit.tip_s_mm - 4; s += 4) {
        if (covered(fit, s, 2)) continue;
        const auto slab = located.between(s - 2, s + 2);
        if (slab.size() < 60) continue;
        depths.clear();
        for (const BladePoint& p : slab) depths.push_back(p.d_mm);
        const double top = quantile(depths, 0.004);
        const double width = quantile(depths, 0.996) - top;
        if (!(width > 2)) continue;
        thickness.clear();
        for (const BladePoint& p : slab) thickness.push_back(p.y_mm);
        const double middle_y = 0.5 * (quantile(thickness, 0.03) + quantile(thickness, 0.97));
        thickness.clear();
        for (const BladePoint& p : slab) {
            if (p.d_mm > top + 0.1 * width && p.d_mm < top + 0.5 * width)
                thickness.push_back(std::abs(p.y_mm - middle_y));
        }
        if (thickness.size() < 12) continue;
        const double half = quantile(thickness, 0.8);
        raw.push_back({s, top, width, half});
        if (s > body_to) continue;
        for (const BladePoint& p : slab) {
            const double share = (p.d_mm - top) / width;
            if (share < 0 || share >= 1) continue;
            const auto bin = static_cast<std::size_t>(50 * share);
            sum[bin] += std::abs(p.y_mm - middle_y) / half;
            ++count[bin];
        }
        // How far the mune falls from its middle to its corners.
        std::array<double, 2> d{};
        std::array<double, 2> n{};
        for (const BladePoint& p : slab) {
            const double y = std::abs(p.y_mm - middle_y) / half;
            if (p.d_mm > top + 0.25 * width) continue;
            if (y < 0.2) d[0] += p.d_mm, ++n[0];
            if (y > 0.6 && y < 0.8) d[1] += p.d_mm, ++n[1];
        }
        if (n[0] > 2 && n[1] > 2) roof.push_back((d[1] / n[1] - d[0] / n[0]) / 0.6 / width);
    }
    if (raw.size() < 6) return false;
    std::array<double, 50> profile{};
    for (std::size_t k = 0; k < profile.size(); ++k) profile[k] = sum[k] / std::max(count[k], 1.0);
    const double height = std::clamp(median(roof), 0.0, 0.2);
    const double from = std::max(0.08, height + 0.05);
    const Break found = find_break(profile, from);
    fit.ridge = found.turn > 0.45;
    const auto corner_bin = static_cast<std::size_t>(50 * from);
    const double corner = std::clamp(profile[corner_bin], 0.5, 1.05);
    for (const Raw& r : raw) {
        SectionGuess g;
        g.top_d = r.top;
        g.corner_y = corner * r.half;
        g.corner_d = r.top + height * r.width;
        g.shinogi_d = fit.ridge ? r.top + found.share * r.width : 0;
        g.edge_d = r.top + r.width;
        fit.blade_guess.add(r.s, g);
    }
    const SectionGuess at_machi = fit.blade_guess.at(fit.machi_s_mm);
    if (fit.tang) {
        for (double s = 3; s < fit.machi_s_mm - 4; s += 4) {
            const auto slab = located.between(s - 2, s + 2);
            if (slab.size() < 60) continue;
            depths.clear();
            for (const BladePoint& p : slab) depths.push_back(p.d_mm);
            SectionGuess g = at_machi;
            g.blunt = true;
            g.top_d = quantile(depths, 0.004);
            g.edge_d = quantile(depths, 0.996);
            const double width = std::max(1.0, g.edge_d - g.top_d);
            thickness.clear();
            for (const BladePoint& p : slab) {
                if (p.d_mm > g.top_d + 0.15 * width && p.d_mm < g.top_d + 0.5 * width)
                    thickness.push_back(std::abs(p.y_mm));
            }
            if (thickness.size() < 12) continue;
            g.corner_y = corner * quantile(thickness, 0.8);
            g.corner_d = g.top_d + 0.6 * height * width;
            g.shinogi_d = fit.ridge ? g.top_d + 0.35 * width : 0;
            fit.nakago_guess.add(s, g);
        }
    }
    fit.blade = fit_sections(located, blade_places(fit), fit.blade_guess, fit.mune);
    return true;
}

bool improve_fit(std::span<const ScanPoint> points, BladeFit& fit) {
    const double length = fit.tip_s_mm - fit.machi_s_mm;
    for (int pass = 0; pass < 2; ++pass) {
        const Located located(points, fit.curve);
        if (pass == 0 && fit.residual_mm == 0) find_mune_kind(located, fit);
        if (pass == 1 && !fit.fittings_s.empty() && !fit.settled) {
            std::vector<glm::dvec3> straight;
            for (const BladePoint& p : located.all())
                straight.emplace_back(p.s_mm, p.y_mm, -p.d_mm);
            fit.fittings_s = fittings_of(find_length_bins(straight), 0);
            fit.settled = true;
        }
        fit.nakago = fit_sections(located, nakago_places(fit), fit.nakago_guess, fit.mune);
        fit.blade = fit_sections(located, blade_places(fit), fit.blade_guess, fit.mune);
        const auto good = std::count_if(fit.blade.begin(), fit.blade.end(),
                                        [](const auto& f) { return f.mune && f.sides && f.edge; });
        // Half of a blade's cross-sections and more are told by their surfaces.
        if (good < 8 || 3 * good < static_cast<std::ptrdiff_t>(fit.blade.size())) return false;
        std::vector<double> residuals;
        for (const SectionFit& f : fit.blade) {
            if (f.mune && f.sides) residuals.push_back(f.residual);
        }
        fit.residual_mm = median(residuals);
        fit.blade_guess = guesses_from(fit.blade, fit.blade_guess, fit.ridge, false);
        fit.nakago_guess = guesses_from(fit.nakago, fit.nakago_guess, fit.ridge, true);

        find_machi(located.between(fit.machi_s_mm - 9, fit.machi_s_mm + 9), fit);
        if (fit.point) find_tip(located.between(fit.tip_s_mm - 14, fit.tip_s_mm + 5), fit);
        find_begin(located.all(), fit);
        if (pass == 0) {
            fit.turned_rad = lean_of(fit);
            refit_curve(fit, length);
        }
    }
    find_yokote(fit);
    fit_lines(fit);
    find_nakago_length(points, fit);
    return true;
}

}  // namespace togishi
