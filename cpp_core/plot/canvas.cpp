#include "plot/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "plot/stroke_font.hpp"

namespace togishi {
namespace {

double distance_to_segment(PlotPoint p, PlotPoint a, PlotPoint b) {
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double length2 = dx * dx + dy * dy;
    const double along =
        length2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
    return std::hypot(p.x - a.x - along * dx, p.y - a.y - along * dy);
}

// Coordinates far outside the picture stay where a line from there still has its direction.
double bounded(double value) {
    return std::clamp(value, -1e6, 1e6);
}

}  // namespace

Canvas::Canvas(int width, int height, PlotColour ground)
    : width_(width),
      height_(height),
      clip_x1_(width),
      clip_y1_(height),
      rgb_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3),
      mask_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      dirty_x0_(width),
      dirty_y0_(height) {
    fill(0, 0, width, height, ground);
}

void Canvas::clip(double x0, double y0, double x1, double y1) {
    clip_x0_ = std::clamp(static_cast<int>(std::lround(x0)), 0, width_);
    clip_y0_ = std::clamp(static_cast<int>(std::lround(y0)), 0, height_);
    clip_x1_ = std::clamp(static_cast<int>(std::lround(x1)), 0, width_);
    clip_y1_ = std::clamp(static_cast<int>(std::lround(y1)), 0, height_);
}

void Canvas::unclip() {
    clip(0, 0, width_, height_);
}

void Canvas::fill(double x0, double y0, double x1, double y1, PlotColour colour) {
    const int left = std::max(clip_x0_, static_cast<int>(std::lround(x0)));
    const int right = std::min(clip_x1_, static_cast<int>(std::lround(x1)));
    const int top = std::max(clip_y0_, static_cast<int>(std::lround(y0)));
    const int bottom = std::min(clip_y1_, static_cast<int>(std::lround(y1)));
    for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
            float* pixel =
                &rgb_[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                           static_cast<std::size_t>(x))];
            pixel[0] = colour.r;
            pixel[1] = colour.g;
            pixel[2] = colour.b;
        }
    }
}

void Canvas::cover(PlotPoint a, PlotPoint b, double half_width) {
    if (!(std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(b.x) && std::isfinite(b.y)))
        return;
    a = {bounded(a.x), bounded(a.y)};
    b = {bounded(b.x), bounded(b.y)};
    const double reach = half_width + 1;
    const auto from = [&](double low, int least) {
        return std::max(least, static_cast<int>(std::floor(low - reach)));
    };
    const auto to = [&](double high, int most) {
        return std::min(most, static_cast<int>(std::ceil(high + reach)) + 1);
    };
    const int x0 = from(std::min(a.x, b.x), clip_x0_), x1 = to(std::max(a.x, b.x), clip_x1_);
    const int y0 = from(std::min(a.y, b.y), clip_y0_), y1 = to(std::max(a.y, b.y), clip_y1_);
    if (x0 >= x1 || y0 >= y1) return;
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            const double far = distance_to_segment({x + 0.5, y + 0.5}, a, b);
            // A line thinner than a pixel is fainter, not thinner.
            const double share =
                std::clamp(half_width + 0.5 - far, 0.0, std::min(1.0, 2 * half_width));
            float& covered = mask_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                   static_cast<std::size_t>(x)];
            covered = std::max(covered, static_cast<float>(share));
        }
    }
    dirty_x0_ = std::min(dirty_x0_, x0);
    dirty_y0_ = std::min(dirty_y0_, y0);
    dirty_x1_ = std::max(dirty_x1_, x1);
    dirty_y1_ = std::max(dirty_y1_, y1);
}

void Canvas::blend(PlotColour colour) {
    for (int y = dirty_y0_; y < dirty_y1_; ++y) {
        for (int x = dirty_x0_; x < dirty_x1_; ++x) {
            const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                   static_cast<std::size_t>(x);
            const float share = mask_[at];
            if (share <= 0) continue;
            mask_[at] = 0;
            rgb_[3 * at] += share * (static_cast<float>(colour.r) - rgb_[3 * at]);
            rgb_[3 * at + 1] += share * (static_cast<float>(colour.g) - rgb_[3 * at + 1]);
            rgb_[3 * at + 2] += share * (static_cast<float>(colour.b) - rgb_[3 * at + 2]);
        }
    }
    dirty_x0_ = width_;
    dirty_y0_ = height_;
    dirty_x1_ = dirty_y1_ = 0;
}

void Canvas::stroke(const std::vector<PlotPoint>& line, double width, PlotColour colour,
                    double dash) {
    double walked = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const PlotPoint a = line[i], b = line[i + 1];
        const double length = std::hypot(b.x - a.x, b.y - a.y);
        if (dash <= 0 || !(length < 1e5)) {
            cover(a, b, width / 2);
            continue;
        }
        for (double at = 0; at < length;) {
            const double phase = std::fmod(walked + at, 2 * dash);
            const bool drawn = phase < dash;
            // Never less than a hundredth of a pixel: rounding must not stop the walk.
            const double step =
                std::min(length - at, std::max(0.01, (drawn ? dash : 2 * dash) - phase));
            if (drawn) {
                const auto point = [&](double s) {
                    return PlotPoint{a.x + (b.x - a.x) * s / length,
                                     a.y + (b.y - a.y) * s / length};
                };
                cover(point(at), point(at + step), width / 2);
            }
            at += step;
        }
        walked = std::fmod(walked + length, 2 * dash);
    }
    blend(colour);
}

void Canvas::disc(PlotPoint centre, double radius, PlotColour colour) {
    cover(centre, centre, radius);
    blend(colour);
}

void Canvas::ring(PlotPoint centre, double radius, double width, PlotColour colour) {
    constexpr int sides = 48;
    std::vector<PlotPoint> line;
    for (int i = 0; i <= sides; ++i) {
        const double angle = 6.283185307179586 * i / sides;
        line.push_back({centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle)});
    }
    stroke(line, width, colour);
}

void Canvas::text(PlotPoint at, std::string_view utf8, double size, PlotColour colour,
                  TextAlign align) {
    if (align != TextAlign::left)
        at.x -= text_width(utf8, size) * (align == TextAlign::right ? 1.0 : 0.5);
    const double unit = size / stroke_font_cap_height;
    const double half_width = std::max(0.55, 0.055 * size);
    for (const char32_t code : unicode_of(utf8)) {
        const StrokeGlyph& glyph = stroke_glyph(code);
        for (const auto& line : glyph.lines) {
            for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                cover({at.x + unit * line[i].x, at.y - unit * line[i].y},
                      {at.x + unit * line[i + 1].x, at.y - unit * line[i + 1].y}, half_width);
            }
        }
        at.x += unit * glyph.advance;
    }
    blend(colour);
}

double Canvas::text_width(std::string_view utf8, double size) {
    double width = 0;
    for (const char32_t code : unicode_of(utf8)) width += stroke_glyph(code).advance;
    return width * size / stroke_font_cap_height;
}

Picture Canvas::picture() const {
    Picture result{width_, height_, std::vector<std::uint8_t>(rgb_.size())};
    std::transform(rgb_.begin(), rgb_.end(), result.rgb.begin(), [](float value) {
        return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 255.0F)));
    });
    return result;
}

}  // namespace togishi
