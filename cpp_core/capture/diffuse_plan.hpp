// What a set-up of sources can tell, before anything is photographed.
#pragma once
#include <vector>

#include "capture/diffuse.hpp"
#include "plot/canvas.hpp"

namespace togishi {

/// One source as a typical point of the surface sees it.
struct DiffusePlanCurve {
    std::vector<double> radiance;     ///< of a surface all ji with this half width, over the source
    std::vector<double> flat_at_deg;  ///< half widths at which dC/dmu = 0: either side looks alike
};

struct DiffusePlan {
    std::vector<double> mu_deg;                 ///< 0.2 to 15 degrees, in equal ratios
    std::vector<DiffusePlanCurve> photographs;  ///< at the middle of the surface
    /// Share of the surface where the photographs together hold ln mu to max_sigma_ln_mu: a surface
    /// all of one polish, of which two photographs or more have to find that too.
    std::vector<double> mu_share;
    std::vector<double> sigma_ln_mu;  ///< median over the surface; infinite: not at all
    /// Share of the surface where w is held to max_sigma_w, be it ji or ha, the lobes known to the
    /// options' spread (one photograph: known_spread).
    double w_share = 0;
    /// Every polish looks alike to every source, as under an even hemisphere.
    bool blind = false;
    std::vector<std::string> sentences;  ///< the same for people
};

/// sigma: noise of a radiance at the source's own level 1 (shot noise falls with its root). Only
/// `source` of the photographs is used. Throws InputError as solve_diffuse.
[[nodiscard]] DiffusePlan plan_diffuse(const SurfaceView& view,
                                       const std::vector<DiffuseSource>& sources,
                                       const DiffuseOptions& options, double sigma);

/// Radiance against half width, one line a source, what can be seen below it. 1200 x 760 pixels.
[[nodiscard]] Picture plot_plan(const DiffusePlan& plan);

/// w, or the leading half width, of a result as a picture; masked pixels in their colours.
[[nodiscard]] Picture picture_of_w(const DiffuseResult& result);
[[nodiscard]] Picture picture_of_mu(const DiffuseResult& result);

}  // namespace togishi
