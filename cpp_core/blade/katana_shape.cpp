#include "blade/katana_shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace togishi {
namespace {

// How much of a taper happens near the machi (funbari): x -> x + amount x (1 - x)^2.
Dual taper(const Dual& from, const Dual& to, const Dual& x, double amount) {
    return lerp(from, to, x + Dual(amount) * x * (Dual(1) - x) * (Dual(1) - x));
}

// A conic arc from (0, start) to (1, 0), leaving with the given slope: a rational quadratic Bezier
// curve with its control point at x = reach and that weight. Near-circular for reach ~ 0.68, weight
// ~ 0.86.
Dual conic(const Dual& x, double start, double slope, double reach, double weight) {
    const double p = 2 * (1 - weight);
    const double q = 2 * reach * weight;
    const Dual a2 = Dual(p) * x + Dual(q - 1);
    const Dual minus_a1 = Dual(p) * x + Dual(q);
    const Dual t = Dual(2) * x / (minus_a1 + sqrt(minus_a1 * minus_a1 - Dual(4) * a2 * x));
    const Dual u = Dual(1) - t;
    const Dual middle = Dual(2 * weight) * t * u;
    return (u * u * Dual(start) + middle * Dual(start + slope * reach)) / (u * u + middle + t * t);
}

// From 0 to 1 on [0, 1]: its slope rises smoothly from 0 over the first part, then stays.
Dual eased_fall(const Dual& x) {
    constexpr double rise = 0.35;
    constexpr double slope = 1 / (1 - 0.5 * rise);
    if (x.v >= rise) return Dual(slope) * (x - Dual(0.5 * rise));
    const Dual z = x / Dual(rise);
    return Dual(slope * rise) * z * z * z * (Dual(1) - Dual(0.5) * z);
}

constexpr double fukura_weight = 0.86;
constexpr double width_funbari = 0.5;
constexpr double kasane_funbari = 0.25;
// Part of the shinogi's mean fall in the kissaki with which the ko-shinogi leaves the mitsukado.
constexpr double ko_shinogi_break = 0.6;

double clamp_reach(double reach) {
    return std::clamp(reach, 0.05, 0.9);
}

}  // namespace

KatanaShape::KatanaShape(const KatanaParameters& parameters)
    : p_((check_katana(parameters, "katana"), parameters)),
      line_(p_.nagasa_mm, p_.sori_mm, p_.sori_type, p_.nakago_mm) {
    // The kissaki's length is a straight line, the mune there an arc.
    const glm::dvec2 tip = line_.at(line_.blade_arc_mm()).position_mm;
    double arc = p_.kissaki_mm;
    for (int i = 0; i < 8; ++i) {
        arc *= p_.kissaki_mm / glm::distance(tip, line_.at(line_.blade_arc_mm() - arc).position_mm);
    }
    yokote_arc_mm_ = line_.blade_arc_mm() - arc;
    const double half = 0.5 * p_.motokasane_mm;
    iori_slope_ = p_.mune == MuneType::kaku ? 0 : p_.mune_height_mm / half;
    if (has_shinogi()) {
        shinogi_slope_ = p_.shinogi_rise_mm / (p_.moto_shinogi_haba_mm - iori_slope_ * half);
    }
    const double share = p_.nakago_jiri == Jiri::kiri ? 0.06 : 0.62;
    jiri_mm_ = share * p_.nakago_sakihaba_mm;
}

bool KatanaShape::has(Strip strip, Stretch stretch) const {
    if (strip == Strip::mune_top) return p_.mune == MuneType::mitsu;
    if (strip == Strip::shinogi_ji) return has_shinogi();
    if (strip == Strip::foot) return stretch <= Stretch::machi;
    return true;
}

