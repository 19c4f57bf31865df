#include "steel/hamon_line.hpp"

#include <algorithm>
#include <cmath>

#include "steel/noise.hpp"
#include "steel/random_stream.hpp"

namespace togishi {
namespace {

// Purposes of the random streams and noises of this file.
enum Purpose : std::uint64_t { p_crests = 11, p_strips = 12, p_base = 13, p_leaves = 14 };

/// Everything that drawing one side needs.
class Drawing {
  public:
    Drawing(const SteelOutline& outline, const SteelParameters& p, bool omote)
        : outline_(outline),
          p_(p),
          crests_(p.seed, p_crests, omote, p.asymmetry),
          strips_(p.seed, p_strips, omote, std::max(p.asymmetry, 0.3)),
          leaves_(p.seed * 2 + (omote ? 0 : 1), p_leaves),
          seed_(static_cast<std::uint32_t>(p.seed * 0x9E3779B1U)),
          side_seed_(seed_ + (omote ? 77U : 1077U)) {}

    HamonLine draw() {
        set_base();
        switch (p_.hamon) {
            case HamonStyle::suguha:
                draw_suguha();
                break;
            case HamonStyle::notare:
                draw_notare();
                break;
            case HamonStyle::gunome:
                draw_gunome();
                break;
            case HamonStyle::choji:
                draw_choji(1.0);
                break;
            case HamonStyle::ko_choji:
                draw_choji(0.6);
                break;
            case HamonStyle::midare:
                draw_midare();
                break;
        }
        draw_leaves();
        const auto by_s = [](const auto& a, const auto& b) { return position(a) < position(b); };
        std::stable_sort(line_.crests.begin(), line_.crests.end(), by_s);
        std::stable_sort(line_.strips.begin(), line_.strips.end(), by_s);
        return std::move(line_);
    }

  private:
    static double position(const HamonCrest& c) { return c.s; }
    static double position(const ClayStrip& c) { return c.s0; }

    /// Correlated between the sides like SideStream's numbers.
    [[nodiscard]] double side_noise(double x, std::uint32_t k) const {
        return std::sqrt(1.0 - p_.asymmetry) * noise_1d(x, seed_ + k) +
               std::sqrt(p_.asymmetry) * noise_1d(x, side_seed_ + k);
    }
    [[nodiscard]] double share(double s) const { return wave_share(outline_, p_, s); }
    [[nodiscard]] double calm(double s) const { return calm_height(outline_, p_, s); }
    [[nodiscard]] double end() const { return outline_.kissaki_s() + 2.0; }
    /// Waves are as high as the blade is wide.
    [[nodiscard]] double amplitude(double mm, double s) const {
        return mm * p_.hamon_amplitude * std::sqrt(std::max(0.05, outline_.relative_width(s)));
    }

    void set_base() {
        // Per style: where the base line runs against the mean height, and how it wanders.
        double drop = 0;
        double slow = 0.25;
        double quick = 0.08;
        switch (p_.hamon) {
            case HamonStyle::suguha:
                slow = 0.22;
                quick = 0.09;
                break;
            case HamonStyle::notare:
                slow = 0.3;
                quick = 0.12;
                break;
            case HamonStyle::gunome:
                drop = 1.7;
                slow = 0.35;
                break;
            case HamonStyle::choji:
                drop = 3.0;
                slow = 0.4;
                break;
            case HamonStyle::ko_choji:
                drop = 1.6;
                slow = 0.4;
                break;
            case HamonStyle::midare:
                drop = 2.1;
                slow = 0.6;
                break;
        }
        const double scale = p_.hamon_scale;
        const auto count =
            static_cast<std::size_t>(outline_.nagasa() / HamonLine::base_step_mm) + 2;
        line_.base.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const double s = static_cast<double>(i) * HamonLine::base_step_mm;
            const double wander = slow * side_noise(s / (55.0 * scale), 1) +
                                  quick * side_noise(s / (11.0 * scale), 2);
            const double q = calm(s) + share(s) * amplitude(wander - drop, s);
            line_.base[i] = std::max(q, 0.25 * calm(s));
        }
    }

    void add_leg(double s, double top_q, double depth, double half_width, double strength,
                 double lean) {
        ClayStrip strip;
        strip.s0 = s;
        strip.q0 = top_q + 0.4;
        strip.s1 = s + lean;
        strip.q1 = std::max(0.8, top_q - depth);
        strip.half_width = half_width;
        strip.strength = strength;
        if (strip.q0 > strip.q1 + 0.5) line_.strips.push_back(strip);
    }

