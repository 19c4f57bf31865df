// The hada: steel folded many times, its layers bent by forging and cut by the polished surface.
//
// A layer coordinate w = slope of the cut times height + smooth warps; the surface shows w's
// contour lines. No warp: masame; a wave: ayasugi; irregular warps: itame; burls: mokume; many fine
// folds: nashiji. Each layer differs a little in carbon and slag, so its roughness differs; a few
// layers are bold.
#pragma once
#include <cstdint>

#include "steel/steel_parameters.hpp"

namespace togishi {

struct HadaSample {
    float tone = 0;  ///< mean 0, standard deviation about 0.45: rougher (+) or finer layers
    float layer =
        0;         ///< the layer coordinate, for lines that follow the grain (sunagashi, kinsuji)
    float ds = 0;  ///< gradient of `layer` per mm
    float dq = 0;
};

class Hada {
  public:
    Hada(HadaStyle style, double scale, std::uint64_t seed);
    /// At (s, y) in mm on the developed surface, averaged over a footprint of (footprint_s,
    /// footprint_y) mm.
    [[nodiscard]] HadaSample at(double s, double y, float footprint_s, float footprint_y) const;

  private:
    struct Warp {
        double amplitude_mm = 0;
        double length_mm = 1;
        double height_mm = 1;
    };
    HadaStyle style_;
    double scale_;
    std::uint32_t seed_;
    double cut_ = 1;  // layers' height per mm of surface
    Warp warps_[3];
    double wave_mm_ = 0;
    double wave_length_mm_ = 1;
    double layers_per_mm_ = 1;
};

}  // namespace togishi
