#include "blade/katana_parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "base/error.hpp"

namespace togishi {
namespace {

using P = KatanaParameters;

constexpr std::array dimensions{
    DimensionField{"nagasa_mm", "straight line from the mune-machi to the tip", "mm", &P::nagasa_mm,
                   60, 2500},
    DimensionField{"sori_mm", "greatest distance of that line to the mune", "mm", &P::sori_mm, 0,
                   200},
    DimensionField{"motohaba_mm", "width at the machi, mune ridge to edge", "mm", &P::motohaba_mm,
                   8, 80},
    DimensionField{"sakihaba_mm", "width at the yokote", "mm", &P::sakihaba_mm, 5, 80},
    DimensionField{"motokasane_mm", "thickness at the mune's corners, at the machi", "mm",
                   &P::motokasane_mm, 2, 20},
    DimensionField{"sakikasane_mm", "thickness at the mune's corners, at the yokote", "mm",
                   &P::sakikasane_mm, 1, 20},
    DimensionField{"kissaki_mm", "straight line from the yokote on the mune to the tip", "mm",
                   &P::kissaki_mm, 5, 400},
    DimensionField{"fukura", "roundness of the point's edge: 0 karetaru (straight), 1 full", "",
                   &P::fukura, 0, 1},
    DimensionField{"mune_height_mm", "height of the mune over its corners, at the machi", "mm",
                   &P::mune_height_mm, 0, 10},
    DimensionField{"moto_shinogi_haba_mm", "from the mune ridge to the shinogi, at the machi", "mm",
                   &P::moto_shinogi_haba_mm, 1, 60},
    DimensionField{"saki_shinogi_haba_mm", "from the mune ridge to the shinogi, at the yokote",
                   "mm", &P::saki_shinogi_haba_mm, 1, 60},
    DimensionField{"shinogi_rise_mm",
                   "how far each shinogi stands out over the mune's corner, at the machi", "mm",
                   &P::shinogi_rise_mm, 0, 5},
    DimensionField{"niku_mm", "bulge of the ji over the flat, at the machi", "mm", &P::niku_mm, 0,
                   2},
    DimensionField{"ha_haba_mm", "width of the nominal suguha, at the machi (parts ha and boshi)",
                   "mm", &P::ha_haba_mm, 0.5, 60},
    DimensionField{"nakago_mm", "straight line from the mune-machi to the nakago's end", "mm",
                   &P::nakago_mm, 20, 800},
    DimensionField{"nakago_sakihaba_mm", "width of the nakago where its end starts to round", "mm",
                   &P::nakago_sakihaba_mm, 3, 80},
    DimensionField{"nakago_sakikasane_mm", "thickness of the nakago there", "mm",
                   &P::nakago_sakikasane_mm, 1, 20},
    DimensionField{"ha_machi_mm", "depth of the notch on the edge side", "mm", &P::ha_machi_mm, 0.2,
                   12},
    DimensionField{"mune_machi_mm", "depth of the notch on the back", "mm", &P::mune_machi_mm, 0.2,
                   12},
    DimensionField{"mekugi_ana_mm", "diameter of the peg hole; 0: none", "mm", &P::mekugi_ana_mm, 0,
                   15},
    DimensionField{"mekugi_ana_from_machi_mm", "from the machi to the hole's centre", "mm",
                   &P::mekugi_ana_from_machi_mm, 5, 700},
};

const std::array<ChoiceField, 4>& choices() {
    static const std::array<ChoiceField, 4> all{
        ChoiceField{"zukuri",
                    "cross-section and point",
                    {"shinogi", "hira", "shobu"},
                    [](const P& p) { return static_cast<int>(p.zukuri); },
                    [](P& p, int i) { p.zukuri = static_cast<Zukuri>(i); }},
        ChoiceField{"sori_type",
                    "where the curve lies",
                    {"koshi", "torii", "saki", "even"},
                    [](const P& p) { return static_cast<int>(p.sori_type); },
                    [](P& p, int i) { p.sori_type = static_cast<SoriType>(i); }},
        ChoiceField{"mune",
                    "shape of the back",
                    {"iori", "mitsu", "maru", "kaku"},
                    [](const P& p) { return static_cast<int>(p.mune); },
                    [](P& p, int i) { p.mune = static_cast<MuneType>(i); }},
        ChoiceField{"nakago_jiri",
                    "shape of the nakago's end",
                    {"kuri", "haagari", "kiri"},
                    [](const P& p) { return static_cast<int>(p.nakago_jiri); },
                    [](P& p, int i) { p.nakago_jiri = static_cast<Jiri>(i); }},
    };
    return all;
}

std::string number(double value) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.10g", value);
    return text.data();
}
std::string mm(double value) {
    return number(value) + " mm";
}

std::string known_keys() {
    std::string all;
    for (const ChoiceField& c : choices()) all += std::string(c.key) + ", ";
    for (const DimensionField& d : dimensions) all += std::string(d.key) + ", ";
    all.resize(all.size() - 2);
    return all;
}

// One relation that a blade's dimensions must hold.
void require(bool holds, std::string_view where, std::string_view field, double found,
             const std::string& allowed) {
    if (!holds) throw InputError(where, field, mm(found), allowed);
}

}  // namespace