std::array<double, 2> KatanaShape::range(Stretch stretch) const {
    switch (stretch) {
        case Stretch::jiri:
            return {0, 0.5 * std::numbers::pi};
        case Stretch::nakago:
            return {jiri_mm_ - line_.nakago_arc_mm(), -machi_ramp_mm};
        case Stretch::machi:
            return {-machi_ramp_mm, 0};
        case Stretch::blade:
            return {0, yokote_arc_mm_};
        case Stretch::kissaki:
            break;
    }
    return {yokote_arc_mm_, line_.blade_arc_mm()};
}

Dual KatanaShape::arc_mm(Stretch stretch, const Dual& q) const {
    if (stretch != Stretch::jiri) return q;
    return Dual(-line_.nakago_arc_mm()) + Dual(jiri_mm_) * (Dual(1) - cos(q));
}

void KatanaShape::finish_blade(Section& s, const Dual& corner_y) const {
    s.corner_y = corner_y;
    s.corner_d = Dual(iori_slope_) * corner_y;
    s.top_y = p_.mune == MuneType::mitsu ? Dual(0.4) * corner_y : Dual(0);
    if (has_shinogi()) {
        s.shinogi_y = s.corner_y + Dual(shinogi_slope_) * (s.shinogi_d - s.corner_d);
    } else {
        s.shinogi_y = s.corner_y;
        s.shinogi_d = s.corner_d;
    }
    s.ji_end_y = 0;
    s.ji_end_d = s.edge_d;
}

Section KatanaShape::blade_section(const Dual& arc) const {
    const Dual x = arc / Dual(yokote_arc_mm_);
    Section s;
    s.edge_d = taper(p_.motohaba_mm, p_.sakihaba_mm, x, width_funbari);
    s.shinogi_d = taper(p_.moto_shinogi_haba_mm, p_.saki_shinogi_haba_mm, x, width_funbari);
    finish_blade(s, taper(0.5 * p_.motokasane_mm, 0.5 * p_.sakikasane_mm, x, kasane_funbari));
    const double moto_ji = p_.motohaba_mm - (has_shinogi() ? p_.moto_shinogi_haba_mm : 0);
    s.niku = Dual(p_.niku_mm / moto_ji) * (s.edge_d - s.shinogi_d);
    // The nominal suguha keeps its share of the width.
    s.ha_fraction = Dual(1 - p_.ha_haba_mm / moto_ji);
    return s;
}

Section KatanaShape::kissaki_section(const Dual& arc) const {
    const double length = line_.blade_arc_mm() - yokote_arc_mm_;
    const Dual x = (arc - Dual(yokote_arc_mm_)) / Dual(length);
    const Section start = blade_section(Dual::along(yokote_arc_mm_));
    Section s;
    const double reach = clamp_reach(0.36 + 0.32 * p_.fukura);
    s.edge_d = conic(x, start.edge_d.v, start.edge_d.q * length, reach, fukura_weight);
    if (has_shinogi()) {
        const double fall =
            has_yokote() ? -ko_shinogi_break * start.shinogi_d.v : start.shinogi_d.q * length;
        s.shinogi_d = conic(x, start.shinogi_d.v, fall, 0.42, 1);
    }
    // The mune narrows to the point without a break at the yokote.
    const Dual corner = Dual(start.corner_y.v) * (Dual(1) - eased_fall(x)) +
                        Dual(start.corner_y.q * length) * x * (Dual(1) - x);
    finish_blade(s, corner);
    // The bulge falls from the yokote on, which sets the kissaki off against the ji across its
    // whole width.
    s.niku = conic(x, start.niku.v, has_yokote() ? -2.5 * start.niku.v : 0, 0.3, 1);
    s.ha_fraction = start.ha_fraction.v;
    return s;
}

