// Property maps of a blade, made as the patterns themselves arise: clay, quench, folded layers,
// polish.
//
// Everything is a function of millimetres and the seed. Maps of one blade at two sizes agree where
// their texels are averaged, nothing repeats along the blade, and results do not depend on the
// number of threads.
#pragma once
#include <functional>
#include <stdexcept>

#include "blade/frame.hpp"
#include "brdf/material.hpp"
#include "brdf/property_maps.hpp"
#include "steel/steel_parameters.hpp"

namespace togishi {

/// Called from the caller's own thread with the share done, in [0, 1]; returning false cancels.
using SteelProgress = std::function<bool(double)>;

/// Thrown by steel_pattern where `progress` returned false.
class SteelCancelled : public std::runtime_error {
  public:
    SteelCancelled() : std::runtime_error("steel pattern: cancelled") {}
};

/// The material's lobes are the means that the pattern varies; its hadori lobe is no part of the
/// maps. Maps of width x height texels over the frame's chart (v = 0.5 is the mune ridge). w: share
/// of hardened steel; h: hadori, of the rest. Both are 0 in the nakago. Where w > 0.5 the part is
/// ha (body) or boshi (kissaki). Throws InputError for parameters, lobes or sizes out of range (1 x
/// 1 to 65536 x 65536), SteelCancelled. threads: 0 takes as many as the machine has.
[[nodiscard]] PropertyMaps steel_pattern(const BladeFrame& frame, const Material& material,
                                         const SteelParameters& parameters, std::size_t width,
                                         std::size_t height, const SteelProgress& progress = {},
                                         unsigned threads = 0);

}  // namespace togishi
