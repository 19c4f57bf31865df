// What a user may choose about a blade's pattern, with units, ranges and defaults.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace togishi {

enum class HamonStyle { suguha, notare, gunome, choji, ko_choji, midare };
enum class BoshiStyle { komaru, omaru, midare_komi, yakizume };
enum class HadaStyle { itame, masame, mokume, ayasugi, nashiji, muji };

/// Ranges of the numbers: number_fields().
struct SteelParameters {
    HamonStyle hamon = HamonStyle::gunome;
    double hamon_height_mm =
        8.0;  ///< mean height over the edge at the machi; falls with the blade's width
    double hamon_amplitude = 1.0;  ///< height of the waves, relative to the style's own
    double hamon_scale = 1.0;  ///< length of the waves along the blade, relative to the style's own
    double yakidashi_mm = 35.0;  ///< calm start over the ha-machi
    double asymmetry = 0.35;     ///< 0: both sides equal; 1: nothing in common
    double nioiguchi_mm = 0.45;  ///< width of the misty line where the clay's edge was sharp
    double nioiguchi = 0.6;      ///< how much the line stands out of the ha
    double nie = 0.5;            ///< amount of visible grains
    double ashi = 0.6;           ///< legs from the hamon's valleys towards the edge
    double yo = 0.4;             ///< leaves: spots within the ha
    double sunagashi = 0.5;      ///< swept-sand lines in the ha, and the bright kinsuji among them
    double utsuri = 0.25;        ///< misty reflection in the ji
    BoshiStyle boshi = BoshiStyle::komaru;
    double boshi_kaeri_mm =
        7.0;  ///< turn-back along the mune, from the boshi's top; yakizume has none
    HadaStyle hada = HadaStyle::itame;
    double hada_scale = 1.0;        ///< size of the grain, relative to the style's own
    double hada_strength = 0.5;     ///< 1: the ji's roughness varies by about 7 % (std. dev.)
    double hadori = 0.4;            ///< whiteness of the polisher's hadori; 0: sashikomi polish
    double hadori_margin_mm = 0.3;  ///< outline above the hamon's crests
    double hadori_smoothing_mm =
        4.5;  ///< how far along the blade the outline ignores the hamon's detail
    double hadori_softness_mm = 3.5;  ///< fading towards the ji
    double stroke_wander_deg = 3.0;   ///< standard deviation of the polishing strokes' direction
    std::uint64_t seed = 1;
};

/// One number of SteelParameters.
struct SteelNumberField {
    std::string_view name;
    double SteelParameters::*member;
    double low;
    double high;
};

/// One choice of SteelParameters, by its names.
struct SteelChoiceField {
    std::string_view name;
    std::span<const std::string_view> names;
    int (*get)(const SteelParameters&);
    void (*set)(SteelParameters&, int);
};

[[nodiscard]] std::span<const SteelNumberField> steel_number_fields();
[[nodiscard]] std::span<const SteelChoiceField> steel_choice_fields();

/// Throws InputError for a number outside its range, NaN included.
void check_steel_parameters(const SteelParameters& parameters);
/// Sets a choice by name; throws InputError that lists the names.
void set_steel_choice(SteelParameters& parameters, const SteelChoiceField& field,
                      std::string_view name);

}  // namespace togishi