Section KatanaShape::nakago_section(const Dual& arc) const {
    const Section machi = blade_section(Dual(0));
    const double length = line_.nakago_arc_mm() - jiri_mm_;
    const Dual x = -arc / Dual(length);
    const double width = p_.motohaba_mm - p_.mune_machi_mm - p_.ha_machi_mm;
    const double loss = width - p_.nakago_sakihaba_mm;
    // A little of the taper is taken from the back, most from the edge side.
    const Dual eased = x * (Dual(0.75) + Dual(0.25) * x);
    Section s;
    s.ridge_d = Dual(p_.mune_machi_mm) + Dual(0.2 * loss) * eased;
    const Dual width_here = Dual(width) - Dual(loss) * eased;
    s.edge_d = s.ridge_d + width_here;
    s.corner_y = taper(0.5 * p_.motokasane_mm, 0.5 * p_.nakago_sakikasane_mm, x, 0);
    s.corner_d = s.ridge_d + Dual(0.6 * iori_slope_) * s.corner_y;
    s.top_y = p_.mune == MuneType::mitsu ? Dual(0.4) * s.corner_y : Dual(0);
    const Dual foot_y = Dual(0.36) * s.corner_y;
    if (has_shinogi()) {
        const double share = (p_.moto_shinogi_haba_mm - p_.mune_machi_mm) / width;
        s.shinogi_d = s.ridge_d + Dual(share) * width_here;
        s.shinogi_y = s.corner_y + Dual(shinogi_slope_) * (s.shinogi_d - s.corner_d);
    } else {
        s.shinogi_d = s.corner_d;
        s.shinogi_y = s.corner_y;
    }
    s.ji_end_y = foot_y;
    s.ji_end_d = s.edge_d - Dual(0.35) * foot_y;
    s.niku = Dual(machi.niku.v);
    s.ha_fraction = machi.ha_fraction;
    return s;
}

Section KatanaShape::jiri_section(const Dual& q) const {
    const Dual arc = arc_mm(Stretch::jiri, q);
    Section s = nakago_section(arc);
    // Back and foot close on one line across the thickness: depths shrink towards it as sin q.
    double centre_share = 0.45;
    if (p_.nakago_jiri == Jiri::haagari) centre_share = 0.22;
    const Dual centre = lerp(s.ridge_d, s.edge_d, centre_share);
    const Dual shrink = sin(q);
    // Across the end line the back and the foot have one thickness and no roof.
    const Dual merge = cos(q) * cos(q);
    const Dual end_y = Dual(0.8) * s.corner_y;
    for (Dual* d : {&s.ridge_d, &s.corner_d, &s.shinogi_d, &s.ji_end_d, &s.edge_d}) {
        *d = centre + (*d - centre) * shrink;
    }
    for (Dual* y : {&s.corner_y, &s.shinogi_y, &s.ji_end_y}) *y = lerp(*y, end_y, merge);
    s.top_y = lerp(s.top_y, Dual(0.4) * end_y, p_.mune == MuneType::mitsu ? merge : Dual(0));
    s.niku = s.niku * shrink * shrink;
    return s;
}

Section KatanaShape::section(Stretch stretch, const Dual& q) const {
    switch (stretch) {
        case Stretch::jiri:
            return jiri_section(q);
        case Stretch::nakago:
            return nakago_section(q);
        case Stretch::blade:
            return blade_section(q);
        case Stretch::kissaki:
            return kissaki_section(q);
        case Stretch::machi:
            break;
    }
    const Dual x = (q + Dual(machi_ramp_mm)) / Dual(machi_ramp_mm);
    const Section a = nakago_section(Dual(-machi_ramp_mm));
    const Section b = blade_section(Dual(0));
    Section s;
    s.ridge_d = lerp(a.ridge_d, b.ridge_d, x);
    s.top_y = lerp(a.top_y, b.top_y, x);
    s.corner_y = lerp(a.corner_y, b.corner_y, x);
    s.corner_d = lerp(a.corner_d, b.corner_d, x);
    s.shinogi_y = lerp(a.shinogi_y, b.shinogi_y, x);
    s.shinogi_d = lerp(a.shinogi_d, b.shinogi_d, x);
    s.ji_end_y = lerp(a.ji_end_y, b.ji_end_y, x);
    s.ji_end_d = lerp(a.ji_end_d, b.ji_end_d, x);
    s.edge_d = lerp(a.edge_d, b.edge_d, x);
    s.niku = lerp(a.niku, b.niku, x);
    s.ha_fraction = b.ha_fraction;
    return s;
}

