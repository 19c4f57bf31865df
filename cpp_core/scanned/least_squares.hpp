// Linear least squares by normal equations, for few unknowns.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace togishi {

/// N unknowns of about equal scale. add() rows, then solve().
template <std::size_t N>
class LeastSquares {
  public:
    void add(const std::array<double, N>& row, double value, double weight = 1) {
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t j = 0; j <= i; ++j) matrix_[i * N + j] += weight * row[i] * row[j];
            right_[i] += weight * row[i] * value;
        }
    }
    /// False where the rows do not determine every unknown.
    [[nodiscard]] bool solve(std::array<double, N>& x) const {
        std::array<double, N* N> l = matrix_;
        for (std::size_t j = 0; j < N; ++j) {
            for (std::size_t i = j; i < N; ++i) {
                double sum = l[i * N + j];
                for (std::size_t k = 0; k < j; ++k) sum -= l[i * N + k] * l[j * N + k];
                if (i == j) {
                    if (!(sum > 1e-11 * matrix_[j * N + j])) return false;
                    l[j * N + j] = std::sqrt(sum);
                } else {
                    l[i * N + j] = sum / l[j * N + j];
                }
            }
        }
        x = right_;
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t k = 0; k < i; ++k) x[i] -= l[i * N + k] * x[k];
            x[i] /= l[i * N + i];
        }
        for (std::size_t i = N; i-- > 0;) {
            for (std::size_t k = i + 1; k < N; ++k) x[i] -= l[k * N + i] * x[k];
            x[i] /= l[i * N + i];
        }
        return true;
    }

  private:
    std::array<double, N * N> matrix_{};  // lower triangle
    std::array<double, N> right_{};
};

}  // namespace togishi
