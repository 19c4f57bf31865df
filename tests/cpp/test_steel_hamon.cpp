// The hamon, the boshi and the hadori: what tells the styles apart, how they begin and end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "blade/katana_frame.hpp"
#include "steel/hadori.hpp"
#include "steel/quench.hpp"

namespace togishi {
namespace {

const BladeFrame& katana_frame() {
    static const BladeFrame frame = make_blade_frame(katana_defaults("shinogi"));
    return frame;
}

/// The same point on a short blade: quicker to quench.
const BladeFrame& short_frame() {
    static const BladeFrame frame = [] {
        KatanaParameters k = katana_defaults("shinogi");
        k.nagasa_mm = 240;
        k.sori_mm = 5;
        k.nakago_mm = 95;
        k.mekugi_ana_from_machi_mm = 45;
        return make_blade_frame(k);
    }();
    return frame;
}

struct Hardened {
    SteelParameters p;
    SteelOutline outline;
    QuenchedSide side;

    explicit Hardened(const SteelParameters& chosen, bool omote = true,
                      const BladeFrame& frame = katana_frame())
        : p(chosen), outline(frame), side(harden(omote)) {}

    [[nodiscard]] QuenchedSide harden(bool omote) const {
        const HamonLine line = draw_hamon(outline, p, omote);
        const Boshi boshi(outline, p, omote, 0);
        return quench(outline, p, lay_clay(outline, p, line, boshi, omote, 0), 0);
    }

    /// Heights of the hamon's crest against the calm line, every quarter of a millimetre of the
    /// body.
    [[nodiscard]] std::vector<double> waves(double from, double to) const {
        std::vector<double> result;
        for (double s = from; s < to; s += 0.25) {
            result.push_back(side.crest_at(s) - calm_height(outline, p, s));
        }
        return result;
    }
    [[nodiscard]] std::vector<double> waves() const {
        return waves(70.0, outline.kissaki_s() - 25.0);
    }