void KatanaShape::point_in_strip(const Section& s, Strip strip, MuneType mune, const Dual& f,
                                 Dual& y, Dual& d) {
    switch (strip) {
        case Strip::mune_top:
            y = s.top_y * f;
            d = s.ridge_d;
            return;
        case Strip::mune_side:
            if (mune == MuneType::maru) {
                // A circular arc over the chord 2 corner_y of height h.
                const Dual h = s.corner_d - s.ridge_d;
                const Dual half = Dual(2) * atan(h / s.corner_y);
                const Dual radius = (s.corner_y * s.corner_y + h * h) / (Dual(2) * h);
                y = radius * sin(half * f);
                d = s.ridge_d + radius * (Dual(1) - cos(half * f));
                return;
            }
            y = lerp(s.top_y, s.corner_y, f);
            d = lerp(s.ridge_d, s.corner_d, f);
            return;
        case Strip::shinogi_ji:
            y = lerp(s.corner_y, s.shinogi_y, f);
            d = lerp(s.corner_d, s.shinogi_d, f);
            return;
        case Strip::ji:
        case Strip::ha: {
            const Dual g = strip == Strip::ji ? s.ha_fraction * f : lerp(s.ha_fraction, 1, f);
            y = lerp(s.shinogi_y, s.ji_end_y, g) + Dual(4) * s.niku * g * (Dual(1) - g);
            d = lerp(s.shinogi_d, s.ji_end_d, g);
            return;
        }
        case Strip::foot:
            y = lerp(s.ji_end_y, 0, f);
            d = lerp(s.ji_end_d, s.edge_d, f);
            return;
    }
}

double KatanaShape::developed_mm(const Section& s, Strip strip, MuneType mune, double f) {
    if (strip == Strip::mune_side && mune == MuneType::maru) {
        const double h = s.corner_d.v - s.ridge_d.v;
        if (!(h > 0)) return f * s.corner_y.v;
        const double half = 2 * std::atan(h / s.corner_y.v);
        return half * f * (s.corner_y.v * s.corner_y.v + h * h) / (2 * h);
    }
    // Straight or a shallow parabola: five Gauss points are exact to 1e-12 of the length.
    constexpr std::array<double, 5> x{-0.9061798459386640, -0.5384693101056831, 0,
                                      0.5384693101056831, 0.9061798459386640};
    constexpr std::array<double, 5> w{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                      0.4786286704993665, 0.2369268850561891};
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
        Dual y;
        Dual d;
        point_in_strip(s, strip, mune, Dual::across(0.5 * f * (1 + x[k])), y, d);
        sum += 0.5 * f * w[k] * std::hypot(y.f, d.f);
    }
    return sum;
}

KatanaShape::Row KatanaShape::row(Stretch stretch, double q) const {
    Row r;
    r.arc = arc_mm(stretch, Dual::along(q));
    r.arc_mm = r.arc.v;
    r.section = section(stretch, Dual::along(q));
    r.line = line_.at(r.arc.v);
    r.mune = p_.mune;
    return r;
}

SurfacePoint KatanaShape::Row::at(Strip strip, double f) const {
    Dual y;
    Dual d;
    point_in_strip(section, strip, mune, Dual::across(f), y, d);
    const glm::dvec3 t(line.tangent.x, 0, line.tangent.y);
    const glm::dvec3 up(-line.tangent.y, 0, line.tangent.x);
    const glm::dvec3 out(0, 1, 0);
    SurfacePoint p;
    p.position_mm = glm::dvec3(line.position_mm.x, 0, line.position_mm.y) + y.v * out - d.v * up;
    p.along = t * ((1 + line.curvature_per_mm * d.v) * arc.q) + y.q * out - d.q * up;
    p.across = y.f * out - d.f * up;
    const glm::dvec3 n = glm::cross(p.along, p.across);
    p.normal = n / glm::length(n);
    return p;
}

}  // namespace togishi
