// The formulas of normal maps (shaders/shared/detail/normal_map.glsl), compiled for the CPU
// beside the model: togishi::f32 as the GPU computes them, togishi::f64.
#pragma once
#include "brdf/model.hpp"

#define TG_FN inline
#define TG_PRECISE

namespace togishi::f32 {
#include "shared/detail/normal_map.glsl"
}  // namespace togishi::f32

#define TG_DOUBLE
#define float double
#define vec2 dvec2
#define vec3 dvec3
#define vec4 dvec4
namespace togishi::f64 {
#include "shared/detail/normal_map.glsl"
}  // namespace togishi::f64
#undef float
#undef vec2
#undef vec3
#undef vec4
#undef TG_DOUBLE
#undef TG_PRECISE
#undef TG_FN
