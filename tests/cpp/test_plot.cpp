// Pictures of a fit: what is drawn where, and that nothing is drawn outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.hpp"
#include "plot/fit_plot.hpp"
#include "plot/stroke_font.hpp"
#include "scan/simulate_scan.hpp"

namespace togishi {
namespace {

constexpr PlotColour white{255, 255, 255}, black{0, 0, 0};

int red_at(const Picture& picture, int x, int y) {
    return picture.rgb[static_cast<std::size_t>(3 * (y * picture.width + x))];
}

// How much black there is, in pixels.
double inked(const Picture& picture) {
    double sum = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3) sum += 255 - picture.rgb[i];
    return sum / 255;
}

TEST(Canvas, AStrokeCoversItsLengthTimesItsWidth) {
    for (const double angle : {0.0, 0.3, 0.9, 1.5707963}) {
        for (const double width : {0.5, 1.0, 3.0, 8.0}) {
            Canvas canvas(200, 200, white);
            canvas.stroke({{100 - 60 * std::cos(angle), 100 - 60 * std::sin(angle)},
                           {100 + 60 * std::cos(angle), 100 + 60 * std::sin(angle)}},
                          width, black);
            // Round ends reach half a width further.
            const double area = 120 * width + 0.785 * width * width;
            EXPECT_NEAR(inked(canvas.picture()), area, 0.06 * area + 2) << angle << ' ' << width;
        }
    }
}

TEST(Canvas, JointsAreNotPaintedTwice) {
    Canvas one(100, 40, white), many(100, 40, white);
    one.stroke({{10, 20}, {90, 20}}, 3.5, PlotColour{100, 100, 100});
    std::vector<PlotPoint> line;
    for (int i = 0; i <= 160; ++i) line.push_back({10 + 0.5 * i, 20});
    many.stroke(line, 3.5, PlotColour{100, 100, 100});
    EXPECT_EQ(one.picture().rgb, many.picture().rgb);
}

TEST(Canvas, HalfOfADashedLineIsThere) {
    Canvas canvas(400, 20, white);
    std::vector<PlotPoint> line;
    for (int i = 0; i <= 380; ++i) line.push_back({10.0 + i, 10});
    canvas.stroke(line, 2, black, 10);
    // Round ends lengthen each dash by a width.
    EXPECT_NEAR(inked(canvas.picture()), 19 * (10 * 2 + 3.1), 40);
    EXPECT_EQ(red_at(canvas.picture(), 15, 10), 0);
    EXPECT_EQ(red_at(canvas.picture(), 25, 10), 255);
}

TEST(Canvas, NothingOutsideTheClipAndNothingOfNaN) {
    Canvas canvas(60, 60, white);
    canvas.clip(20, 20, 40, 40);
    canvas.stroke({{-1e9, 30}, {1e9, 30}}, 4, black);
    const Picture picture = canvas.picture();
    EXPECT_EQ(red_at(picture, 30, 30), 0);
    EXPECT_EQ(red_at(picture, 19, 30), 255);
    EXPECT_EQ(red_at(picture, 40, 30), 255);
    canvas.unclip();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    canvas.stroke({{nan, 10}, {10, 10}, {std::numeric_limits<double>::infinity(), 10}}, 4, black);
    EXPECT_EQ(canvas.picture().rgb, picture.rgb);
}

TEST(Canvas, TextIsAsWideAsItSaysAndAligned) {
    for (const TextAlign align : {TextAlign::left, TextAlign::centre, TextAlign::right}) {
        Canvas canvas(400, 60, white);
        canvas.text({200, 40}, "H\u03bc 8.0\u00b0 H", 20, black, align);
        const Picture picture = canvas.picture();
        int first = 400, last = 0;
        for (int x = 0; x < 400; ++x) {
            for (int y = 0; y < 60; ++y) {
                if (red_at(picture, x, y) > 100) continue;
                first = std::min(first, x);
                last = std::max(last, x);
            }
        }
        const double width = Canvas::text_width("H\u03bc 8.0\u00b0 H", 20);
        const double left = 200 - width * (align == TextAlign::left     ? 0
                                           : align == TextAlign::centre ? 0.5
                                                                        : 1);
        EXPECT_NEAR(first, left, 2.5);
        // Behind the last glyph stands its spacing.
        EXPECT_NEAR(last, left + width - 4, 3.5);
    }
}

TEST(StrokeFont, EveryCharacterOfTheFormulasIsThere) {
    const StrokeGlyph& box = stroke_glyph(U'\uFFFD');
    for (const char32_t code : std::u32string(
             U"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
             U".,:;+-=/()%\u00b0\u00b1\u00d7\u00b2\u03bc\u03b8\u03c1\u03c3\u03c7\u03b2_'#")) {
        const StrokeGlyph& glyph = stroke_glyph(code);
        EXPECT_NE(&glyph, &box) << static_cast<unsigned>(code);
        ASSERT_FALSE(glyph.lines.empty());
        for (const auto& line : glyph.lines) {
            ASSERT_GE(line.size(), 2U) << static_cast<unsigned>(code);
            for (const PlotPoint& p : line) {
                EXPECT_GE(p.x, -0.4);
                EXPECT_LE(p.x, glyph.advance);
                EXPECT_GE(p.y, -2.5);
                EXPECT_LE(p.y, 8);
            }
        }
    }
}

TEST(StrokeFont, BrokenUtf8BecomesBoxes) {
    EXPECT_EQ(unicode_of("a\u00b0\u03bc"), U"a\u00b0\u03bc");
    EXPECT_EQ(unicode_of("\xff"
                         "a\xc3"),
              U"\uFFFDa\uFFFD");
    EXPECT_EQ(unicode_of("\xe2\x82"), U"\uFFFD\uFFFD");
}

Fit some_fit(const std::vector<double>& turns_deg = {0, 45}) {
    Material material = default_material();
    material.ha.mu_t_deg = 4;
    material.ha.mu_b_deg = 2.5;
    SimulationOptions options;
    options.channels = {"intensity_550nm"};
    options.protocol.step_deg = 2;
    options.protocol.turns_deg = turns_deg;
    return fit_scans(simulate_scan(material, ScanPart::hamon, options, 1));
}

TEST(FitPlot, SizesFollowTheScaleAndBadScalesAreRefused) {
    const Fit fit = some_fit();
    const Picture full = plot_scans(fit), half = plot_scans(fit, 0.5);
    EXPECT_EQ(full.width, 1600);
    EXPECT_EQ(half.width, 800);
    EXPECT_NEAR(full.height, 2 * half.height, 2);
    EXPECT_EQ(plot_mu_eff(fit, 2).width, 2000);
    for (const double scale : {0.0, 5.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_THROW((void)plot_scans(fit, scale), InputError);
        EXPECT_THROW((void)plot_mu_eff(fit, scale), InputError);
    }
}

TEST(FitPlot, GapsOutliersAndManyScansAreDrawn) {
    Fit fit = some_fit();
    fit.fitted[0].state[3] = ReadingState::outlier;
    fit.scans.scans[1].intensity[5] = std::numeric_limits<double>::quiet_NaN();
    fit.fitted[1].state[5] = ReadingState::gap;
    const Picture few = plot_scans(fit);
    // A reading that was left out is ringed in red.
    std::size_t red = 0;
    for (std::size_t i = 0; i < few.rgb.size(); i += 3)
        red += few.rgb[i] > few.rgb[i + 1] + 80 ? 1 : 0;
    EXPECT_GT(red, 10U);
    std::vector<double> turns;
    for (int i = 0; i < 30; ++i) turns.push_back(6 * i);
    fit = some_fit(turns);
    const Picture many = plot_scans(fit);
    EXPECT_EQ(many.width, 1600);
    EXPECT_LT(many.height, 3000);
}

}  // namespace
}  // namespace togishi
