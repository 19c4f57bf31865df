// Lights of a certain size on the model's lobes. Its own list, behind shared/model.glsl: programs of scenes that have
// only point lights do not compile it.
#include "shared/gaussian_part.glsl"
#include "shared/gauss_nodes.glsl"
#include "shared/lobe_slices.glsl"
#include "shared/flat_light.glsl"
#include "shared/rectangle_light.glsl"
#include "shared/disk_light.glsl"
#include "shared/lobe_filter.glsl"
#include "shared/environment_taps.glsl"
