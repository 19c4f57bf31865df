#include "steel/line_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace togishi {
namespace {

struct Step {
    std::ptrdiff_t columns;
    std::ptrdiff_t rows;
    float length;
};

// The half of the neighbourhood that a sweep with rising columns and rows has passed.
constexpr std::array<Step, 8> passed{{{-1, 0, 1.0F},
                                      {0, -1, 1.0F},
                                      {-1, -1, 1.41421F},
                                      {-1, 1, 1.41421F},
                                      {-1, -2, 2.23607F},
                                      {-1, 2, 2.23607F},
                                      {-2, -1, 2.23607F},
                                      {-2, 1, 2.23607F}}};

}  // namespace

FieldGrid distance_to_zero(const FieldGrid& field, float limit_mm) {
    FieldGrid out = field;
    const auto columns = static_cast<std::ptrdiff_t>(field.columns());
    const auto rows = static_cast<std::ptrdiff_t>(field.rows());
    const auto step = static_cast<float>(field.step());
    const auto value = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
        return field.column(static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
            i, 0, columns - 1)))[std::clamp<std::ptrdiff_t>(j, 0, rows - 1)];
    };
    // Cells that the line passes: the field over its slope. All others start far away.
    for (std::ptrdiff_t i = 0; i < columns; ++i) {
        const float* line = field.column(static_cast<std::size_t>(i));
        float* to = out.column(static_cast<std::size_t>(i));
        for (std::ptrdiff_t j = 0; j < rows; ++j) {
            const bool inside = line[j] > 0.0F;
            const bool beside =
                (value(i - 1, j) > 0.0F) != inside || (value(i + 1, j) > 0.0F) != inside ||
                (value(i, j - 1) > 0.0F) != inside || (value(i, j + 1) > 0.0F) != inside;
            to[j] = limit_mm;
            if (beside) {
                const float along = value(i + 1, j) - value(i - 1, j);
                const float up = value(i, j + 1) - value(i, j - 1);
                const float slope = 0.5F / step * std::sqrt(along * along + up * up);
                to[j] = std::min(std::abs(line[j]) / std::max(slope, 1e-6F), step);
            }
        }
    }
    const auto sweep = [&](bool forward) {
        const std::ptrdiff_t sign = forward ? 1 : -1;
        for (std::ptrdiff_t a = 0; a < columns; ++a) {
            const std::ptrdiff_t i = forward ? a : columns - 1 - a;
            float* to = out.column(static_cast<std::size_t>(i));
            for (std::ptrdiff_t b = 0; b < rows; ++b) {
                const std::ptrdiff_t j = forward ? b : rows - 1 - b;
                float best = to[j];
                for (const Step& s : passed) {
                    const std::ptrdiff_t ni = i + sign * s.columns;
                    const std::ptrdiff_t nj = j + sign * s.rows;
                    if (ni < 0 || ni >= columns || nj < 0 || nj >= rows) continue;
                    best = std::min(best,
                                    out.column(static_cast<std::size_t>(ni))[nj] + s.length * step);
                }
                to[j] = best;
            }
        }
    };
    sweep(true);
    sweep(false);
    for (std::ptrdiff_t i = 0; i < columns; ++i) {
        const float* line = field.column(static_cast<std::size_t>(i));
        float* to = out.column(static_cast<std::size_t>(i));
        for (std::ptrdiff_t j = 0; j < rows; ++j) {
            if (!(line[j] > 0.0F)) to[j] = -to[j];
        }
    }
    return out;
}

}  // namespace togishi
