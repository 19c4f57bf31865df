// Mip levels of property maps by covariance: a texel of level n stands for the mixture of facets of
// the texels that it covers, not for the average of their numbers.
//
// | channel | a coarser texel holds |
// |---------|-----------------------|
// | ji lobe | the lobe with the mixture's second moments, by area times share (1 - w)(1 - h) |
// | ha lobe | the same, by area times share w |
// | w       | the mean |
// | h       | the mean weighted by 1 - w: the hadori's share (1 - w) h is the mean of the shares |
// | part    | the part of most area among the texels of the level below; of equals the lower one |
//
// Weights are normalised (shaders/shared/surface.glsl): a lobe's energy does not depend on its
// width, so area times share is its energy, and the energies of ji, hadori and ha of a texel are
// the means of those below it. A lobe (or h) without share in the whole area keeps the plain mean.
// The peak of the one lobe lies below that of the mixture: of .8 and 5 degrees in equal shares by
// 90 %, which is why there are two lobes; of .8 degrees +- 10 % by 4 %. Sizes halve, rounded down,
// at least 1; an odd size is divided by area.
#pragma once
#include <vector>

#include "bake/map_view.hpp"

namespace togishi {

/// Levels 1 to 1 x 1 of a map (level 0 is the map itself); empty for a map of 1 x 1. Channels that
/// the map lacks are absent in all levels (no h: 0; no e1, e2: isotropic). A channel that is
/// constant stays one value, except ln_mu_deg of a lobe whose shape turns: mixing directions widens
/// it. Values out of range count as f32::sanitise_lobe and f32::sanitise_share make of them. Throws
/// InputError where ji.ln_mu_deg, ha.ln_mu_deg or w is absent, or a size is 0 or above 65536. Cost:
/// some 25 ns per texel of level 0 on one core, 40 with shapes that vary.
[[nodiscard]] std::vector<PropertyMaps> coarser_levels(const MapView& map, unsigned threads = 0);

}  // namespace togishi