    /// A leg under a valley, present with the chance that the parameter asks for.
    /// Where crests may close over it, it is drawn lightly, so that it stays mist and leaves no
    /// hole.
    void maybe_leg(double s, double top_q, double reach, double lightly = 1.0) {
        const bool present = strips_.common_uniform() < 0.25 + 0.75 * p_.ashi;
        const double depth = top_q * std::clamp(reach + 0.16 * strips_.normal(), 0.12, 0.85);
        const double half = std::clamp(0.33 + 0.08 * strips_.normal(), 0.15, 0.6);
        const double strength = std::clamp(0.72 + 0.14 * strips_.normal(), 0.35, 0.95) * lightly;
        const double lean = 0.35 * strips_.normal();
        if (present && p_.ashi > 0.0)
            add_leg(s, top_q, depth, half, strength * std::min(1.0, 0.4 + p_.ashi), lean);
    }

    void draw_suguha() {
        // Small legs (ko-ashi), in loose groups.
        for (double s = 12.0; s < end();) {
            s += (2.6 + 2.2 * strips_.common_uniform()) * p_.hamon_scale;
            const double crowd = side_noise(s / 38.0, 5);
            if (crowd < -0.1) continue;
            maybe_leg(s, line_.base_at(s) - 0.15, 0.28);
        }
    }

    void draw_notare() {
        // Long waves of unequal length and height; the line between two turning points is a cosine.
        struct Turn {
            double s;
            double height;
        };
        std::vector<Turn> turns{{-20.0, 0.0}};
        double side = 1.0;
        while (turns.back().s < outline_.nagasa() + 60.0) {
            const double half = 25.0 * p_.hamon_scale * std::exp(0.28 * crests_.common_normal());
            const double height = side * (0.75 + 0.35 * crests_.normal());
            turns.push_back(
                {turns.back().s + half + 2.5 * p_.hamon_scale * p_.asymmetry * crests_.normal(),
                 height});
            side = -side;
        }
        std::size_t k = 0;
        for (std::size_t i = 0; i < line_.base.size(); ++i) {
            const double s = static_cast<double>(i) * HamonLine::base_step_mm;
            while (k + 2 < turns.size() && turns[k + 1].s < s) ++k;
            const double t =
                std::clamp((s - turns[k].s) / std::max(turns[k + 1].s - turns[k].s, 1.0), 0.0, 1.0);
            const double wave = std::lerp(turns[k].height, turns[k + 1].height,
                                          0.5 - 0.5 * std::cos(3.14159265358979 * t));
            line_.base[i] =
                std::max(line_.base[i] + share(s) * amplitude(1.9 * wave, s), 0.25 * calm(s));
        }
        for (double s = 14.0; s < end();) {
            s += (3.4 + 4.5 * strips_.common_uniform()) * p_.hamon_scale;
            maybe_leg(s, line_.base_at(s) - 0.15, 0.33);
        }
    }

    void add_arch(double s0, double s1, double high) {
        if (high < 0.1 || s1 - s0 < 0.1) return;  // calm line
        const double s = 0.5 * (s0 + s1);
        HamonCrest c;
        c.kind = HamonCrest::Kind::arch;
        c.s = s;
        c.foot_q = line_.base_at(s) - 0.25 * high;
        c.head_q = c.foot_q;
        c.head_half = 0.5 * (s1 - s0) * 1.04;
        c.head_high = 1.25 * high;
        c.neck_half = c.head_half;
        c.lean = 0.05 * (s1 - s0) * crests_.normal();
        line_.crests.push_back(c);
    }

