// Scan files rarely say in which unit they are: a sword's length tells.
#pragma once
#include <array>
#include <string_view>

namespace togishi {

enum class LengthUnit { mm, cm, m, inch };
inline constexpr std::array<LengthUnit, 4> length_units{LengthUnit::mm, LengthUnit::cm,
                                                        LengthUnit::m, LengthUnit::inch};

/// "mm", "cm", "m", "inch".
[[nodiscard]] std::string_view name_of(LengthUnit unit);
[[nodiscard]] double millimetres_in(LengthUnit unit);

struct UnitCandidate {
    LengthUnit unit = LengthUnit::mm;
    double length_mm = 0;    ///< what the longest extent would be
    double likelihood = 0;   ///< share among the four, 0..1; 0: no sword is that long
    bool plausible = false;  ///< a sword of 200 to 1300 mm, tang and mount included
};

struct UnitGuess {
    LengthUnit unit = LengthUnit::mm;           ///< the likeliest
    std::array<UnitCandidate, 4> candidates{};  ///< likeliest first
    bool ambiguous = false;                     ///< a second unit is plausible, or none is
};

/// extent: the longest extent of the blade (or of the whole scan) in the file's unit, > 0.
/// Likelihoods are those of lengths of swords: normal in the logarithm about 850 mm, of a width
/// that a tanto of 300 mm and an odachi of 1300 mm lie at two standard deviations. A scan's unit is
/// a custom too: mm is taken for three times, m for twice as usual as cm and inch.
/// width: of the blade on the average, roughly, in the file's unit; 0: not known. Blades are some
/// 24 mm wide on the average of their length, a tanto as well as an odachi: so it parts those that
/// the length alone leaves between cm and inch. Throws InputError where extent is not a finite
/// number above 0 or width not one of 0 and more.
[[nodiscard]] UnitGuess guess_unit(double extent, double width = 0);

}  // namespace togishi
