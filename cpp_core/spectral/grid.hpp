// Equally spaced wavelengths.
#pragma once
#include <cstddef>
#include <vector>

namespace togishi {

struct Grid {
    double first_nm = 400.0;
    double step_nm = 5.0;
    std::size_t count = 61;

    [[nodiscard]] double wavelength_nm(std::size_t i) const {
        return first_nm + step_nm * static_cast<double>(i);
    }
    [[nodiscard]] double last_nm() const { return wavelength_nm(count - 1); }
    [[nodiscard]] std::vector<double> wavelengths_nm() const {
        std::vector<double> all(count);
        for (std::size_t i = 0; i < count; ++i) all[i] = wavelength_nm(i);
        return all;
    }
    friend bool operator==(const Grid&, const Grid&) = default;
};

/// The model's 61 samples, 400 to 700 nm.
inline constexpr Grid grid_61{400.0, 5.0, 61};
/// The reference: the whole range of the CIE observers at 1 nm.
inline constexpr Grid grid_full{360.0, 1.0, 471};

}  // namespace togishi
