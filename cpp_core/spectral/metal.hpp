// Metals: complex refractive indices n + ik as measured.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "spectral/grid.hpp"
#include "spectral/pchip.hpp"
#include "spectral/table_file.hpp"

namespace togishi {

/// n and k at the wavelengths of a grid.
struct RefractiveIndex {
    std::vector<double> n;
    std::vector<double> k;
};

class Metal {
  public:
    /// A table of kind "metal": wavelength_nm, n, k; n, k >= 0 and not both 0; at least two rows,
    /// from 400 nm or below to 700 nm or above. Throws InputError.
    explicit Metal(TableFile table);

    [[nodiscard]] std::string_view name() const { return table_.value("name"); }
    [[nodiscard]] const TableFile& table() const { return table_; }
    [[nodiscard]] double first_nm() const { return table_.columns[0].front(); }
    [[nodiscard]] double last_nm() const { return table_.columns[0].back(); }

    /// By PCHIP in wavelength. Throws InputError for a wavelength outside the measured range.
    [[nodiscard]] RefractiveIndex at(std::span<const double> wavelengths_nm) const;
    [[nodiscard]] RefractiveIndex at(const Grid& grid) const { return at(grid.wavelengths_nm()); }

  private:
    TableFile table_;
    Pchip n_;
    Pchip k_;
};

inline constexpr std::string_view default_metal = "iron_johnson_christy";

/// The built-in metals, the default first.
[[nodiscard]] const std::vector<std::shared_ptr<const Metal>>& builtin_metals();

/// A built-in name, or a file of the same format: a path, with or without "csv:" before it. Files
/// are kept until they change. Throws InputError; for an unknown name it lists those that exist.
[[nodiscard]] std::shared_ptr<const Metal> find_metal(std::string_view name);

}  // namespace togishi
