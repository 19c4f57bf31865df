#include "mesh/unit_guess.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"

namespace togishi {

std::string_view name_of(LengthUnit unit) {
    constexpr std::array<std::string_view, 4> names{"mm", "cm", "m", "inch"};
    return names[static_cast<std::size_t>(unit)];
}

double millimetres_in(LengthUnit unit) {
    constexpr std::array<double, 4> sizes{1.0, 10.0, 1000.0, 25.4};
    return sizes[static_cast<std::size_t>(unit)];
}

UnitGuess guess_unit(double extent, double width) {
    if (!std::isfinite(extent) || extent <= 0) {
        throw InputError("unit", "longest extent", std::to_string(extent),
                         "a finite number above 0");
    }
    if (!std::isfinite(width) || width < 0) {
        throw InputError("unit", "width", std::to_string(width), "a finite number, 0 or more");
    }
    constexpr double usual_width_mm = 24.0, width_spread = 0.28;
    constexpr double usual_mm = 850.0, shortest_mm = 200.0, longest_mm = 1300.0;
    constexpr std::array<double, 4> custom{3.0, 1.0, 2.0, 1.0};
    const double spread = 0.5 * std::log(usual_mm / 300.0);
    UnitGuess guess;
    double sum = 0;
    for (std::size_t i = 0; i < length_units.size(); ++i) {
        UnitCandidate& c = guess.candidates[i];
        c.unit = length_units[i];
        c.length_mm = extent * millimetres_in(c.unit);
        c.plausible = c.length_mm >= shortest_mm && c.length_mm <= longest_mm;
        const double off = std::log(c.length_mm / usual_mm) / spread;
        const double wide =
            width > 0 ? std::log(width * millimetres_in(c.unit) / usual_width_mm) / width_spread
                      : 0.0;
        c.likelihood = c.plausible ? custom[i] * std::exp(-0.5 * (off * off + wide * wide)) : 0.0;
        sum += c.likelihood;
    }
    const auto near = [&](const UnitCandidate& c) {
        return c.plausible ? -1.0 : std::abs(std::log(c.length_mm / usual_mm));
    };
    std::stable_sort(guess.candidates.begin(), guess.candidates.end(),
                     [&](const UnitCandidate& a, const UnitCandidate& b) {
                         return a.likelihood != b.likelihood ? a.likelihood > b.likelihood
                                                             : near(a) < near(b);
                     });
    if (sum > 0) {
        for (UnitCandidate& c : guess.candidates) c.likelihood /= sum;
    }
    guess.unit = guess.candidates[0].unit;
    guess.ambiguous = !guess.candidates[0].plausible || guess.candidates[1].plausible;
    return guess;
}

}  // namespace togishi
