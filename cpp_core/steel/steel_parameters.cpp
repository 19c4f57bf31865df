#include "steel/steel_parameters.hpp"

#include <array>
#include <string>

#include "base/error.hpp"

namespace togishi {
namespace {

using P = SteelParameters;
constexpr std::string_view where = "steel pattern";

constexpr std::array<SteelNumberField, 20> numbers{{
    {"hamon_height_mm", &P::hamon_height_mm, 0.5, 40.0},
    {"hamon_amplitude", &P::hamon_amplitude, 0.0, 3.0},
    {"hamon_scale", &P::hamon_scale, 0.25, 4.0},
    {"yakidashi_mm", &P::yakidashi_mm, 0.0, 300.0},
    {"asymmetry", &P::asymmetry, 0.0, 1.0},
    {"nioiguchi_mm", &P::nioiguchi_mm, 0.05, 5.0},
    {"nioiguchi", &P::nioiguchi, 0.0, 1.0},
    {"nie", &P::nie, 0.0, 1.0},
    {"ashi", &P::ashi, 0.0, 1.0},
    {"yo", &P::yo, 0.0, 1.0},
    {"sunagashi", &P::sunagashi, 0.0, 1.0},
    {"utsuri", &P::utsuri, 0.0, 1.0},
    {"boshi_kaeri_mm", &P::boshi_kaeri_mm, 0.0, 100.0},
    {"hada_scale", &P::hada_scale, 0.2, 5.0},
    {"hada_strength", &P::hada_strength, 0.0, 1.0},
    {"hadori", &P::hadori, 0.0, 1.0},
    {"hadori_margin_mm", &P::hadori_margin_mm, 0.0, 10.0},
    {"hadori_smoothing_mm", &P::hadori_smoothing_mm, 0.5, 30.0},
    {"hadori_softness_mm", &P::hadori_softness_mm, 0.1, 20.0},
    {"stroke_wander_deg", &P::stroke_wander_deg, 0.0, 20.0},
}};

constexpr std::array<std::string_view, 6> hamon_names{"suguha", "notare",   "gunome",
                                                      "choji",  "ko_choji", "midare"};
constexpr std::array<std::string_view, 4> boshi_names{"komaru", "omaru", "midare_komi", "yakizume"};
constexpr std::array<std::string_view, 6> hada_names{"itame",   "masame",  "mokume",
                                                     "ayasugi", "nashiji", "muji"};

constexpr std::array<SteelChoiceField, 3> choices{{
    {"hamon", hamon_names, [](const P& p) { return static_cast<int>(p.hamon); },
     [](P& p, int i) { p.hamon = static_cast<HamonStyle>(i); }},
    {"boshi", boshi_names, [](const P& p) { return static_cast<int>(p.boshi); },
     [](P& p, int i) { p.boshi = static_cast<BoshiStyle>(i); }},
    {"hada", hada_names, [](const P& p) { return static_cast<int>(p.hada); },
     [](P& p, int i) { p.hada = static_cast<HadaStyle>(i); }},
}};

std::string as_text(double x) {
    std::string text = std::to_string(x);
    while (text.find('.') != std::string::npos && (text.back() == '0' || text.back() == '.')) {
        const bool point = text.back() == '.';
        text.pop_back();
        if (point) break;
    }
    return text;
}

}  // namespace

std::span<const SteelNumberField> steel_number_fields() {
    return numbers;
}
std::span<const SteelChoiceField> steel_choice_fields() {
    return choices;
}

void check_steel_parameters(const SteelParameters& parameters) {
    for (const SteelNumberField& field : numbers) {
        const double x = parameters.*field.member;
        // Written so that NaN fails.
        if (!(x >= field.low && x <= field.high)) {
            throw InputError(where, field.name, as_text(x),
                             as_text(field.low) + " to " + as_text(field.high));
        }
    }
    for (const SteelChoiceField& field : choices) {
        const int i = field.get(parameters);
        if (i < 0 || i >= static_cast<int>(field.names.size())) {
            throw InputError(where, field.name, std::to_string(i), "one of the named choices");
        }
    }
}

void set_steel_choice(SteelParameters& parameters, const SteelChoiceField& field,
                      std::string_view name) {
    std::string allowed;
    for (std::size_t i = 0; i < field.names.size(); ++i) {
        if (field.names[i] == name) {
            field.set(parameters, static_cast<int>(i));
            return;
        }
        allowed += (i == 0 ? "" : ", ") + std::string(field.names[i]);
    }
    throw InputError(where, field.name, name, "one of: " + allowed);
}

}  // namespace togishi