std::span<const DimensionField> katana_dimensions() {
    return dimensions;
}
std::span<const ChoiceField> katana_choices() {
    return choices();
}

KatanaParameters katana_defaults(std::string_view zukuri) {
    KatanaParameters p;
    set_katana_value(p, "zukuri", zukuri, "katana_defaults");
    if (p.zukuri == Zukuri::hira) {
        p.nagasa_mm = 260;
        p.sori_mm = 2;
        p.motohaba_mm = 25;
        p.sakihaba_mm = 19;
        p.motokasane_mm = 6;
        p.sakikasane_mm = 4.4;
        p.kissaki_mm = 40;
        p.mune_height_mm = 1.6;
        p.niku_mm = 0.2;
        p.ha_haba_mm = 6;
        p.nakago_mm = 105;
        p.nakago_sakihaba_mm = 13;
        p.nakago_sakikasane_mm = 4;
        p.ha_machi_mm = 2.2;
        p.mune_machi_mm = 1.6;
        p.mekugi_ana_mm = 5;
        p.mekugi_ana_from_machi_mm = 38;
    } else if (p.zukuri == Zukuri::shobu) {
        p.nagasa_mm = 480;
        p.sori_mm = 11;
        p.motohaba_mm = 29;
        p.sakihaba_mm = 21.5;
        p.motokasane_mm = 6.4;
        p.sakikasane_mm = 4.4;
        p.kissaki_mm = 48;
        p.moto_shinogi_haba_mm = 10;
        p.saki_shinogi_haba_mm = 7.6;
        p.nakago_mm = 150;
        p.nakago_sakihaba_mm = 16;
        p.mekugi_ana_from_machi_mm = 52;
    }
    return p;
}

void set_katana_value(KatanaParameters& parameters, std::string_view key, double value,
                      std::string_view where) {
    for (const DimensionField& d : dimensions) {
        if (d.key == key) {
            parameters.*d.member = value;
            return;
        }
    }
    for (const ChoiceField& c : choices()) {
        if (c.key == key) throw InputError(where, key, number(value), "a name, in quotes");
    }
    throw InputError(where, "key", key, "one of " + known_keys());
}

void set_katana_value(KatanaParameters& parameters, std::string_view key, std::string_view name,
                      std::string_view where) {
    for (const ChoiceField& c : choices()) {
        if (c.key != key) continue;
        const auto found = std::find(c.names.begin(), c.names.end(), name);
        if (found == c.names.end()) {
            std::string all;
            for (const std::string_view n : c.names)
                all += (all.empty() ? "" : ", ") + std::string(n);
            throw InputError(where, key, "\"" + std::string(name) + "\"", "one of " + all);
        }
        c.set(parameters, static_cast<int>(found - c.names.begin()));
        return;
    }
    for (const DimensionField& d : dimensions) {
        if (d.key == key) throw InputError(where, key, "\"" + std::string(name) + "\"", "a number");
    }
    throw InputError(where, "key", key, "one of " + known_keys());
}

