// The dimensions of a fitted blade, as registers and appraisers measure them.
#pragma once
#include <string>
#include <vector>

#include "scanned/blade_fit.hpp"

namespace togishi {

struct FitMeasure {
    std::string name;
    double value = 0;
    /// rms of the cross-sections about the line that it is read from; 0: it is read from none.
    double scatter = 0;
};

/// By name, in the order in which a catalogue gives them; mm. Only what the blade has.
[[nodiscard]] std::vector<FitMeasure> measure_fit(const BladeFit& fit);

}  // namespace togishi
