#include "plot/stroke_font.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <map>

namespace togishi {
namespace {

// Lines are separated by "|". A line is a row of points "x,y" and of elliptic arcs
// "@cx,cy,rx,ry,from,to" in degrees, counter-clockwise where `to` is larger. The glyph's width
// comes first.
struct Source {
    char32_t code;
    std::string_view strokes;
};
constexpr Source sources[] = {
    {U' ', "2.2"},
    {U'0', "4.4 @2.2,3.5,2.2,3.5,90,450"},
    {U'1', "4.4 0.9,5.7 2.6,7 2.6,0"},
    {U'2', "4.4 @2.1,4.95,2.05,2.05,165,-35 0,0 4.3,0"},
    {U'3', "4.4 @2.1,5.3,1.8,1.7,150,-90 @2.1,1.8,2.2,1.8,90,-150"},
    {U'4', "4.6 3.3,0 3.3,7 0,2 4.6,2"},
    {U'5', "4.3 3.9,7 0.7,7 0.4,3.9 @2,2.25,2.2,2.25,130,-150"},
    {U'6', "4.4 @4.2,2.2,4.2,4.8,100,180|@2.2,2.2,2.2,2.2,0,360"},
    {U'7', "4.4 0,7 4.4,7 1.5,0"},
    {U'8', "4.4 @2.2,5.3,1.8,1.7,0,360|@2.2,1.8,2.2,1.8,0,360"},
    {U'9', "4.4 @0.2,4.8,4.2,4.8,0,-80|@2.2,4.8,2.2,2.2,0,360"},
    {U'A', "5 0,0 2.5,7 5,0|0.9,2.4 4.1,2.4"},
    {U'B', "4.4 0,0 0,7 2.2,7 @2.2,5.3,1.7,1.7,90,-90 0,3.6|2.2,3.6 @2.4,1.8,2,1.8,90,-90 0,0"},
    {U'C', "4.4 @2.6,3.5,2.6,3.5,50,310"},
    {U'D', "4.7 0,0 0,7 1.6,7 @1.6,3.5,3.1,3.5,90,-90 0,0"},
    {U'E', "3.8 3.8,7 0,7 0,0 3.8,0|0,3.6 3.2,3.6"},
    {U'F', "3.7 3.7,7 0,7 0,0|0,3.6 3.2,3.6"},
    {U'G', "4.9 @2.6,3.5,2.6,3.5,50,330 4.85,3.2 2.9,3.2"},
    {U'H', "4.5 0,0 0,7|4.5,0 4.5,7|0,3.6 4.5,3.6"},
    {U'I', "0 0,0 0,7"},
    {U'J', "3 3,7 3,1.7 @1.5,1.7,1.5,1.7,0,-160"},
    {U'K', "4.3 0,0 0,7|4.1,7 0,2.6|1.3,4 4.3,0"},
    {U'L', "3.7 0,7 0,0 3.7,0"},
    {U'M', "5.4 0,0 0,7 2.7,2 5.4,7 5.4,0"},
    {U'N', "4.5 0,0 0,7 4.5,0 4.5,7"},
    {U'O', "5.4 @2.7,3.5,2.7,3.5,0,360"},
    {U'P', "4.1 0,0 0,7 2.2,7 @2.2,5.1,1.9,1.9,90,-90 0,3.2"},
    {U'Q', "5.4 @2.7,3.5,2.7,3.5,0,360|3.3,1.6 5.2,-0.5"},
    {U'R', "4.3 0,0 0,7 2.2,7 @2.2,5.1,1.9,1.9,90,-90 0,3.2|2.2,3.2 4.3,0"},
    {U'S', "4.3 @2.15,5.25,1.95,1.75,40,270 @2.15,1.75,2.15,1.75,90,-140"},
    {U'T', "4.8 0,7 4.8,7|2.4,7 2.4,0"},
    {U'U', "4.4 0,7 0,2.2 @2.2,2.2,2.2,2.2,180,360 4.4,7"},
    {U'V', "4.8 0,7 2.4,0 4.8,7"},
    {U'W', "6.8 0,7 1.7,0 3.4,6.4 5.1,0 6.8,7"},
    {U'X', "4.5 0,7 4.5,0|4.5,7 0,0"},
    {U'Y', "4.6 0,7 2.3,3.3 4.6,7|2.3,3.3 2.3,0"},
    {U'Z', "4.3 0,7 4.3,7 0,0 4.3,0"},
    {U'a', "4 @2,2.5,2,2.5,0,360|4,5 4,0"},
    {U'b', "4 0,7.2 0,0|@2,2.5,2,2.5,0,360"},
    {U'c', "3.6 @2.1,2.5,2.1,2.5,45,315"},
    {U'd', "4 4,7.2 4,0|@2,2.5,2,2.5,0,360"},
    {U'e', "4.1 0,2.6 4.1,2.6 @2.05,2.5,2.05,2.5,3,315"},
    {U'f', "2.4 2.6,7.1 @2.4,5.7,1.4,1.4,90,180 1,0|0,5 2.4,5"},
    {U'g', "4 4,5 4,-0.3 @2,-0.3,2,1.9,0,-150|@2,2.5,2,2.5,0,360"},
    {U'h', "3.8 0,7.2 0,0|0,3.1 @1.9,3.1,1.9,1.9,180,0 3.8,0"},
    {U'i', "0 0,5 0,0|0,6.9 0,7.1"},
    {U'j', "1 1,5 1,-0.7 @0,-0.7,1,1.3,0,-110|1,6.9 1,7.1"},
    {U'k', "3.5 0,7.2 0,0|3.3,5 0,1.8|1.1,2.9 3.5,0"},
    {U'l', "0 0,7.2 0,0"},
    {U'm', "6 0,5 0,0|0,3.5 @1.5,3.5,1.5,1.5,180,0 3,0|3,3.5 @4.5,3.5,1.5,1.5,180,0 6,0"},
    {U'n', "3.8 0,5 0,0|0,3.1 @1.9,3.1,1.9,1.9,180,0 3.8,0"},
    {U'o', "4.2 @2.1,2.5,2.1,2.5,0,360"},
    {U'p', "4 0,5 0,-2.1|@2,2.5,2,2.5,0,360"},
    {U'q', "4 4,5 4,-2.1|@2,2.5,2,2.5,0,360"},
    {U'r', "2.3 0,5 0,0|0,3 @1.9,3,1.9,2,180,75"},
    {U's', "3.2 @1.6,3.7,1.45,1.3,40,270 @1.6,1.2,1.6,1.2,90,-140"},
    {U't', "2.4 1,6.6 1,1.3 @2.3,1.3,1.3,1.3,180,280|0,5 2.4,5"},
    {U'u', "3.8 0,5 0,1.9 @1.9,1.9,1.9,1.9,180,360|3.8,5 3.8,0"},
    {U'v', "3.8 0,5 1.9,0 3.8,5"},
    {U'w', "5.6 0,5 1.4,0 2.8,4.6 4.2,0 5.6,5"},
    {U'x', "3.7 0,5 3.7,0|3.7,5 0,0"},
    {U'y', "4 0,5 2,0.1|4,5 1.1,-2.1"},
    {U'z', "3.5 0,5 3.5,5 0,0 3.5,0"},
    {U'.', "0 0,0 0,0.15"},
    {U',', "0.4 0.3,0.2 0,-1.1"},
    {U':', "0 0,0 0,0.15|0,4 0,4.15"},
    {U';', "0.4 0.3,0.2 0,-1.1|0.3,4 0.3,4.15"},
    {U'-', "2 0,2.6 2,2.6"},
    {U'_', "4 0,-0.9 4,-0.9"},
    {U'+', "3.6 0,3 3.6,3|1.8,1.2 1.8,4.8"},
    {U'=', "3.6 0,2.1 3.6,2.1|0,4 3.6,4"},
    {U'/', "3.2 0,-0.8 3.2,7.6"},
    {U'(', "1.4 @3.8,3,3.8,6,130,230"},
    {U')', "1.4 @-2.4,3,3.8,6,50,-50"},
    {U'%', "6.4 @1.4,5.4,1.4,1.6,0,360|@5,1.6,1.4,1.6,0,360|5.1,7 1.3,0"},
    {U'\'', "0 0,7.2 0,5.4"},
    {U'#', "4.4 1.2,0 1.9,7|2.9,0 3.6,7|0,2.3 4.4,2.3|0.2,4.7 4.6,4.7"},
    {U'°', "1.8 @0.9,6.1,0.9,0.9,0,360"},
    {U'±', "3.6 0,3.7 3.6,3.7|1.8,2 1.8,5.4|0,0.6 3.6,0.6"},
    {U'×', "3 0,1.3 3,4.3|3,1.3 0,4.3"},
    {U'²', "2.2 @1.05,6,1.05,1.05,165,-35 0,3.5 2.2,3.5"},
    {U'−', "3.6 0,3 3.6,3"},
    {U'…', "4.8 0,0 0,0.15|2.4,0 2.4,0.15|4.8,0 4.8,0.15"},
    {U'μ', "3.8 0,5 0,-2.1|0,1.9 @1.9,1.9,1.9,1.9,180,360|3.8,5 3.8,0"},
    {U'θ', "3.8 @1.9,3.5,1.9,3.5,0,360|0,3.5 3.8,3.5"},
    {U'ρ', "4 0,-2.1 0,2.5|@2,2.5,2,2.5,0,360"},
    {U'σ', "4.4 @2,2.3,2,2.3,0,360|2,4.6 4.4,4.6"},
    {U'χ', "3.6 0,5 3.6,-2|3.6,5 0,-2"},
    {U'β', "3.9 0,-2.1 0,5.4 @1.7,5.4,1.7,1.7,180,-90 1.3,3.7|1.7,3.7 @1.8,1.85,2.1,1.85,90,-180"},
    {U'λ', "3.8 0.2,7.2 1,7.2 3.8,0|1.9,4.6 0,0"},
    {U'Δ', "5 0,0 2.5,7 5,0 0,0"},
};
constexpr std::string_view missing = "3.6 0,0 3.6,0 3.6,7 0,7 0,0";
constexpr double spacing = 1.5;  // between glyphs

// Not strtod, which follows the user's locale.
double number(std::string_view& text) {
    double value = 0;
    const char* end = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.starts_with(',')) text.remove_prefix(1);
    return value;
}

StrokeGlyph glyph_of(std::string_view text) {
    StrokeGlyph glyph;
    glyph.advance = number(text) + spacing;
    if (!text.empty()) glyph.lines.emplace_back();
    while (!text.empty()) {
        if (text.front() == ' ') {
            text.remove_prefix(1);
        } else if (text.front() == '|') {
            glyph.lines.emplace_back();
            text.remove_prefix(1);
        } else if (text.front() == '@') {
            text.remove_prefix(1);
            std::array<double, 6> arc{};
            for (double& value : arc) value = number(text);
            const int pieces = std::max(4, static_cast<int>(std::abs(arc[5] - arc[4]) / 12));
            for (int i = 0; i <= pieces; ++i) {
                const double angle =
                    (arc[4] + (arc[5] - arc[4]) * i / pieces) * 3.14159265358979323846 / 180;
                glyph.lines.back().push_back(
                    {arc[0] + arc[2] * std::cos(angle), arc[1] + arc[3] * std::sin(angle)});
            }
        } else {
            const double x = number(text);
            glyph.lines.back().push_back({x, number(text)});
        }
    }
    return glyph;
}

}  // namespace

