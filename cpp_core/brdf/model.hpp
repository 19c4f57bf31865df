// The reflection model of shaders/shared, compiled for the CPU: togishi::f32 as the GPU computes
// it, togishi::f64 as the reference. The GLSL files are the documentation of each function.
#pragma once
#include <glm/glm.hpp>

#define TG_FN inline
#define TG_PRECISE

namespace togishi::f32 {
using namespace glm;
#include "shared/model.glsl"
}  // namespace togishi::f32

// The same text in double precision.
#define TG_DOUBLE
#define float double
#define vec2 dvec2
#define vec3 dvec3
#define vec4 dvec4
namespace togishi::f64 {
using namespace glm;
#include "shared/model.glsl"
}  // namespace togishi::f64
#undef float
#undef vec2
#undef vec3
#undef vec4
#undef TG_DOUBLE
#undef TG_PRECISE
#undef TG_FN
