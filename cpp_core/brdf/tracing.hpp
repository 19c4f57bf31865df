// Rays against surfaces (shaders/shared/trace), compiled for the CPU beside the model. The texels
// that they read are those that `tree_texels` points to, in this thread.
#pragma once
#include "brdf/model.hpp"

namespace togishi {
/// RayTree's nodes and triangles in one row, as the GPU's texture has them. The caller keeps them.
inline thread_local const glm::vec4* tree_texels = nullptr;
}  // namespace togishi

#define TG_TREE_TEXEL(i) vec4(tree_texels[i])
#include "brdf/glsl_begin.inc"

namespace togishi::f32 {
#include "shared/trace/ray_tree.glsl"
}  // namespace togishi::f32

#include "brdf/glsl_in_double.inc"
namespace togishi::f64 {
// Read again on purpose, now in double. NOLINTNEXTLINE(readability-duplicate-include)
#include "shared/trace/ray_tree.glsl"
}  // namespace togishi::f64
#include "brdf/glsl_end.inc"
#undef TG_TREE_TEXEL
