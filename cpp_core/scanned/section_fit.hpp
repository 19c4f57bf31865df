// One cross-section of a scanned blade: the surfaces that it consists of, each fitted to the points
// of a slab, and the lines in which they meet. A line is where two fitted surfaces intersect, not
// where the scan's outermost points lie: noise moves those outwards, and a scanner rounds ridges.
#pragma once
#include <array>
#include <span>

#include "blade/katana_parameters.hpp"
#include "scanned/blade_curve.hpp"

namespace togishi {

/// About where things are, to tell which point belongs to which surface. mm below the mune line.
struct SectionGuess {
    double top_d = 0;     ///< the mune's ridge
    double corner_y = 3;  ///< half thickness at the mune's corners
    double corner_d = 1;
    double shinogi_d = 0;  ///< 0: no shinogi
    double edge_d = 25;
    bool blunt = false;  ///< nakago: the edge side ends in a foot
};

struct SectionFit {
    double s_mm = 0;
    bool mune = false, sides = false, shinogi = false, edge = false;  ///< which were found
    double top_d = 0;        ///< depth of the mune's ridge (flat top: of its middle)
    double middle_y = 0;     ///< of the blade, halfway between the sides
    double mune_height = 0;  ///< ridge over the corners
    std::array<double, 2> corner_y{}, corner_d{};  ///< omote, ura; y counted outwards from y = 0
    std::array<std::array<double, 2>, 2> flat{};   ///< shinogi-ji: y = [0] + [1] d, outwards
    std::array<std::array<double, 3>, 2> ji{};     ///< y = [0] + [1] (d - ji_d) + [2] (d - ji_d)^2
    double ji_d = 0;
    std::array<double, 2> shinogi_y{}, shinogi_d{};
    double edge_d = 0;
    double edge_y = 0;
    double residual = 0;  ///< rms of the points about the fitted surfaces
    std::size_t points = 0;

    [[nodiscard]] double half_thickness(int side, double d) const;
    /// The ji's surface alone.
    [[nodiscard]] double half_thickness_ji(int side, double d) const;
};

/// Shape of a mune from its ridge (0) to its corner (1), as a share of its height. `share` is the
/// part of a mitsu-mune that is flat, `height_over_half` of a maru-mune.
[[nodiscard]] double mune_profile(MuneType type, double share, double height_over_half, double eta);

struct MuneKind {
    MuneType type = MuneType::iori;
    double flat_share = 0.4;
};

/// `points` lie within the slab of `half_mm` about s_mm.
[[nodiscard]] SectionFit fit_section(std::span<const BladePoint> points, double s_mm,
                                     double half_mm, const SectionGuess& guess,
                                     const MuneKind& mune);

/// Mean square distance of the points of the mune from the best mune of this kind, and how many.
struct MuneMisfit {
    double squares = 0;
    double points = 0;
    double height = 0;
};
[[nodiscard]] MuneMisfit mune_misfit(std::span<const BladePoint> points, double s_mm,
                                     double half_mm, const SectionGuess& guess,
                                     const MuneKind& mune);

}  // namespace togishi
