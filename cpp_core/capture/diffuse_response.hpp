// What a point of polished steel shows of a diffuse source, for any half width of its lobes.
//
// C = L integral over the source of weight D(H) G/cos(theta_r) F cos dω, taken in polar coordinates
// about the normal: along each azimuth of H the source is one or a few intervals of the facet angle
// phi, found once; between their ends the Gaussian is integrated exactly, times the smooth rest at
// the middle. So one geometry serves all half widths at the cost of some exponentials. Azimuths are
// added where the source begins or ends between two of them. Error against the reference's
// quadrature: some 0.2 % of a full lobe (tests/cpp/test_capture_diffuse.cpp).
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "brdf/material.hpp"
#include "capture/diffuse_source.hpp"

namespace togishi {

/// Stored form of a material's lobe: ln_mu_deg, e1, e2.
[[nodiscard]] std::array<double, 3> stored_lobe(const MaterialLobe& lobe);

/// F times the light's spectrum as a camera for luminance sees it, by the cosine of its angle.
class LuminousFresnel {
  public:
    /// Names as find_metal and find_light take them. Throws InputError.
    LuminousFresnel(const std::string& metal, const std::string& light);
    [[nodiscard]] double at(double cosine) const;

  private:
    std::vector<double> table_;
};

/// A point of the surface and the way to the camera; unit vectors.
struct SurfacePose {
    glm::dvec3 point_mm, normal, tangent, view;
};

/// Measured weights of the two lobes; below 0: normalised.
struct LobeWeights {
    double chi = -1;
    double beta = -1;
};

class DiffuseResponse {
  public:
    /// max_phi_rad: facet angles beyond it are left out, 4.3 times the widest half width asked for.
    DiffuseResponse(const DiffuseSource& source, const SurfacePose& pose,
                    const LuminousFresnel& fresnel, const LobeWeights& weights, double max_phi_rad);

    /// Radiance of a surface that is all ji (or all hamon) with this lobe, over the source's.
    [[nodiscard]] double ji(const std::array<double, 3>& stored) const;
    [[nodiscard]] double ha(const std::array<double, 3>& stored) const;

  private:
    struct Line {
        double cosine, sine, width;  ///< azimuth and the share of 2 pi that it stands for, in rad
        std::size_t first, count;    ///< of segments
    };
    [[nodiscard]] double sum(const std::array<double, 3>& stored, const std::vector<float>& smooth,
                             bool normalised) const;

    std::vector<Line> lines_;
    std::vector<float> from2_, to2_;          ///< squared facet angles of a segment's ends
    std::vector<float> smooth_f_, smooth_t_;  ///< everything but D
    bool normalised_f_, normalised_t_;
};

}  // namespace togishi
