// The formulas of lights that have a size (shaders/shared/area_lights.glsl), compiled for the CPU
// beside the model: togishi::f32 as the GPU computes them, togishi::f64.
#pragma once
#include "brdf/model.hpp"

#include "brdf/glsl_begin.inc"

namespace togishi::f32 {
#include "shared/area_lights.glsl"
}  // namespace togishi::f32

#include "brdf/glsl_in_double.inc"
namespace togishi::f64 {
// Read again on purpose, now in double. NOLINTNEXTLINE(readability-duplicate-include)
#include "shared/area_lights.glsl"
}  // namespace togishi::f64
#include "brdf/glsl_end.inc"
