// The whole pattern as maps: same bits on any number of threads, same means at any resolution,
// values in range.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "blade/katana_frame.hpp"
#include "steel/random_stream.hpp"
#include "steel/steel_pattern.hpp"

namespace togishi {
namespace {

/// A short sword, so that many maps of it are quick to make.
KatanaParameters short_sword() {
    KatanaParameters k = katana_defaults("shinogi");
    k.nagasa_mm = 220;
    k.sori_mm = 4;
    k.kissaki_mm = 28;
    k.nakago_mm = 95;
    k.mekugi_ana_from_machi_mm = 45;
    return k;
}
const BladeFrame& short_frame() {
    static const BladeFrame frame = make_blade_frame(short_sword());
    return frame;
}

PropertyMaps maps(const SteelParameters& p, std::size_t width, std::size_t height,
                  unsigned threads = 0) {
    return steel_pattern(short_frame(), default_material(), p, width, height, {}, threads);
}

TEST(SteelPattern, IsTheSameOnAnyNumberOfThreads) {
    SteelParameters p;
    p.hamon = HamonStyle::choji;
    const PropertyMaps one = maps(p, 300, 64, 1);
    for (const unsigned threads : {2U, 5U}) {
        const PropertyMaps many = maps(p, 300, 64, threads);
        for (std::size_t c = 0; c < map_channel_count; ++c) {
            EXPECT_EQ(one.channels[c], many.channels[c]) << map_channel_names[c];
        }
    }
    p.seed = 2;
    EXPECT_NE(one[MapChannel::w], maps(p, 300, 64, 1)[MapChannel::w]);
}

TEST(SteelPattern, CoarseMapsAreTheMeansOfFineOnes) {
    SteelParameters p;
    p.hamon = HamonStyle::choji;
    p.nie = 1.0;
    p.hada_strength = 1.0;
    constexpr std::size_t times = 8;
    const PropertyMaps coarse = maps(p, 320, 80);
    const PropertyMaps fine = maps(p, 320 * times, 80 * times);
    for (const MapChannel c : {MapChannel::ji_ln_mu_deg, MapChannel::ji_e1,
                               MapChannel::ha_ln_mu_deg, MapChannel::w, MapChannel::h}) {
        double squares = 0;
        double bias = 0;
        for (std::size_t y = 0; y < coarse.height; ++y) {
            for (std::size_t x = 0; x < coarse.width; ++x) {
                double sum = 0;
                for (std::size_t j = 0; j < times; ++j) {
                    for (std::size_t i = 0; i < times; ++i)
                        sum += fine.at(c, x * times + i, y * times + j);
                }
                const double d = coarse.at(c, x, y) - sum / (times * times);
                squares += d * d;
                bias += d;
            }
        }
        const auto texels = static_cast<double>(coarse.width * coarse.height);
        // Root mean square, part borders and the blade's outline included.
        EXPECT_LT(std::sqrt(squares / texels), c == MapChannel::ji_ln_mu_deg ? 0.12 : 0.03)
            << map_channel_names[static_cast<std::size_t>(c)];
        EXPECT_LT(std::abs(bias / texels), 0.004) << map_channel_names[static_cast<std::size_t>(c)];
    }
}

void expect_sound(const PropertyMaps& m, const std::string& what) {
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        ASSERT_TRUE(m.channels[c].size() == 1 || m.channels[c].size() == m.width * m.height)
            << what;
        for (const float x : m.channels[c])
            ASSERT_TRUE(std::isfinite(x)) << what << " " << map_channel_names[c];
    }
    for (std::size_t y = 0; y < m.height; ++y) {
        for (std::size_t x = 0; x < m.width; ++x) {
            const float w = m.at(MapChannel::w, x, y);
            const float h = m.at(MapChannel::h, x, y);
            ASSERT_TRUE(w >= 0.0F && w <= 1.0F && h >= 0.0F && h <= 1.0F) << what;
            ASSERT_LT(std::abs(m.at(MapChannel::ji_ln_mu_deg, x, y)), 5.0F) << what;
            ASSERT_LT(std::abs(m.at(MapChannel::ha_ln_mu_deg, x, y)), 5.0F) << what;
            const float part = m.at(MapChannel::part, x, y);
            ASSERT_TRUE(part >= 0.0F && part < TG_PART_COUNT && part == std::floor(part)) << what;
        }
    }
}

TEST(SteelPattern, IsFiniteAndInRangeAtTheEndsOfEveryParameter) {
    RandomStream random(99, 1);
    for (int round = 0; round < 10; ++round) {
        SteelParameters p;
        std::string what = "round " + std::to_string(round) + ":";
        for (const SteelNumberField& field : steel_number_fields()) {
            p.*field.member = random.uniform() < 0.5 ? field.low : field.high;
            what += " " + std::string(field.name) + "=" + std::to_string(p.*field.member);
        }
        for (const SteelChoiceField& field : steel_choice_fields()) {
            const auto i =
                static_cast<int>(random.uniform() * static_cast<double>(field.names.size()));
            field.set(p, i);
            what += " " + std::string(field.names[static_cast<std::size_t>(i)]);
        }
        p.seed = round % 2 == 0 ? std::numeric_limits<std::uint64_t>::max() - round : round;
        expect_sound(maps(p, 96, 32), what);
    }
}

TEST(SteelPattern, WorksOnEveryZukuriAndSize) {
    for (const char* zukuri : {"shinogi", "hira", "shobu"}) {
        const BladeFrame frame = make_blade_frame(katana_defaults(zukuri));
        for (const auto& [width, height] :
             {std::pair<std::size_t, std::size_t>{1, 1}, {3, 200}, {200, 3}}) {
            const PropertyMaps m = steel_pattern(frame, default_material(), {}, width, height);
            EXPECT_EQ(m.width, width);
            expect_sound(m, zukuri);
        }
        const PropertyMaps m = steel_pattern(frame, default_material(), {}, 512, 64);
        const auto& w = m[MapChannel::w];
        EXPECT_GT(std::count_if(w.begin(), w.end(), [](float x) { return x > 0.6F; }), 2000)
            << zukuri;
    }
}

TEST(SteelPattern, PartsFollowTheHamonAndTheNakagoHasNone) {
    const PropertyMaps m = maps({}, 640, 160);
    std::array<int, TG_PART_COUNT> seen{};
    for (std::size_t y = 0; y < m.height; ++y) {
        for (std::size_t x = 0; x < m.width; ++x) {
            const auto part = static_cast<Part>(static_cast<int>(m.at(MapChannel::part, x, y)));
            ++seen[static_cast<std::size_t>(part)];
            const float w = m.at(MapChannel::w, x, y);
            const float h = m.at(MapChannel::h, x, y);
            if (part == Part::nakago) {
                // A texel across the machi holds a share of both.
                const double s =
                    (static_cast<double>(x) + 1.0) / 640.0 * short_frame().length_mm() -
                    short_frame().nakago_mm;
                if (s < -0.6) {
                    EXPECT_EQ(w, 0.0F);
                    EXPECT_EQ(h, 0.0F);
                }
            }
            if (part == Part::kissaki || part == Part::boshi) {
                const double s = static_cast<double>(x) / 640.0 * short_frame().length_mm() -
                                 short_frame().nakago_mm;
                if (s > short_frame().yokote_s_mm + 0.6) {
                    EXPECT_EQ(h, 0.0F);
                }
            }
            if (part == Part::ha) {
                EXPECT_GT(w, 0.2F);
            }
            if (part == Part::ji) {
                EXPECT_LT(w, 0.8F);
            }
        }
    }
    for (const Part part : {Part::ji, Part::shinogi_ji, Part::ha, Part::mune, Part::kissaki,
                            Part::boshi, Part::nakago}) {
        EXPECT_GT(seen[static_cast<std::size_t>(part)], 20)
            << part_names[static_cast<std::size_t>(part)];
    }
}

TEST(SteelPattern, TheSidesMeetAtTheEdge) {
    const PropertyMaps m = maps({}, 512, 1024);
    double most = 0;
    double sum = 0;
    int count = 0;
    for (std::size_t x = 0; x < m.width; ++x) {
        const double s = (static_cast<double>(x) + 0.5) / 512.0 * short_frame().length_mm() -
                         short_frame().nakago_mm;
        if (s < 15.0 || s > short_frame().yokote_s_mm - 3.0) continue;
        const auto on_blade = [&](std::size_t y) { return m.at(MapChannel::part, x, y) != 0.0F; };
        std::size_t low = 0;
        while (low < m.height / 2 && !on_blade(low)) ++low;
        std::size_t high = m.height - 1;
        while (high > m.height / 2 && !on_blade(high)) --high;
        const double d = std::abs(m.at(MapChannel::w, x, low) - m.at(MapChannel::w, x, high));
        most = std::max(most, d);
        sum += d;
        ++count;
        EXPECT_NEAR(m.at(MapChannel::ha_ln_mu_deg, x, low), m.at(MapChannel::ha_ln_mu_deg, x, high),
                    0.1);
        EXPECT_GT(m.at(MapChannel::w, x, low), 0.6F);
    }
    ASSERT_GT(count, 100);
    EXPECT_LT(sum / count, 0.02);
    EXPECT_LT(most, 0.15);
}

TEST(SteelPattern, ConstantChannelsHoldOneValue) {
    Material isotropic = default_material();
    for (const MaterialLobeField& field : material_lobes) {
        (isotropic.*field.member).mu_t_deg = (isotropic.*field.member).mu_b_deg;
    }
    SteelParameters p;
    p.hadori = 0.0;
    const PropertyMaps m = steel_pattern(short_frame(), isotropic, p, 64, 32);
    for (const MapChannel c : {MapChannel::ji_e1, MapChannel::ji_e2, MapChannel::ha_e1,
                               MapChannel::ha_e2, MapChannel::h}) {
        ASSERT_TRUE(m.constant(c)) << map_channel_names[static_cast<std::size_t>(c)];
        EXPECT_EQ(m[c][0], 0.0F);
    }
    EXPECT_FALSE(m.constant(MapChannel::w));
    EXPECT_FALSE(m.constant(MapChannel::ji_ln_mu_deg));
}

TEST(SteelPattern, KeepsTheMaterialsMeans) {
    SteelParameters p;
    p.utsuri = 0.0;
    const PropertyMaps m = maps(p, 640, 160);
    const Material material = default_material();
    double ji = 0;
    double ha = 0;
    int ji_count = 0;
    int ha_count = 0;
    for (std::size_t i = 0; i < m.width * m.height; ++i) {
        const auto part = static_cast<Part>(static_cast<int>(m[MapChannel::part][i]));
        if (part == Part::ji) {
            ji += m[MapChannel::ji_ln_mu_deg][i];
            ++ji_count;
        } else if (part == Part::ha) {
            ha += m[MapChannel::ha_ln_mu_deg][i];
            ++ha_count;
        }
    }
    EXPECT_NEAR(ji / ji_count, 0.5 * std::log(material.ji.mu_t_deg * material.ji.mu_b_deg), 0.03);
    EXPECT_NEAR(ha / ha_count, 0.5 * std::log(material.ha.mu_t_deg * material.ha.mu_b_deg), 0.12);
}

TEST(SteelPattern, StrengthsOfZeroLeaveThePartsPlain) {
    SteelParameters p;
    p.hada_strength = 0.0;
    p.utsuri = 0.0;
    p.stroke_wander_deg = 0.0;
    const PropertyMaps m = maps(p, 640, 160);
    const Material material = default_material();
    const double expected = 0.5 * std::log(material.ji.mu_t_deg * material.ji.mu_b_deg);
    int plain = 0;
    int of = 0;
    for (std::size_t i = 0; i < m.width * m.height; ++i) {
        if (static_cast<int>(m[MapChannel::part][i]) != static_cast<int>(Part::ji)) continue;
        ++of;
        if (std::abs(m[MapChannel::ji_ln_mu_deg][i] - expected) < 1e-4) ++plain;
    }
    EXPECT_GT(plain, of * 9 / 10);  // the rest are texels across the ji's borders
}

TEST(SteelPattern, TheShinogiRunsAslantOverTheTexelsWithoutSteps) {
    SteelParameters p;
    p.hada_strength = 0;
    p.stroke_wander_deg = 0;
    p.utsuri = 0;
    constexpr std::size_t width = 600, height = 512;
    const PropertyMaps map = maps(p, width, height);
    const BladeFrame& frame = short_frame();
    const double texel_mm = frame.chart_height_mm / height;
    const Material material = default_material();
    const auto ln = [](const MaterialLobe& lobe) {
        return 0.5 * std::log(lobe.mu_t_deg * lobe.mu_b_deg);
    };
    const double middle = 0.5 * (ln(material.ji) + ln(material.shinogi_ji));
    std::size_t columns = 0;
    double worst = 0;
    for (std::size_t x = 0; x < width; ++x) {
        const double u = (static_cast<double>(x) + 0.5) / width;
        for (std::size_t y = 0; y + 1 < height; ++y) {
            const double v = (static_cast<double>(y) + 0.5) / height;
            const ChartPoint here = frame.locate(u, v);
            const ChartPoint above = frame.locate(u, v + 1.0 / height);
            if (here.s_mm < 5 || here.s_mm > 150 || here.omote != above.omote) continue;
            const double line = frame.at(frame.shinogi_mm, here.s_mm);
            const double d0 = here.from_ridge_mm - line, d1 = above.from_ridge_mm - line;
            if ((d0 < 0) == (d1 < 0)) continue;
            // Where a picture that is filtered linearly shows the border.
            const double a = map.at(MapChannel::ji_ln_mu_deg, x, y) - middle;
            const double b = map.at(MapChannel::ji_ln_mu_deg, x, y + 1) - middle;
            ASSERT_LT(a * b, 0) << x << " " << y;
            worst = std::max(worst, std::abs(d0 + (d1 - d0) * a / (a - b)) / texel_mm);
            ++columns;
        }
    }
    EXPECT_GT(columns, 500U);
    EXPECT_LT(worst, 0.1);  // 0.5 where each texel belongs to one part alone
}

TEST(SteelPattern, RefusesWhatIsOutOfRange) {
    for (const SteelNumberField& field : steel_number_fields()) {
        for (const double bad : {field.low - 1.0, field.high + 1.0, std::nan(""), HUGE_VAL}) {
            SteelParameters p;
            p.*field.member = bad;
            try {
                maps(p, 4, 4);
                FAIL() << field.name;
            } catch (const InputError& e) {
                EXPECT_NE(std::string(e.what()).find(field.name), std::string::npos) << e.what();
            }
        }
    }
    EXPECT_THROW(maps({}, 0, 4), InputError);
    EXPECT_THROW(maps({}, 4, 70000), InputError);
    Material bad = default_material();
    bad.ha.mu_b_deg = std::nan("");
    EXPECT_THROW((void)steel_pattern(short_frame(), bad, {}, 4, 4), InputError);
    SteelParameters p;
    EXPECT_THROW(set_steel_choice(p, steel_choice_fields()[0], "sudareba"), InputError);
    BladeFrame torn = short_frame();
    torn.edge_mm[3] = std::nan("");
    EXPECT_THROW((void)steel_pattern(torn, default_material(), {}, 4, 4), InputError);
}

TEST(SteelPattern, TellsItsProgressAndStopsWhenAsked) {
    double last = -1;
    (void)steel_pattern(short_frame(), default_material(), {}, 64, 64, [&](double done) {
        EXPECT_GE(done, last);
        last = done;
        return true;
    });
    EXPECT_DOUBLE_EQ(last, 1.0);
    EXPECT_THROW((void)steel_pattern(short_frame(), default_material(), {}, 64, 64,
                                     [](double done) { return done < 0.5; }),
                 SteelCancelled);
}

}  // namespace
}  // namespace togishi
