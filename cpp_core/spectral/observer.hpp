// The CIE standard observers: colour-matching functions.
#pragma once
#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "spectral/grid.hpp"
#include "spectral/table_file.hpp"

namespace togishi {

class Observer {
  public:
    /// A table of kind "observer": wavelength_nm, x_bar, y_bar, z_bar, all >= 0.
    explicit Observer(TableFile table);

    [[nodiscard]] std::string_view name() const { return table_.value("name"); }
    [[nodiscard]] const TableFile& table() const { return table_; }
    /// x_bar, y_bar, z_bar at the wavelengths of a grid; linear between the 1 nm rows, 0 outside.
    [[nodiscard]] std::array<std::vector<double>, 3> at(const Grid& grid) const;
    /// The same on grid_full, which every light is weighed on.
    [[nodiscard]] const std::array<std::vector<double>, 3>& on_full() const { return on_full_; }

  private:
    TableFile table_;
    std::array<std::vector<double>, 3> on_full_;
};

inline constexpr std::string_view default_observer = "cie1931_2";

/// CIE 1931 2 degrees (the default), CIE 1964 10 degrees.
[[nodiscard]] const std::vector<std::shared_ptr<const Observer>>& builtin_observers();
/// Throws InputError listing the names that exist.
[[nodiscard]] std::shared_ptr<const Observer> find_observer(std::string_view name);

}  // namespace togishi
