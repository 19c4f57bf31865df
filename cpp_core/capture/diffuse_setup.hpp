// The set-up of photographs: camera, surface, sources, files. One TOML file says what a simulation
// photographs and what an evaluation reads. Relative paths count from the file's folder.
//
// | key | meaning |
// |-----|---------|
// | format = 1 | |
// | material | whose metal and whose lobes of ji and ha are taken as known (brdf/material.hpp) |
// | light | spectrum of the sources, as find_light takes it; D65 |
// | transfer | of the pictures' values: "linear", "srgb", "gamma:2.2" |
// | scale | value of a picture per radiance at exposure 1; with flat frames not needed |
// | flat_reflectance | of the white card of the flat frames; 1 |
// | noise.snr, .read, .bits | at full scale (value 1); left out: read off the pictures |
// | camera.kind | "orthographic" (scale_px_per_mm) or "pinhole" (focal_px) |
// | camera.width_px, height_px, centre_px, position_mm, right, down | capture/camera.hpp |
// | ... without position_mm: found by the landmarks; camera.facing: the side that is seen, [0, 1,
// 0] (omote) where left out; camera.max_residual_mm | | camera.silhouette | a picture in which the
// blade stands out from a plain ground: the pose is refined on its outline; camera.search_mm (4):
// how far off it may be | | landmark[].name, pixel, point_mm | a place
// on the blade (capture/camera_pose.hpp names some; others by point_mm) and where it is in the
// picture | | surface.kind | "plate" (size_mm, bend_radius_mm), "plane" (point_mm, normal,
// tangent), "blade" (preset, katana.KEY), "none" | | photograph[].file, dark, flat, exposure,
// flat_exposure | dark, flat: frames of their own, may be left out | | photograph[].source.kind,
// centre_mm, half_u_mm, half_v_mm, radiance | rectangle, disk | | photograph[].source.axis,
// radius_mm, centre_mm | hemisphere; radius_mm left out: infinite | | reference[].box_px = [x, y,
// width, height], part = "ji" or "ha", mu_deg | known areas | | simulate.* | what only a simulation
// needs (SimulateSetup) |
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "capture/camera_pose.hpp"
#include "capture/camera_surface.hpp"
#include "capture/diffuse.hpp"
#include "capture/silhouette.hpp"
#include "capture/simulate.hpp"

namespace togishi {

struct PlaneSurface {
    glm::dvec3 point_mm{0}, normal{0, 1, 0}, tangent{1, 0, 0};
};
struct BladeSurface {
    std::string preset;  ///< of data/blades or a file; "": the defaults
    KatanaParameters parameters;
    double detail = 1;
};
struct NoSurface {};
using CaptureSurface = std::variant<NoSurface, Plate, PlaneSurface, BladeSurface>;

struct PhotographSetup {
    std::string file, dark, flat;
    double exposure = 1;
    double flat_exposure = 1;  ///< of the flat frame
    std::optional<DiffuseSource> source;
};

/// A picture on whose outline the camera is refined (capture/silhouette.hpp); file "": none.
struct SilhouetteSetup {
    std::string file;
    double search_mm = 4;
};

/// Only for simulations.
struct SimulateSetup {
    std::string
        maps;  ///< an .exr of `togishi bake`; "": the blade's pattern, the plate's test maps
    std::map<std::string, double> pattern;  ///< numbers of SteelParameters
    int map_width = 4096, map_height = 512;
    double variation = 0.05;  ///< of the plate's ln mu
    double blur_px = 0.6, dark = 0, vignetting = 0;
    std::string lights;  ///< an .lp file: one photograph a light, instead of [[photograph]]
    std::vector<double> exposures{1};
    std::uint64_t seed = 1;
};

struct CaptureSetup {
    std::filesystem::path file;  ///< where it was read, for messages and relative paths
    std::string material{default_material_name};
    std::string light = "D65";
    std::string transfer = "linear";
    std::optional<double> scale;
    double flat_reflectance = 1;
    std::optional<SensorOptions> noise;  ///< snr, read and bits of it
    std::optional<Camera> camera;
    std::vector<Landmark> landmarks;
    std::optional<CameraFit> camera_fit;  ///< where the camera was found by the landmarks
    SilhouetteSetup silhouette;
    std::optional<SilhouetteFit>
        silhouette_fit;  ///< where diffuse_run.hpp's refine_camera was at work
    CaptureSurface surface;
    std::vector<PhotographSetup> photographs;
    std::vector<ReferenceArea> references;
    SimulateSetup simulate;

    [[nodiscard]] std::filesystem::path path_of(const std::string& name) const;
};

/// Throws InputError naming file, line and field.
[[nodiscard]] CaptureSetup capture_setup_from_toml(std::string_view text,
                                                   const std::filesystem::path& file);
[[nodiscard]] CaptureSetup read_capture_setup(const std::filesystem::path& file);
/// Text that capture_setup_from_toml reads back as the same set-up.
[[nodiscard]] std::string capture_setup_to_toml(const CaptureSetup& setup);

/// The camera's view of the set-up's surface. Throws InputError where there is no camera or no
/// surface.
[[nodiscard]] SurfaceView view_of(const CaptureSetup& setup);

/// The white card of the flat frames: a plane through the middle of the surface, turned to the
/// camera. Throws as view_of.
[[nodiscard]] SurfaceView view_of_flat_card(const CaptureSetup& setup);

/// A picture's value made linear. Throws InputError for a transfer it does not know.
[[nodiscard]] double linear_value(const std::string& transfer, double value);
void check_transfer(const std::string& transfer, std::string_view where);

}  // namespace togishi
