// Fresnel reflectance of a metal as each channel of a scan sees it, tabulated over the cosine.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "scan/scan.hpp"

namespace togishi {

/// A value and its slope.
struct Reflectance {
    double value, by_cosine;
};

class ReflectanceTable {
  public:
    /// Throws InputError for an unknown metal or light, and a channel that sees nothing of the
    /// light.
    ReflectanceTable(const std::string& metal, const std::string& light,
                     const std::vector<ScanChannel>& channels);

    /// cosine in [0, 1]. Error: 1e-7.
    [[nodiscard]] Reflectance at(std::size_t channel, double cosine) const;

  private:
    std::vector<std::vector<double>> rows_;  // [channel][i], i over the cosine
};

}  // namespace togishi
