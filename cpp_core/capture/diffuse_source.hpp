// A diffuse source of light: an evenly bright rectangle, disk or hemisphere, and where it stands.
//
// radiance: what the source has where a camera looks straight at it, in the units of the
// photograph; even over the source and the same in all directions (a soft box, an opal panel, a
// sheet of paper). It shines to both sides; everything else around is taken as dark.
//
// | kind       | place |
// |------------|-------|
// | rectangle  | centre_mm; half_u_mm, half_v_mm: from its middle to the middle of two sides |
// | disk       | centre_mm; half_u_mm, half_v_mm: two radii at right angles (an ellipse where they
// differ) |
// | hemisphere | centre_mm; half_u_mm: its axis, as long as its radius; far_away: infinitely large
// |
#pragma once
#include <array>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace togishi {

enum class SourceKind { rectangle, disk, hemisphere };
inline constexpr std::array<std::string_view, 3> source_kind_names{"rectangle", "disk",
                                                                   "hemisphere"};

struct DiffuseSource {
    SourceKind kind = SourceKind::rectangle;
    glm::dvec3 centre_mm{0};
    glm::dvec3 half_u_mm{0};
    glm::dvec3 half_v_mm{0};
    bool far_away = false;  ///< hemisphere: as if its radius were infinite
    double radiance = 1;

    /// Above 0 where the ray from `point_mm` along the unit vector `light` meets the source, below
    /// where it misses it; continuous, so that its zero can be looked for.
    [[nodiscard]] double inside(const glm::dvec3& point_mm, const glm::dvec3& light) const;

    /// A piece of the source as a point of the surface sees it.
    struct Seen {
        glm::dvec3 direction;  ///< unit, from the surface to the source
        double solid_angle;    ///< per unit of a and b
    };
    /// The source is covered by a, b in [0, 1].
    [[nodiscard]] Seen seen_from(const glm::dvec3& point_mm, double a, double b) const;
};

/// Throws InputError: sides that are zero, not finite or parallel, a radiance that is not above 0.
void check_source(const DiffuseSource& source, std::string_view where);

/// Irradiance of the source on a small white surface, over the source's radiance: the integral of
/// the cosine, by quadrature of `steps` squared nodes.
[[nodiscard]] double source_irradiance(const DiffuseSource& source, const glm::dvec3& point_mm,
                                       const glm::dvec3& normal, int steps = 24);

}  // namespace togishi
