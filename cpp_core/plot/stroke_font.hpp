// A font of strokes, drawn for this program: Latin letters, digits, the signs and Greek letters of
// its formulas.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "plot/canvas.hpp"

namespace togishi {

inline constexpr double stroke_font_cap_height = 7;

/// In units of a seventh of a capital's height, y upwards from the baseline.
struct StrokeGlyph {
    std::vector<std::vector<PlotPoint>> lines;
    double advance = 0;
};

/// The glyph of a character; a box where the font lacks it.
[[nodiscard]] const StrokeGlyph& stroke_glyph(char32_t code);

/// Characters of a UTF-8 text; bytes that are none become U+FFFD.
[[nodiscard]] std::u32string unicode_of(std::string_view utf8);

}  // namespace togishi
