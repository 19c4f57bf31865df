// The radiance that a blade point reflects from a light of a certain size, by quadrature over the
// light itself: double precision, no closed form, adaptive, refined until its own estimate of the
// error is below a stated share of the result. What shaders/shared/area_lights.glsl is measured
// against.
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <variant>

#include <glm/glm.hpp>

namespace togishi {

/// A parallelogram centre + u half_u + v half_v, |u|, |v| <= 1, relative to the shaded point. It
/// emits to the side that cross(half_u, half_v) points to, evenly over all directions.
struct RectangleLight {
    glm::dvec3 centre, half_u, half_v;
    /// What multiplies its radiance at (u, v), as a picture does; empty: 1 everywhere. The error
    /// estimate holds where it is smooth over a cell; its jumps are halved down to.
    std::function<double(double u, double v)> emission = {};
};

/// The same with u^2 + v^2 <= 1: an ellipse where half_u and half_v are perpendicular.
struct EllipseLight {
    glm::dvec3 centre, half_u, half_v;
};

/// Seen from inside it is dark: it emits outwards.
struct SphereLight {
    glm::dvec3 centre;
    double radius;
};

/// A disk at infinity: unit direction, half of the angle that it is seen under (below pi/2).
struct SunLight {
    glm::dvec3 direction;
    double half_angle_rad;
};

/// A sphere whose radiance is multiplied by the blend of a cone about `axis` (unit, away from the
/// light), a function of the ray's direction: light_spot_blend of shaders/shared/light.glsl.
struct SpotLight {
    glm::dvec3 centre;
    double radius;
    glm::dvec3 axis;
    double cos_half, blend;
};

using AreaLight = std::variant<RectangleLight, EllipseLight, SphereLight, SunLight, SpotLight>;

enum class AreaLightModel { ji, hamon };

/// One blade point, seen from one side, with the lobe and the metal of one wavelength.
struct AreaLightPoint {
    glm::dvec3 normal, tangent, view;  ///< of unit length
    std::array<double, 3> lobe;        ///< ln_mu_deg, e1, e2 (shaders/shared/lobe.glsl)
    AreaLightModel model = AreaLightModel::ji;
    double weight = -1;   ///< 1/sr, chi or beta as measured; negative: normalised
    double n = 0, k = 0;  ///< refractive index; both 0: F = 1
};

struct AreaLightRadiance {
    double value;           ///< per radiance of the light
    double error_estimate;  ///< of value, from the two rules on each cell
    std::size_t evaluations;
};

/// Integral over the light of weight D F G .../cos(theta_r) cos(light) / r^2, clipped where N.L =
/// 0.
///
/// Each cell of the light is measured by the 15-point Kronrod and the 7-point Gauss rule in both
/// directions; the worst cell is halved until the sum of the differences is below
/// `relative_error` times the value (or 2e5 cells are reached: see error_estimate). Cells are first
/// made small against the lobe, so that none is missed. Cost: some 0.1 ms to 20 ms.
[[nodiscard]] AreaLightRadiance reference_area_light(const AreaLightPoint& point,
                                                     const AreaLight& light,
                                                     double relative_error = 1e-6);

}  // namespace togishi
