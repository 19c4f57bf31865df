// Many known lights as a region of the object sees them: half vectors about the region's normal,
// and what each light's lobe and diffuse part are multiplied by.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "capture/light_file.hpp"
#include "capture/pixel_kernel.hpp"

namespace togishi {

/// Which of the model's two forms the lobe has (shaders/shared/surface.glsl): its Fresnel angle.
enum class LobeModel : std::uint8_t {
    ji,    ///< chi D F(theta_i), times G/cos(theta_r) as the normalised weight has it
    hamon  ///< beta D F(theta_H) G/cos(theta_r)
};

struct StackOptions {
    LobeModel model = LobeModel::hamon;
    std::string metal = "iron_johnson_christy";
    std::string light = "D65";      ///< spectrum of all lights
    glm::dvec3 view{0, 0, 1};       ///< towards the camera, where it is far
    double camera_distance_mm = 0;  ///< > 0: the camera is this far from the origin along view
    double mm_per_pixel = 0;        ///< needed for near lights or a near camera
    glm::dvec2 origin_px{0, 0};     ///< column and row of the origin (near lights)
    double light_error_deg = 0.5;   ///< rms error of a light's direction
};

/// The arrays behind PixelLights, for one region.
struct RegionLights {
    glm::dvec3 normal, tangent, bitangent;  ///< the region's frame: tangent towards x
    std::vector<float> u_deg, v_deg, gain, diffuse, area;
    double spacing_deg = 1, reach_deg = 30;
    double cos_view = 1;
    [[nodiscard]] PixelLights view() const;
    /// The widest half width that half vectors out to `reach` leave behind: at 1.3 mu a lobe is a
    /// third of its peak.
    [[nodiscard]] static double widest_of(double reach) { return reach / 1.3; }
};

/// What a set-up can see, before anything is fitted.
struct StackReach {
    double spacing_deg;    ///< of half vectors near the normal
    double reach_deg;      ///< of the farthest half vector
    double mu_sure_deg;    ///< narrow half width that is measured: 0.65 spacing
    double mu_mostly_deg;  ///< 0.5 spacing: most pixels
    double mu_widest_deg;  ///< RegionLights::widest_of
};

/// The same for people, in one sentence.
[[nodiscard]] std::string reach_sentence(const StackReach& reach, std::size_t lights);

class LightStack {
  public:
    /// Throws InputError: fewer lights than `unknowns`, all lights in one plane with the viewer
    /// (their half vectors on one line cannot tell two axes), near lights without a scale, an
    /// unknown metal or light.
    LightStack(const LightFile& file, const StackOptions& options, int unknowns);

    [[nodiscard]] std::size_t count() const { return lights_.size(); }
    [[nodiscard]] bool near() const { return near_; }
    [[nodiscard]] const StackOptions& options() const { return options_; }
    /// Irradiance of light i on a surface that faces it; 1 unless stated (white reference).
    void set_irradiance(std::size_t i, double irradiance);
    /// Turns each light so that its half vector about `normal` moves by (u, v) in degrees: what
    /// self-calibration found there.
    void correct(const glm::dvec3& normal, const std::vector<glm::dvec2>& offset_deg);
    [[nodiscard]] const LightEntry& light(std::size_t i) const { return lights_[i]; }
    /// Irradiance of light i at a place, over that at the origin; 1 where lights are far.
    [[nodiscard]] double falloff(std::size_t i, const glm::dvec3& place_mm) const;
    [[nodiscard]] glm::dvec3 towards(std::size_t i, const glm::dvec3& place_mm) const;

    /// Around a normal (unit length, camera's axes), at a place on the object in mm.
    [[nodiscard]] RegionLights region(const glm::dvec3& normal,
                                      const glm::dvec3& place_mm = {0, 0, 0}) const;
    [[nodiscard]] StackReach reach(const glm::dvec3& normal) const;
    /// Per-axis error of a half vector, in degrees, for the stated error of a light.
    [[nodiscard]] double sigma_h_deg() const;
    /// Where the pixel (column, row) is, in mm; 0 where no scale is stated.
    [[nodiscard]] glm::dvec3 place_mm(double column, double row) const;

  private:
    [[nodiscard]] double reflectance(double cosine) const;
    LightFile file_;
    std::vector<LightEntry> lights_;
    StackOptions options_;
    std::vector<double> irradiance_, reflectance_;
    bool near_ = false;
};

}  // namespace togishi