void check_katana(const KatanaParameters& p, std::string_view where) {
    for (const DimensionField& d : dimensions) {
        const double value = p.*d.member;
        const std::string unit = d.unit.empty() ? "" : " " + std::string(d.unit);
        if (!std::isfinite(value) || value < d.min || value > d.max) {
            throw InputError(
                where, d.key, number(value) + unit,
                number(d.min) + " to " + number(d.max) + unit + " (" + std::string(d.help) + ")");
        }
    }
    const bool shinogi = p.zukuri != Zukuri::hira;
    require(p.sori_mm <= 0.06 * p.nagasa_mm, where, "sori_mm", p.sori_mm,
            "at most 6 % of the nagasa (" + mm(0.06 * p.nagasa_mm) +
                "): deeper, the blade folds back on itself");
    require(p.kissaki_mm <= 0.5 * p.nagasa_mm, where, "kissaki_mm", p.kissaki_mm,
            "at most half of the nagasa (" + mm(0.5 * p.nagasa_mm) +
                "): the kissaki is a part of the blade");
    require(p.kissaki_mm >= 0.7 * p.sakihaba_mm, where, "kissaki_mm", p.kissaki_mm,
            "at least 0.7 sakihaba (" + mm(0.7 * p.sakihaba_mm) +
                "): a shorter point is no curve from edge to mune");
    require(p.sakihaba_mm <= 1.1 * p.motohaba_mm, where, "sakihaba_mm", p.sakihaba_mm,
            "at most 1.1 motohaba (" + mm(1.1 * p.motohaba_mm) +
                "): a blade does not widen towards its point");
    require(p.motohaba_mm <= 0.25 * p.nagasa_mm, where, "motohaba_mm", p.motohaba_mm,
            "at most a quarter of the nagasa (" + mm(0.25 * p.nagasa_mm) + ")");
    require(p.sakikasane_mm <= 1.1 * p.motokasane_mm, where, "sakikasane_mm", p.sakikasane_mm,
            "at most 1.1 motokasane (" + mm(1.1 * p.motokasane_mm) +
                "): a blade does not thicken towards its point");
    require(p.motokasane_mm <= 0.4 * p.motohaba_mm, where, "motokasane_mm", p.motokasane_mm,
            "at most 0.4 motohaba (" + mm(0.4 * p.motohaba_mm) + ")");
    require(p.sakikasane_mm <= 0.4 * p.sakihaba_mm, where, "sakikasane_mm", p.sakikasane_mm,
            "at most 0.4 sakihaba (" + mm(0.4 * p.sakihaba_mm) + ")");
    if (p.mune != MuneType::kaku) {
        const double half = 0.5 * p.motokasane_mm;
        require(p.mune_height_mm >= 0.1 * half && p.mune_height_mm <= half, where, "mune_height_mm",
                p.mune_height_mm,
                mm(0.1 * half) + " to " + mm(half) +
                    " (half of the motokasane) unless the mune is kaku");
    }
    const double mune_moto = p.mune == MuneType::kaku ? 0 : p.mune_height_mm;
    const double mune_saki = mune_moto * p.sakikasane_mm / p.motokasane_mm;
    if (shinogi) {
        const double lo =
            std::max(mune_moto + 0.05 * p.motohaba_mm, p.mune_machi_mm + 0.05 * p.motohaba_mm);
        require(
            p.moto_shinogi_haba_mm >= lo && p.moto_shinogi_haba_mm <= 0.7 * p.motohaba_mm, where,
            "moto_shinogi_haba_mm", p.moto_shinogi_haba_mm,
            mm(lo) + " to " + mm(0.7 * p.motohaba_mm) +
                ": the shinogi lies between the mune's corner (and the mune-machi) and the edge");
        const double lo_saki = mune_saki + 0.05 * p.sakihaba_mm;
        require(p.saki_shinogi_haba_mm >= lo_saki && p.saki_shinogi_haba_mm <= 0.7 * p.sakihaba_mm,
                where, "saki_shinogi_haba_mm", p.saki_shinogi_haba_mm,
                mm(lo_saki) + " to " + mm(0.7 * p.sakihaba_mm) +
                    ": the shinogi lies between the mune's corner and the edge");
        const double most = 0.2 * (p.moto_shinogi_haba_mm - mune_moto);
        require(p.shinogi_rise_mm <= most, where, "shinogi_rise_mm", p.shinogi_rise_mm,
                "at most a fifth of the shinogi-ji's width (" + mm(most) + ")");
    }
    const double ji = p.motohaba_mm - (shinogi ? p.moto_shinogi_haba_mm : mune_moto);
    require(p.ha_haba_mm <= 0.9 * ji, where, "ha_haba_mm", p.ha_haba_mm,
            "at most 0.9 of the ji's width (" + mm(0.9 * ji) + ")");
    require(
        p.niku_mm <= 0.05 * ji, where, "niku_mm", p.niku_mm,
        "at most 5 % of the ji's width (" + mm(0.05 * ji) + "): more would bulge over the shinogi");
    const double nakago_width = p.motohaba_mm - p.ha_machi_mm - p.mune_machi_mm;
    require(nakago_width >= 0.5 * p.motohaba_mm, where, "ha_machi_mm", p.ha_machi_mm,
            "both machi together at most half of the motohaba (" + mm(0.5 * p.motohaba_mm) + ")");
    require(p.nakago_sakihaba_mm <= nakago_width && p.nakago_sakihaba_mm >= 0.3 * nakago_width,
            where, "nakago_sakihaba_mm", p.nakago_sakihaba_mm,
            mm(0.3 * nakago_width) + " to " + mm(nakago_width) +
                ": the nakago tapers from its width at the machi");
    require(p.nakago_sakikasane_mm <= 1.1 * p.motokasane_mm &&
                p.nakago_sakikasane_mm <= 0.5 * p.nakago_sakihaba_mm,
            where, "nakago_sakikasane_mm", p.nakago_sakikasane_mm,
            "at most " + mm(std::min(1.1 * p.motokasane_mm, 0.5 * p.nakago_sakihaba_mm)) +
                " (1.1 motokasane, half of the nakago's width)");
    require(p.nakago_mm >= 1.5 * p.motohaba_mm, where, "nakago_mm", p.nakago_mm,
            "at least 1.5 motohaba (" + mm(1.5 * p.motohaba_mm) + ")");
    if (p.mekugi_ana_mm > 0) {
        require(p.mekugi_ana_mm >= 1 && p.mekugi_ana_mm <= 0.45 * p.nakago_sakihaba_mm, where,
                "mekugi_ana_mm", p.mekugi_ana_mm,
                "0 (none) or 1 mm to " + mm(0.45 * p.nakago_sakihaba_mm) +
                    " (0.45 of the nakago's width at its end)");
        // Room across: on the shinogi-ji above the shinogi, or on the one side of a hira-zukuri.
        const double share = nakago_width > 0 ? p.nakago_sakihaba_mm / nakago_width : 1;
        const double room =
            shinogi ? 2 * share * (p.moto_shinogi_haba_mm - p.mune_machi_mm) - 1.2 * mune_moto
                    : share * nakago_width - 2 * mune_moto;
        require(1.25 * p.mekugi_ana_mm <= room, where, "mekugi_ana_mm", p.mekugi_ana_mm,
                "0 (none) or at most " + mm(room / 1.25) +
                    ": centred on the shinogi it must clear the mune");
        const double lo = 5 + p.mekugi_ana_mm;
        const double hi = p.nakago_mm - p.nakago_sakihaba_mm - 1.5 * p.mekugi_ana_mm;
        require(p.mekugi_ana_from_machi_mm >= lo && p.mekugi_ana_from_machi_mm <= hi, where,
                "mekugi_ana_from_machi_mm", p.mekugi_ana_from_machi_mm,
                mm(lo) + " to " + mm(hi) + ": the hole lies inside the nakago");
    }
}

}  // namespace togishi
