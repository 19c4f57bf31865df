// The surface of a generated katana: cross-sections along the mune line, exact positions and
// normals.
#pragma once
#include <array>
#include <vector>

#include "blade/dual.hpp"
#include "blade/katana_parameters.hpp"
#include "blade/mune_line.hpp"

namespace togishi {

/// Lengthwise pieces; between two of them the surface may break.
enum class Stretch { jiri, nakago, machi, blade, kissaki };
inline constexpr std::array<Stretch, 5> stretches{Stretch::jiri, Stretch::nakago, Stretch::machi,
                                                  Stretch::blade, Stretch::kissaki};
/// Strips of one side across, from the mune ridge to the edge line; between two of them the surface
/// breaks (not between ji and ha: they are one surface with a border at the nominal suguha).
enum class Strip { mune_top, mune_side, shinogi_ji, ji, ha, foot };
inline constexpr std::array<Strip, 6> strips{Strip::mune_top, Strip::mune_side, Strip::shinogi_ji,
                                             Strip::ji,       Strip::ha,        Strip::foot};

/// A cross-section of one side: y is half thickness, d the depth below the mune line, in mm.
struct Section {
    Dual ridge_d;               ///< 0 on the blade, the mune-machi's depth in the nakago
    Dual top_y;                 ///< half width of a mitsu-mune's flat top, else 0
    Dual corner_y, corner_d;    ///< mune corner
    Dual shinogi_y, shinogi_d;  ///< equal to the corner where there is no shinogi
    Dual ji_end_y, ji_end_d;    ///< the edge line; in the nakago the corner of its foot
    Dual edge_d;                ///< lowest point, at y = 0
    Dual niku;                  ///< bulge of the ji at its middle
    Dual ha_fraction;  ///< where the nominal suguha divides the ji strip, 0..1 from the shinogi
};

struct SurfacePoint {
    glm::dvec3 position_mm;
    glm::dvec3 normal;  ///< outwards, unit
    glm::dvec3 along;   ///< derivative by q at constant f, not unit
    glm::dvec3 across;  ///< derivative by f at constant q, not unit
};

class KatanaShape {
  public:
    /// Throws InputError where check_katana does.
    explicit KatanaShape(const KatanaParameters& parameters);

    [[nodiscard]] const KatanaParameters& parameters() const { return p_; }
    [[nodiscard]] const MuneLine& mune_line() const { return line_; }
    [[nodiscard]] bool has_shinogi() const { return p_.zukuri != Zukuri::hira; }
    [[nodiscard]] bool has_yokote() const { return p_.zukuri == Zukuri::shinogi; }
    /// Whether a strip exists on this blade in this stretch.
    [[nodiscard]] bool has(Strip strip, Stretch stretch) const;

    /// First and last value of q in a stretch. q is the arc length of the mune line in mm, except
    /// in the jiri, where it is the angle (0 at the very end, pi/2 at its start) that rounds the
    /// end off.
    [[nodiscard]] std::array<double, 2> range(Stretch stretch) const;
    [[nodiscard]] Dual arc_mm(Stretch stretch, const Dual& q) const;
    [[nodiscard]] Section section(Stretch stretch, const Dual& q) const;

    /// Half thickness and depth at f in [0, 1] of a strip, counted from its ridge side.
    static void point_in_strip(const Section& s, Strip strip, MuneType mune, const Dual& f, Dual& y,
                               Dual& d);
    /// Developed length across, from the strip's start to f.
    static double developed_mm(const Section& s, Strip strip, MuneType mune, double f);

    /// Everything that points of one cross-section share.
    struct Row {
        double arc_mm = 0;
        Section section;
        MuneLine::Point line;
        Dual arc;
        MuneType mune = MuneType::iori;
        /// On omote, the side of +y; ura is its mirror image.
        [[nodiscard]] SurfacePoint at(Strip strip, double f) const;
    };
    [[nodiscard]] Row row(Stretch stretch, double q) const;

    static constexpr double machi_ramp_mm = 0.9;  ///< over which the notches fall

  private:
    [[nodiscard]] Section blade_section(const Dual& arc) const;
    [[nodiscard]] Section kissaki_section(const Dual& arc) const;
    [[nodiscard]] Section nakago_section(const Dual& arc) const;
    [[nodiscard]] Section jiri_section(const Dual& q) const;
    void finish_blade(Section& s, const Dual& corner_y) const;

    KatanaParameters p_;
    MuneLine line_;
    double yokote_arc_mm_ = 0;
    double jiri_mm_ = 0;        // length of the rounded end
    double shinogi_slope_ = 0;  // dy/dd of the shinogi-ji, one value for the whole blade
    double iori_slope_ = 0;     // mune height over half thickness
};

}  // namespace togishi