    void draw_gunome() {
        double s0 = 4.0;
        while (s0 < end()) {
            const double pitch = 9.6 * p_.hamon_scale * std::exp(0.24 * crests_.common_normal());
            const double own = 0.16 * pitch * crests_.normal() * p_.asymmetry;
            const double s1 = s0 + pitch + own;
            const double middle = 0.5 * (s0 + s1);
            const double slow = 1.0 + 0.2 * side_noise(middle / (70.0 * p_.hamon_scale), 3);
            const double high = share(middle) * amplitude(3.1, middle) * slow *
                                std::exp(0.2 * crests_.normal()) *
                                std::sqrt(pitch / (9.6 * p_.hamon_scale));
            const double pick = crests_.common_uniform();
            if (pick < 0.2) {
                // Two crests grown into one another: the second smaller.
                const double split = s0 + (0.52 + 0.1 * crests_.common_uniform()) * (s1 - s0);
                add_arch(s0, split + 0.12 * pitch, high);
                add_arch(split - 0.05 * pitch, s1, high * 0.7);
                maybe_leg(split, line_.base_at(split) + 0.35 * high, 0.3, 0.65);
            } else if (pick < 0.28) {
                add_arch(s0, s1, high * 0.45);
            } else {
                add_arch(s0, s1, high);
            }
            maybe_leg(s1, line_.base_at(s1), 0.5);
            s0 = s1 + 0.06 * pitch * crests_.common_uniform();
        }
    }

    void add_clove(double s, double high, double half, double neck, double lean) {
        if (high < 0.35 || half < 0.1) return;  // calm line
        HamonCrest c;
        c.kind = HamonCrest::Kind::clove;
        c.s = s;
        c.foot_q = line_.base_at(s) - 0.4;
        c.head_half = half;
        c.head_high = half * 0.92;
        c.head_q = c.foot_q + 0.4 + std::max(high - c.head_high, 0.1);
        c.neck_half = neck;
        c.lean = lean;
        line_.crests.push_back(c);
    }

    void draw_choji(double size) {
        const double scale = p_.hamon_scale * size;
        double s = 5.0;
        while (s < end()) {
            // A cluster: cloves side by side on a low swell, its middle higher than its flanks.
            const double count = std::floor(3.0 + 5.0 * crests_.common_uniform());
            const double rise = 0.8 + 0.4 * crests_.common_uniform();
            const double tilt = 0.25 * crests_.normal();
            const double lean = 0.1 * crests_.normal();
            const bool tall_first = crests_.common_uniform() < 0.5;
            const double start = s;
            for (double k = 0; k < count && s < end(); k += 1) {
                const bool tall = (std::fmod(k, 2.0) < 0.5) == tall_first;
                const double pitch =
                    (tall ? 4.3 : 3.5) * scale * std::exp(0.2 * crests_.common_normal());
                const double middle =
                    s + 0.5 * pitch + 0.3 * scale * crests_.normal() * p_.asymmetry;
                const double across = count > 1.0 ? 2.0 * k / (count - 1.0) - 1.0 : 0.0;
                const double arch = rise * (1.0 - 0.3 * across * across) + 0.2 * tilt * across;
                const double high = share(middle) * amplitude(5.0 * size, middle) * arch *
                                    (tall ? 1.0 : 0.74) * std::exp(0.14 * crests_.normal());
                const double half = pitch * (0.46 + 0.035 * crests_.normal());
                const double head = std::min(half, 0.3 + 0.5 * high);
                add_clove(middle, std::max(high, 0.3), head, 0.6 * head,
                          (lean + 0.1 * crests_.normal()) * pitch);
                if (crests_.common_uniform() < 0.28) {
                    // A bud on the shoulder.
                    const double side = crests_.common_uniform() < 0.5 ? -1.0 : 1.0;
                    add_clove(middle + side * 0.3 * pitch, 0.7 * high, 0.55 * head, 0.45 * head,
                              side * 0.14 * pitch);
                }
                s += pitch;
                maybe_leg(s, line_.base_at(s) + 0.3 * high, 0.5, 0.65);
            }
            const double middle = 0.5 * (start + s);
            HamonCrest swell;
            swell.s = middle;
            swell.foot_q = swell.head_q = line_.base_at(middle) - 1.0;
            swell.head_half = swell.neck_half = 0.5 * (s - start) + 0.6 * scale;
            swell.head_high = 1.0 + share(middle) * amplitude(1.1 * size * rise, middle);
            line_.crests.push_back(swell);
            const double gap = 1.6 * crests_.common_uniform() * scale;
            maybe_leg(s + 0.5 * gap, line_.base_at(s), 0.6);
            s += gap;
        }
    }

