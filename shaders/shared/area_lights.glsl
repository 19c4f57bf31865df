// Lights of a certain size on the model's lobes. Its own list, behind shared/model.glsl: programs of scenes that have
// only point lights do not compile it.
#include "shared/area/gaussian_part.glsl"
#include "shared/area/gauss_nodes.glsl"
#include "shared/area/lobe_slices.glsl"
#include "shared/area/flat_light.glsl"
#include "shared/area/rectangle_light.glsl"
#include "shared/area/disk_light.glsl"
#include "shared/area/form_factor.glsl"
#include "shared/area/lamp.glsl"
#include "shared/area/lobe_filter.glsl"
#include "shared/area/environment_taps.glsl"