const StrokeGlyph& stroke_glyph(char32_t code) {
    static const std::map<char32_t, StrokeGlyph> glyphs = [] {
        std::map<char32_t, StrokeGlyph> made;
        for (const Source& source : sources) made.emplace(source.code, glyph_of(source.strokes));
        return made;
    }();
    static const StrokeGlyph box = glyph_of(missing);
    const auto found = glyphs.find(code);
    return found == glyphs.end() ? box : found->second;
}

std::u32string unicode_of(std::string_view utf8) {
    std::u32string result;
    for (std::size_t i = 0; i < utf8.size();) {
        const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(utf8[at]); };
        const unsigned first = byte(i);
        const std::size_t length = first < 0x80                    ? 1
                                   : first >= 0xC2 && first < 0xE0 ? 2
                                   : first >= 0xE0 && first < 0xF0 ? 3
                                   : first >= 0xF0 && first < 0xF5 ? 4
                                                                   : 0;
        bool good = length > 0 && i + length <= utf8.size();
        char32_t code = length == 1 ? first : first & (0x7FU >> length);
        for (std::size_t k = 1; good && k < length; ++k) {
            good = (byte(i + k) & 0xC0U) == 0x80U;
            code = (code << 6U) | (byte(i + k) & 0x3FU);
        }
        result.push_back(good ? code : U'\uFFFD');
        i += good ? length : 1;
    }
    return result;
}

}  // namespace togishi