    void draw_midare() {
        double s = 4.0;
        while (s < end()) {
            const double pitch = 7.0 * p_.hamon_scale * std::exp(0.42 * crests_.common_normal());
            const double middle = s + 0.5 * pitch + 0.15 * pitch * crests_.normal() * p_.asymmetry;
            const double high =
                share(middle) * amplitude(3.6, middle) * std::exp(0.3 * crests_.normal());
            const double pick = crests_.common_uniform();
            if (pick < 0.42) {
                add_arch(middle - 0.5 * pitch, middle + 0.5 * pitch, high);
            } else if (pick < 0.68) {
                add_clove(middle, 1.2 * high, std::min(0.42 * pitch, 0.3 + 0.7 * high),
                          0.24 * pitch, 0.1 * pitch * crests_.normal());
                maybe_leg(middle + 0.4 * pitch, line_.base_at(middle), 0.5);
            } else if (pick < 0.86) {
                HamonCrest c;
                c.kind = HamonCrest::Kind::point;
                c.s = middle;
                c.foot_q = line_.base_at(middle) - 0.4;
                c.head_half = c.head_high = 0.28;
                c.head_q = c.foot_q + 0.4 + 1.25 * high;
                c.neck_half = 0.42 * pitch;
                c.lean = 0.12 * pitch * crests_.normal();
                line_.crests.push_back(c);
            }
            if (crests_.common_uniform() < 0.1 && high > 0.4) {
                HamonCrest c;
                c.kind = HamonCrest::Kind::island;
                c.s = middle;
                c.head_half = (0.35 + 0.5 * crests_.common_uniform()) * std::min(1.0, high);
                c.head_high = 0.7 * c.head_half;
                c.head_q = c.foot_q = line_.base_at(middle) + 1.3 * high + 2.0;
                line_.crests.push_back(c);
            }
            s += pitch;
            maybe_leg(s, line_.base_at(s), 0.5);
        }
    }

    void draw_leaves() {
        if (p_.yo <= 0.0) return;
        for (double s = 15.0; s < end();) {
            s += (2.0 + 7.0 * leaves_.uniform()) / (0.3 + p_.yo);
            const double top = line_.base_at(s);
            ClayStrip leaf;
            leaf.s0 = s;
            leaf.q0 = top * (0.35 + 0.5 * leaves_.uniform());
            leaf.s1 = s + 0.5 * leaves_.normal();
            leaf.q1 = leaf.q0 - 0.3 - 0.6 * leaves_.uniform();
            leaf.half_width = 0.2 + 0.16 * leaves_.uniform();
            leaf.strength = (0.35 + 0.5 * leaves_.uniform()) * std::min(1.0, 0.4 + p_.yo);
            if (leaf.q1 > 1.0) line_.strips.push_back(leaf);
        }
    }

    const SteelOutline& outline_;
    const SteelParameters& p_;
    SideStream crests_;
    SideStream strips_;
    RandomStream leaves_;
    std::uint32_t seed_;
    std::uint32_t side_seed_;
    HamonLine line_;
};

}  // namespace

double HamonLine::base_at(double s) const {
    const double last = static_cast<double>(base.size() - 1);
    const double x = std::clamp(s / base_step_mm, 0.0, last);
    const auto i = std::min(static_cast<std::size_t>(x), base.size() - 2);
    return std::lerp(base[i], base[i + 1], x - static_cast<double>(i));
}

double wave_share(const SteelOutline& outline, const SteelParameters& p, double s) {
    const double grown = smooth_step(0.35 * p.yakidashi_mm, p.yakidashi_mm + 6.0, s);
    const double before = outline.kissaki_s() - s;
    return grown * (0.55 + 0.45 * smooth_step(0.0, 18.0, before));
}

double calm_height(const SteelOutline& outline, const SteelParameters& p, double s) {
    const double rise = 1.0 - std::pow(1.0 - std::clamp(s / 9.0, 0.0, 1.0), 3.0);
    const double start = 0.82 + 0.18 * smooth_step(0.4 * p.yakidashi_mm, p.yakidashi_mm + 8.0, s);
    const double width = std::max(0.05, outline.relative_width(s));
    const double wanted = p.hamon_height_mm * std::pow(width, 0.75);
    const double room =
        0.85 *
        std::max(outline.straight_edge(s) - outline.mune(std::min(s, outline.kissaki_s())), 0.5);
    return std::min(wanted, room) * rise * start;
}

HamonLine draw_hamon(const SteelOutline& outline, const SteelParameters& p, bool omote) {
    return Drawing(outline, p, omote).draw();
}

}  // namespace togishi
