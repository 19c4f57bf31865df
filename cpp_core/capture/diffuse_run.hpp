// From a set-up and its pictures to what they tell: the steps that the command and Blender share.
// How a picture's file is read is the caller's business.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "capture/diffuse.hpp"
#include "capture/diffuse_plan.hpp"
#include "capture/diffuse_setup.hpp"

namespace togishi {

/// A picture as its file has it: the top row first, channels interleaved, full scale 1.
struct CapturePicture {
    int width = 0, height = 0, channels = 0;
    std::vector<float> values;
    bool whole_numbers = false;  ///< an integer format: at 1 it is clipped
};
using CapturePictureReader = std::function<CapturePicture(const std::filesystem::path&)>;

/// Metal, lobes and light that the set-up names, in `options`; with `hadori` the material's lobe of
/// it too. Throws InputError for a material that is none.
void take_material(const CaptureSetup& setup, bool hadori, DiffuseOptions& options);

/// Whether camera, surface and every photograph's source are stated.
[[nodiscard]] bool has_geometry(const CaptureSetup& setup);

/// Puts the camera where the outline in the picture says that setup.silhouette names. Nothing where
/// none is named, or where that was done before. Throws InputError where there is no blade, for a
/// picture of another size than the camera's, and as refine_on_silhouette.
void refine_camera(CaptureSetup& setup, const CapturePictureReader& read);

/// What this set-up can tell, before anything is photographed: no picture is read. Throws
/// InputError where there is no geometry, and as plan_diffuse.
[[nodiscard]] DiffusePlan plan_setup(const CaptureSetup& setup, const DiffuseOptions& options);

/// Reads the pictures, takes dark and flat frames out and solves; the result's `calibration` says
/// what the scale came from. geometry: false solves by two reference areas. Throws InputError
/// naming set-up or picture, where a silhouette is named and the camera was not refined on it, and
/// as solve_diffuse; DiffuseCancelled.
[[nodiscard]] DiffuseResult evaluate_setup(const CaptureSetup& setup, const DiffuseOptions& options,
                                           bool geometry, const CapturePictureReader& read,
                                           const DiffuseProgress& progress = {});

/// For the map's record: "measured: 2 photographs under diffuse light; …".
[[nodiscard]] std::string source_text(const CaptureSetup& setup, const DiffuseResult& result);

}  // namespace togishi
