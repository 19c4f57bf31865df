#include "steel/field_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.hpp"

namespace togishi {
namespace {

struct Spline {
    std::array<float, 4> weight;
    std::array<float, 4> slope;
};

Spline spline_at(float t) {
    const float u = 1.0F - t;
    const float t2 = t * t;
    const float u2 = u * u;
    constexpr float sixth = 1.0F / 6.0F;
    return {{u2 * u * sixth, (3.0F * t2 * t - 6.0F * t2 + 4.0F) * sixth,
             (3.0F * u2 * u - 6.0F * u2 + 4.0F) * sixth, t2 * t * sixth},
            {-0.5F * u2, 1.5F * t2 - 2.0F * t, 2.0F * u - 1.5F * u2, 0.5F * t2}};
}

std::vector<float> gaussian_weights(double sigma_steps) {
    const auto reach = static_cast<std::size_t>(std::ceil(3.2 * sigma_steps));
    std::vector<float> weights(2 * reach + 1);
    double sum = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const double x = static_cast<double>(i) - static_cast<double>(reach);
        const double w = std::exp(-0.5 * x * x / std::max(sigma_steps * sigma_steps, 1e-12));
        weights[i] = static_cast<float>(w);
        sum += w;
    }
    for (float& w : weights) w = static_cast<float>(w / sum);
    return weights;
}

}  // namespace

FieldSample FieldGrid::sample(double s, double q) const {
    const double last_x = static_cast<double>(columns_ - 1);
    const double last_y = static_cast<double>(rows_ - 1);
    const double x = std::clamp((s - s0_) / step_, 0.0, last_x);
    const double y = std::clamp((q - q0_) / step_, 0.0, last_y);
    const auto ix = static_cast<std::ptrdiff_t>(x);
    const auto iy = static_cast<std::ptrdiff_t>(y);
    const Spline across = spline_at(static_cast<float>(x - static_cast<double>(ix)));
    const Spline up = spline_at(static_cast<float>(y - static_cast<double>(iy)));
    const auto columns = static_cast<std::ptrdiff_t>(columns_);
    const auto rows = static_cast<std::ptrdiff_t>(rows_);
    const bool inside = ix >= 1 && iy >= 1 && ix + 2 < columns && iy + 2 < rows;
    FieldSample result;
    for (std::ptrdiff_t i = 0; i < 4; ++i) {
        const std::ptrdiff_t cx =
            inside ? ix + i - 1 : std::clamp<std::ptrdiff_t>(ix + i - 1, 0, columns - 1);
        const float* line = values_.data() + cx * rows;
        float value = 0;
        float slope = 0;
        for (std::ptrdiff_t j = 0; j < 4; ++j) {
            const std::ptrdiff_t cy =
                inside ? iy + j - 1 : std::clamp<std::ptrdiff_t>(iy + j - 1, 0, rows - 1);
            value += up.weight[static_cast<std::size_t>(j)] * line[cy];
            slope += up.slope[static_cast<std::size_t>(j)] * line[cy];
        }
        result.value += across.weight[static_cast<std::size_t>(i)] * value;
        result.ds += across.slope[static_cast<std::size_t>(i)] * value;
        result.dq += across.weight[static_cast<std::size_t>(i)] * slope;
    }
    const auto per_mm = static_cast<float>(1.0 / step_);
    result.ds *= per_mm;
    result.dq *= per_mm;
    return result;
}

void FieldGrid::diffuse(double sigma_s_mm, double sigma_q_mm, unsigned threads) {
    const std::vector<float> up = gaussian_weights(sigma_q_mm / step_);
    const std::vector<float> along = gaussian_weights(sigma_s_mm / step_);
    const auto up_reach = static_cast<std::ptrdiff_t>(up.size() / 2);
    const auto along_reach = static_cast<std::ptrdiff_t>(along.size() / 2);
    const auto rows = static_cast<std::ptrdiff_t>(rows_);
    const auto columns = static_cast<std::ptrdiff_t>(columns_);
    parallel_for(
        columns_, 64,
        [&](std::size_t begin, std::size_t end) {
            std::vector<float> padded(rows_ + up.size());
            for (std::size_t i = begin; i < end; ++i) {
                float* line = column(i);
                for (std::ptrdiff_t j = -up_reach; j < rows + up_reach; ++j) {
                    padded[static_cast<std::size_t>(j + up_reach)] =
                        line[std::clamp<std::ptrdiff_t>(j, 0, rows - 1)];
                }
                for (std::size_t j = 0; j < rows_; ++j) {
                    float sum = 0;
                    for (std::size_t k = 0; k < up.size(); ++k) sum += up[k] * padded[j + k];
                    line[j] = sum;
                }
            }
        },
        threads);
    std::vector<float> blurred(values_.size());
    parallel_for(
        columns_, 64,
        [&](std::size_t begin, std::size_t end) {
            for (auto i = static_cast<std::ptrdiff_t>(begin); i < static_cast<std::ptrdiff_t>(end);
                 ++i) {
                float* out = blurred.data() + i * rows;
                for (std::ptrdiff_t k = -along_reach; k <= along_reach; ++k) {
                    const float weight = along[static_cast<std::size_t>(k + along_reach)];
                    const float* in =
                        values_.data() + std::clamp<std::ptrdiff_t>(i + k, 0, columns - 1) * rows;
                    for (std::ptrdiff_t j = 0; j < rows; ++j) out[j] += weight * in[j];
                }
            }
        },
        threads);
    values_ = std::move(blurred);
}

}  // namespace togishi
