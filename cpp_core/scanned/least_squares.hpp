// Linear least squares by normal equations, for few unknowns.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace togishi {

/// Solves a symmetric positive matrix, n x n row by row, of which the lower triangle is read, by
/// Cholesky's factors in its place; x: the right side, then the solution. False where a pivot does
/// not exceed that share of its diagonal.
inline bool solve_positive(double* matrix, double* x, std::size_t n, double least_share) {
    for (std::size_t j = 0; j < n; ++j) {
        const double diagonal = matrix[j * n + j];
        for (std::size_t i = j; i < n; ++i) {
            double sum = matrix[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= matrix[i * n + k] * matrix[j * n + k];
            if (i == j) {
                if (!(sum > least_share * diagonal)) return false;
                matrix[j * n + j] = std::sqrt(sum);
            } else {
                matrix[i * n + j] = sum / matrix[j * n + j];
            }
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) x[i] -= matrix[i * n + k] * x[k];
        x[i] /= matrix[i * n + i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) x[i] -= matrix[k * n + i] * x[k];
        x[i] /= matrix[i * n + i];
    }
    return true;
}

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
        std::array<double, N* N> matrix = matrix_;
        x = right_;
        return solve_positive(matrix.data(), x.data(), N, 1e-11);
    }

  private:
    std::array<double, N * N> matrix_{};  // lower triangle
    std::array<double, N> right_{};
};

}  // namespace togishi
