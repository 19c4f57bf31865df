// A smooth scalar field over one side of the blade, on a lattice of fixed millimetres: the quench
// is computed at one resolution, whatever the resolution of the map that is made from it.
#pragma once
#include <cstddef>
#include <vector>

namespace togishi {

/// Value and gradient (per mm) of a field.
struct FieldSample {
    float value = 0;
    float ds = 0;
    float dq = 0;
};

/// Columns of constant s, each from the edge upwards: value(i, j) at s = s0 + i step, q = q0 + j
/// step (mm).
class FieldGrid {
  public:
    FieldGrid() = default;
    FieldGrid(double s0, double q0, double step, std::size_t columns, std::size_t rows)
        : s0_(s0), q0_(q0), step_(step), columns_(columns), rows_(rows), values_(columns * rows) {}

    [[nodiscard]] std::size_t columns() const { return columns_; }
    [[nodiscard]] std::size_t rows() const { return rows_; }
    [[nodiscard]] double step() const { return step_; }
    [[nodiscard]] double s_of(std::size_t i) const { return s0_ + static_cast<double>(i) * step_; }
    [[nodiscard]] double q_of(std::size_t j) const { return q0_ + static_cast<double>(j) * step_; }
    [[nodiscard]] float* column(std::size_t i) { return values_.data() + i * rows_; }
    [[nodiscard]] const float* column(std::size_t i) const { return values_.data() + i * rows_; }

    /// Uniform cubic B-spline through the lattice values as control points: smooth to the second
    /// derivative, at the price of a blur of 0.6 steps. Outside, the border's value.
    [[nodiscard]] FieldSample sample(double s, double q) const;

    /// Replaces the field by its convolution with a Gaussian of these standard deviations.
    void diffuse(double sigma_s_mm, double sigma_q_mm, unsigned threads);

  private:
    double s0_ = 0;
    double q0_ = 0;
    double step_ = 1;
    std::size_t columns_ = 0;
    std::size_t rows_ = 0;
    std::vector<float> values_;
};

}  // namespace togishi