    /// How often the ji is met again above hardened steel, per 100 mm: necks and legs.
    [[nodiscard]] double overhangs() const {
        double found = 0;
        double columns = 0;
        for (double s = 70.0; s < outline.kissaki_s() - 25.0; s += 0.25, columns += 1) {
            int crossings = 0;
            bool inside = true;
            for (double q = 1.0; q < 20.0; q += 0.1) {
                const bool now = side.depth_mm.sample(s, q).value > 0.0F;
                if (now != inside) ++crossings;
                inside = now;
            }
            if (crossings > 1) found += 1;
        }
        return found / columns;
    }
};

SteelParameters style(HamonStyle hamon, std::uint64_t seed = 1) {
    SteelParameters p;
    p.hamon = hamon;
    p.seed = seed;
    return p;
}

double mean(const std::vector<double>& x) {
    double sum = 0;
    for (const double v : x) sum += v;
    return sum / static_cast<double>(x.size());
}
double deviation(const std::vector<double>& x) {
    const double m = mean(x);
    double sum = 0;
    for (const double v : x) sum += (v - m) * (v - m);
    return std::sqrt(sum / static_cast<double>(x.size()));
}
double correlation(const std::vector<double>& a, const std::vector<double>& b,
                   std::size_t lag = 0) {
    const double ma = mean(a);
    const double mb = mean(b);
    double sum = 0;
    for (std::size_t i = 0; i + lag < a.size(); ++i) sum += (a[i] - ma) * (b[i + lag] - mb);
    return sum / static_cast<double>(a.size() - lag) / (deviation(a) * deviation(b));
}
/// Upward crossings of the mean per 100 mm, with a dead band, so that only waves count.
double waves_per_100_mm(const std::vector<double>& x) {
    const double m = mean(x);
    const double band = 0.25 * deviation(x);
    int count = 0;
    bool high = false;
    for (const double v : x) {
        if (!high && v > m + band) {
            high = true;
            ++count;
        } else if (high && v < m - band) {
            high = false;
        }
    }
    return 100.0 * count / (0.25 * static_cast<double>(x.size()));
}

/// Crests that stand at least `prominence` mm over the valleys beside them, per 100 mm.
double crests_per_100_mm(const std::vector<double>& x, double prominence) {
    int count = 0;
    bool rising = true;
    double extreme = x.front();
    for (const double v : x) {
        if (rising) {
            extreme = std::max(extreme, v);
            if (v < extreme - prominence) {
                ++count;
                rising = false;
                extreme = v;
            }
        } else {
            extreme = std::min(extreme, v);
            if (v > extreme + prominence) {
                rising = true;
                extreme = v;
            }
        }
    }
    return 100.0 * count / (0.25 * static_cast<double>(x.size()));
}

TEST(SteelHamon, StylesDifferInHeightAndWavelength) {
    for (const std::uint64_t seed : {1U, 3U}) {
        // Without legs, which cut the crests' line.
        const auto plain = [&](HamonStyle s) {
            SteelParameters p = style(s, seed);
            p.ashi = 0.0;
            p.yo = 0.0;
            return Hardened(p);
        };
        const Hardened suguha(plain(HamonStyle::suguha));
        const Hardened notare(plain(HamonStyle::notare));
        const Hardened gunome(plain(HamonStyle::gunome));
        const Hardened choji(plain(HamonStyle::choji));
        const Hardened ko_choji(plain(HamonStyle::ko_choji));
        const Hardened midare(plain(HamonStyle::midare));
        EXPECT_LT(deviation(suguha.waves()), 0.5);
        for (const Hardened* h : {&notare, &gunome, &choji, &midare}) {
            EXPECT_GT(deviation(h->waves()), 1.6 * deviation(suguha.waves()));
            EXPECT_LT(deviation(h->waves()), 3.0);
        }
        const double long_waves = waves_per_100_mm(notare.waves());
        const double arches = crests_per_100_mm(gunome.waves(), 0.5);
        const double cloves = crests_per_100_mm(choji.waves(), 0.5);
        EXPECT_GT(long_waves, 0.8);
        EXPECT_LT(long_waves, 3.5);
        EXPECT_GT(arches, 5.0);
        EXPECT_LT(arches, 13.0);
        EXPECT_GT(cloves, 1.3 * arches);
        EXPECT_GT(crests_per_100_mm(ko_choji.waves(), 0.25),
                  1.1 * crests_per_100_mm(choji.waves(), 0.25));
        // Only cloves have necks.
        EXPECT_GT(choji.overhangs(), 2.0 * gunome.overhangs());
        EXPECT_LT(deviation(ko_choji.waves()), deviation(choji.waves()));
        // The mean height is what was asked for, whatever the style.
        for (const Hardened* h : {&suguha, &notare, &gunome, &choji, &midare}) {
            EXPECT_NEAR(mean(h->waves()), 0.0, 1.6);
        }
    }
}

TEST(SteelHamon, ParametersSetHeightAmplitudeAndWavelength) {
    SteelParameters p = style(HamonStyle::gunome);
    const Hardened plain(p);
    p.hamon_height_mm = 11.0;
    const Hardened tall(p);
    EXPECT_GT(tall.side.crest_at(300.0), plain.side.crest_at(300.0) + 1.5);
    p = style(HamonStyle::gunome);
    p.hamon_amplitude = 0.0;
    EXPECT_LT(deviation(Hardened(p).waves()), 0.3);
    p = style(HamonStyle::gunome);
    p.hamon_scale = 2.0;
    EXPECT_LT(waves_per_100_mm(Hardened(p).waves()), 0.7 * waves_per_100_mm(plain.waves()));
}

TEST(SteelHamon, SidesAreRelatedButNotEqual) {
    for (const HamonStyle s : {HamonStyle::notare, HamonStyle::gunome, HamonStyle::choji}) {
        SteelParameters p = style(s);
        const double usual = correlation(Hardened(p, true).waves(), Hardened(p, false).waves());
        EXPECT_GT(usual, 0.2);
        EXPECT_LT(usual, 0.985);
        p.asymmetry = 0.0;
        EXPECT_GT(correlation(Hardened(p, true).waves(), Hardened(p, false).waves()), 0.9);
    }
}

TEST(SteelHamon, DoesNotRepeatAlongTheBlade) {
    for (const HamonStyle s : {HamonStyle::notare, HamonStyle::gunome, HamonStyle::choji}) {
        std::vector<double> mean_correlation(1600);
        constexpr int seeds = 3;
        for (int seed = 1; seed <= seeds; ++seed) {
            const std::vector<double> waves = Hardened(style(s, seed)).waves();
            for (std::size_t lag = 600; lag < mean_correlation.size(); ++lag) {
                const double c = correlation(waves, waves, lag);
                // One blade alone is short against a notare's waves; a copy would give 1.
                EXPECT_LT(c, 0.8) << static_cast<double>(lag) * 0.25;
                mean_correlation[lag] += c / seeds;
            }
        }
        for (std::size_t lag = 600; lag < mean_correlation.size(); ++lag) {
            EXPECT_LT(std::abs(mean_correlation[lag]), 0.6)
                << static_cast<double>(lag) * 0.25 << " mm";
        }
    }
}

TEST(SteelHamon, RisesFromTheEdgeAtTheMachiAndStartsCalm) {
    SteelParameters p = style(HamonStyle::choji);
    p.yakidashi_mm = 45.0;
    const Hardened h(p);
    EXPECT_LT(h.side.crest_at(0.0), 1.5);
    EXPECT_GT(h.side.crest_at(14.0), 3.0);
    EXPECT_LT(deviation(h.waves(15.0, 28.0)), 0.5 * deviation(h.waves()));
}

TEST(SteelHamon, SlopesSoftenTheLineWhereTheClayDoes) {
    // In a leg the rate is near the critical one: the steel counts as close to the line, though
    // deep in the ha.
    SteelParameters p = style(HamonStyle::suguha);
    const auto near_line = [](const Hardened& h) {
        double count = 0;
        for (double s = 100; s < 600; s += 0.25) {
            if (h.side.depth_mm.sample(s, 0.72 * calm_height(h.outline, h.p, s)).value < 0.9F)
                count += 1;
        }
        return count;
    };
    p.ashi = 0.0;
    p.yo = 0.0;
    const double none = near_line(Hardened(p));
    p.ashi = 1.0;
    p.yo = 1.0;
    EXPECT_GT(near_line(Hardened(p)), none + 20.0);
}

TEST(SteelBoshi, JoinsTheHamonAtTheYokote) {
    for (const HamonStyle s :
         {HamonStyle::suguha, HamonStyle::notare, HamonStyle::gunome, HamonStyle::choji}) {
        for (const std::uint64_t seed : {1U, 5U}) {
            const Hardened h(style(s, seed), true, short_frame());
            const double yokote = h.outline.kissaki_s();
            double last = h.side.crest_at(yokote - 2.0);
            for (double t = yokote - 2.0; t < yokote + 3.0; t += 0.125) {
                EXPECT_NEAR(h.side.crest_at(t), last, 0.6) << t - yokote;
                last = h.side.crest_at(t);
            }
            EXPECT_GT(last, 2.0);
        }
    }
}

/// Where the ji ends in the kissaki, and where the turn-back ends on the mune's corner; measured on
/// the steel.
struct MeasuredBoshi {
    double top_s = 0;
    double end_s = 0;
};
MeasuredBoshi measure(const Hardened& h) {
    MeasuredBoshi m;
    const auto depth = [&](double s, double r) {
        return h.side.depth_mm.sample(s, h.outline.straight_edge(s) - r).value;
    };
    const double tip = h.outline.nagasa();
    for (double s = h.outline.kissaki_s(); s < tip; s += 0.1) {
        for (double r = h.outline.mune(s); r < h.outline.edge(s); r += 0.2) {
            if (depth(s, r) < 0.0F) m.top_s = s;
        }
    }
    m.end_s = tip;
    for (double s = tip - 2.0; s > 0.0 && depth(s, h.outline.mune(s)) > 0.0F; s -= 0.1) m.end_s = s;
    return m;
}

TEST(SteelBoshi, TurnsBackByTheLengthStated) {
    for (const double kaeri : {4.0, 7.0, 15.0}) {
        for (const BoshiStyle b :
             {BoshiStyle::komaru, BoshiStyle::omaru, BoshiStyle::midare_komi}) {
            SteelParameters p = style(HamonStyle::gunome);
            p.boshi = b;
            p.boshi_kaeri_mm = kaeri;
            const MeasuredBoshi m = measure(Hardened(p, true, short_frame()));
            EXPECT_NEAR(m.top_s - m.end_s, kaeri, 1.0);
        }
    }
}

TEST(SteelBoshi, OmaruIsRounderThanKomaruAndYakizumeDoesNotTurn) {
    SteelParameters p = style(HamonStyle::suguha);
    p.boshi = BoshiStyle::komaru;
    const MeasuredBoshi komaru = measure(Hardened(p, true, short_frame()));
    p.boshi = BoshiStyle::omaru;
    const MeasuredBoshi omaru = measure(Hardened(p, true, short_frame()));
    p.boshi = BoshiStyle::yakizume;
    const MeasuredBoshi yakizume = measure(Hardened(p, true, short_frame()));
    EXPECT_LT(omaru.top_s, komaru.top_s - 1.0);
    EXPECT_GT(yakizume.top_s, komaru.top_s);
    EXPECT_LT(yakizume.top_s - yakizume.end_s, 1.5);
}

TEST(SteelHadori, CoversTheCrestsAndIsSmootherThanThey) {
    for (const HamonStyle s : {HamonStyle::suguha, HamonStyle::notare, HamonStyle::gunome,
                               HamonStyle::choji, HamonStyle::midare}) {
        const Hardened h(style(s));
        const Hadori hadori(h.outline, h.p, h.side, true);
        double way_hamon = 0;
        double way_hadori = 0;
        for (double t = 5.0; t < h.outline.kissaki_s() - 1.0; t += 0.125) {
            const double crest = h.side.crest_at(t);
            EXPECT_GE(hadori.outline_q(t), crest - 1e-6) << t;
            EXPECT_GE(hadori.mask(t, crest), 0.5F) << t;
            EXPECT_GE(hadori.mask(t, 0.5 * crest), hadori.mask(t, crest)) << t;
            EXPECT_EQ(hadori.mask(t, hadori.outline_q(t) + h.p.hadori_softness_mm), 0.0F);
            way_hamon += std::abs(h.side.crest_at(t + 0.125) - crest);
            way_hadori += std::abs(hadori.outline_q(t + 0.125) - hadori.outline_q(t));
        }
        if (s != HamonStyle::suguha) {
            EXPECT_LT(way_hadori, 0.8 * way_hamon);
        }
        EXPECT_EQ(hadori.mask(h.outline.kissaki_s() + 0.1, 3.0), 0.0F);
        EXPECT_GT(hadori.mask(h.outline.kissaki_s() - 1.0, 3.0), 0.9F);
    }
}

}  // namespace
}  // namespace togishi
