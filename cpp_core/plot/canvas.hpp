// A picture with lines and text on it, without any library: the same on every system, also inside
// Blender, which brings no means to draw without a window.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace togishi {

/// 8-bit sRGB.
struct PlotColour {
    std::uint8_t r = 0, g = 0, b = 0;
};

/// In pixels, from the upper left corner.
struct PlotPoint {
    double x = 0, y = 0;
};

struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  ///< (height, width, 3), the top row first
};

enum class TextAlign { left, centre, right };

class Canvas {
  public:
    Canvas(int width, int height, PlotColour ground);

    /// What is drawn stays within this rectangle until the next call.
    void clip(double x0, double y0, double x1, double y1);
    void unclip();
    void fill(double x0, double y0, double x1, double y1, PlotColour colour);
    /// One line with round joints. dash: length of dashes and of gaps, 0: solid.
    void stroke(const std::vector<PlotPoint>& line, double width, PlotColour colour,
                double dash = 0);
    void disc(PlotPoint centre, double radius, PlotColour colour);
    void ring(PlotPoint centre, double radius, double width, PlotColour colour);
    /// The baseline begins (or has its middle, or ends) at the point. size: height of capitals.
    /// Characters that the font lacks become a box.
    void text(PlotPoint at, std::string_view utf8, double size, PlotColour colour,
              TextAlign align = TextAlign::left);
    [[nodiscard]] static double text_width(std::string_view utf8, double size);

    [[nodiscard]] Picture picture() const;

  private:
    void cover(PlotPoint a, PlotPoint b, double half_width);
    void blend(PlotColour colour);

    int width_, height_;
    int clip_x0_ = 0, clip_y0_ = 0, clip_x1_, clip_y1_;
    std::vector<float> rgb_;
    // How much of each pixel the current stroke covers: joints are not painted twice.
    std::vector<float> mask_;
    int dirty_x0_, dirty_y0_, dirty_x1_ = 0, dirty_y1_ = 0;
};

}  // namespace togishi
