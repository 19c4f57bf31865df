// The reflection model of shaders/shared, compiled for the CPU: togishi::f32 as the GPU computes
// it, togishi::f64 as the reference. The GLSL files are the documentation of each function.
#pragma once
#include <glm/glm.hpp>

#include "brdf/glsl_begin.inc"

namespace togishi::f32 {
using namespace glm;
#include "shared/model.glsl"
}  // namespace togishi::f32

#include "brdf/glsl_in_double.inc"
namespace togishi::f64 {
using namespace glm;
// Read again on purpose, now in double. NOLINTNEXTLINE(readability-duplicate-include)
#include "shared/model.glsl"
}  // namespace togishi::f64
#include "brdf/glsl_end.inc"
