#include "capture/diffuse_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.hpp"

namespace togishi {
namespace {

// A picture as one linear value a pixel.
struct LinearPicture {
    int width = 0, height = 0;
    std::vector<float> values;
    std::vector<std::uint8_t> clipped;
};

LinearPicture load(const CaptureSetup& setup, const std::string& name,
                   const CapturePictureReader& read) {
    const std::filesystem::path path = setup.path_of(name);
    const CapturePicture image = read(path);
    if (image.channels != 1 && image.channels != 3 && image.channels != 4) {
        throw InputError(path.string(), "channels", std::to_string(image.channels),
                         "1 (grey), 3 or 4 (linear RGB, Rec.709)");
    }
    LinearPicture out;
    out.width = image.width;
    out.height = image.height;
    const auto channels = static_cast<std::size_t>(image.channels);
    const std::size_t pixels = image.values.size() / channels;
    out.values.resize(pixels);
    out.clipped.assign(pixels, 0);
    const bool has_top = image.whole_numbers || (setup.noise && setup.noise->bits > 0);
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* v = image.values.data() + i * channels;
        double y = 0;
        if (channels == 1) {
            y = linear_value(setup.transfer, v[0]);
        } else {
            // Luminance of linear Rec.709.
            y = 0.2126 * linear_value(setup.transfer, v[0]) +
                0.7152 * linear_value(setup.transfer, v[1]) +
                0.0722 * linear_value(setup.transfer, v[2]);
        }
        out.values[i] = static_cast<float>(y);
        for (std::size_t c = 0; c < std::min<std::size_t>(channels, 3); ++c)
            if (has_top && v[c] >= 0.9999F) out.clipped[i] = 1;
    }
    return out;
}

void check_size(const CaptureSetup& setup, const std::string& name, const LinearPicture& picture,
                int width, int height, const std::string& as) {
    if (picture.width == width && picture.height == height) return;
    throw InputError(setup.path_of(name).string(), "size",
                     std::to_string(picture.width) + " x " + std::to_string(picture.height),
                     std::to_string(width) + " x " + std::to_string(height) + ", as " + as);
}

struct Loaded {
    std::vector<DiffusePhotograph> photographs;
    int width = 0, height = 0;
    bool calibrated = true;  // radiances are over the source's
};

Loaded load_all(const CaptureSetup& setup, bool geometry, const CapturePictureReader& read,
                const DiffuseProgress& progress) {
    Loaded loaded;
    std::string first_name = "the camera";
    if (geometry) {
        loaded.width = setup.camera->width_px;
        loaded.height = setup.camera->height_px;
    }
    std::vector<double> card;
    SurfaceView card_view;
    loaded.photographs.reserve(setup.photographs.size());
    for (const PhotographSetup& p : setup.photographs) {
        if (progress && !progress(0)) throw DiffuseCancelled{};
        if (p.file.empty())
            throw InputError(setup.file.string(), "photograph.file", "missing", "a picture");
        LinearPicture picture = load(setup, p.file, read);
        if (loaded.width == 0) {
            loaded.width = picture.width;
            loaded.height = picture.height;
            first_name = p.file;
        }
        check_size(setup, p.file, picture, loaded.width, loaded.height, first_name);
        PictureNoise noise;
        if (setup.noise) {
            const SensorOptions& n = *setup.noise;
            noise.gain = n.snr > 0 ? 1 / (n.snr * n.snr) : 0;
            noise.read = n.read;
            noise.quantum = n.bits > 0 ? std::exp2(-n.bits) : 0;
        } else {
            noise = estimate_noise(picture.values, static_cast<std::size_t>(loaded.width),
                                   static_cast<std::size_t>(loaded.height));
        }
        std::vector<float> dark(picture.values.size(), 0.0F);
        if (!p.dark.empty()) {
            const LinearPicture frame = load(setup, p.dark, read);
            check_size(setup, p.dark, frame, loaded.width, loaded.height, first_name);
            dark = frame.values;
        }
        DiffusePhotograph out;
        out.clipped = std::move(picture.clipped);
        out.radiance.resize(picture.values.size());
        out.sigma.resize(picture.values.size());
        if (p.source) out.source = *p.source;
        LinearPicture flat;
        if (!p.flat.empty()) {
            flat = load(setup, p.flat, read);
            check_size(setup, p.flat, flat, loaded.width, loaded.height, first_name);
            if (geometry) {
                if (card_view.pixels() == 0) card_view = view_of_flat_card(setup);
                card = card_radiance(card_view, *p.source);
            }
        } else if (!setup.scale) {
            loaded.calibrated = false;
        }
        for (std::size_t i = 0; i < out.radiance.size(); ++i) {
            const double value = double(picture.values[i]) - dark[i];
            double sigma = noise.sigma(value);
            if (!p.dark.empty()) sigma = std::hypot(sigma, noise.sigma(0));
            double factor = 1 / (setup.scale.value_or(1) * p.exposure);
            if (!p.flat.empty()) {
                const double white = (double(flat.values[i]) - dark[i]) / p.flat_exposure;
                const double light = geometry ? card[i] / p.source->radiance : 1;
                factor = setup.flat_reflectance * light / (white * p.exposure);
                // Averaged over frames, as flats are: its noise is a small share of the picture's.
                if (!(white > 0)) factor = std::numeric_limits<double>::quiet_NaN();
            } else if (p.source) {
                factor /= p.source->radiance;
            }
            out.radiance[i] = static_cast<float>(value * factor);
            out.sigma[i] = static_cast<float>(sigma * factor);
        }
        loaded.photographs.push_back(std::move(out));
    }
    return loaded;
}

void need_photographs(const CaptureSetup& setup) {
    if (setup.photographs.empty())
        throw InputError(setup.file.string(), "photograph", "none", "[[photograph]], one or more");
}

[[noreturn]] void lacks_geometry(const CaptureSetup& setup) {
    throw InputError(setup.file.string(), "geometry",
                     "no camera, surface or source, and no reference areas",
                     "camera, surface and a source for each photograph; or two "
                     "[[reference]] areas, one of ji and one of hamon");
}

}  // namespace

void take_material(const CaptureSetup& setup, bool hadori, DiffuseOptions& options) {
    const Material material = load_material(setup.material);
    options.metal = material.metal;
    options.light = setup.light;
    options.ji = material.ji;
    options.ha = material.ha;
    if (hadori) options.hadori = material.hadori;
}

bool has_geometry(const CaptureSetup& setup) {
    return setup.camera && !std::holds_alternative<NoSurface>(setup.surface) &&
           std::all_of(setup.photographs.begin(), setup.photographs.end(),
                       [](const PhotographSetup& p) { return p.source.has_value(); });
}

void refine_camera(CaptureSetup& setup, const CapturePictureReader& read) {
    if (setup.silhouette.file.empty() || setup.silhouette_fit) return;
    const auto* blade = std::get_if<BladeSurface>(&setup.surface);
    if (blade == nullptr || !setup.camera) {
        throw InputError(setup.file.string(), "camera.silhouette", setup.silhouette.file,
                         "a blade (surface.kind), whose outline is known");
    }
    const std::filesystem::path path = setup.path_of(setup.silhouette.file);
    const CapturePicture image = read(path);
    if (image.width != setup.camera->width_px || image.height != setup.camera->height_px) {
        throw InputError(path.string(), "size",
                         std::to_string(image.width) + " x " + std::to_string(image.height),
                         "that of the camera");
    }
    // Any mean of the channels shows an outline.
    const auto channels = static_cast<std::size_t>(image.channels);
    std::vector<float> picture(image.values.size() / channels, 0.0F);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        picture[i / channels] += image.values[i] / static_cast<float>(channels);
    SilhouetteOptions options;
    options.search_mm = setup.silhouette.search_mm;
    setup.silhouette_fit =
        refine_on_silhouette(make_katana(blade->parameters, blade->detail), *setup.camera, picture,
                             setup.camera_fit ? setup.landmarks : std::vector<Landmark>{}, options);
    setup.camera = setup.silhouette_fit->camera;
}

DiffusePlan plan_setup(const CaptureSetup& setup, const DiffuseOptions& options) {
    need_photographs(setup);
    if (!has_geometry(setup)) lacks_geometry(setup);
    std::vector<DiffuseSource> sources;
    sources.reserve(setup.photographs.size());
    for (const PhotographSetup& p : setup.photographs) sources.push_back(*p.source);
    const double sigma = setup.noise && setup.noise->snr > 0 ? 1 / setup.noise->snr : 0.01;
    return plan_diffuse(view_of(setup), sources, options, sigma);
}

DiffuseResult evaluate_setup(const CaptureSetup& setup, const DiffuseOptions& options,
                             bool geometry, const CapturePictureReader& read,
                             const DiffuseProgress& progress) {
    need_photographs(setup);
    if (geometry && !has_geometry(setup)) lacks_geometry(setup);
    if (geometry && !setup.silhouette.file.empty() && !setup.silhouette_fit) {
        throw InputError(setup.file.string(), "camera.silhouette", "not refined yet",
                         "a camera refined on that outline");
    }
    if (!geometry && setup.references.empty()) lacks_geometry(setup);
    Loaded loaded = load_all(setup, geometry, read, progress);
    if (!geometry) {
        return solve_by_references(static_cast<std::size_t>(loaded.width),
                                   static_cast<std::size_t>(loaded.height), loaded.photographs,
                                   setup.references, options);
    }
    const SurfaceView view = view_of(setup);
    std::string calibration = "exposure as the set-up states";
    if (!setup.photographs.front().flat.empty()) calibration = "flat-field frames of a white card";
    if (!loaded.calibrated) {
        if (setup.references.empty()) {
            throw InputError(setup.file.string(), "scale", "missing",
                             "scale, flat frames, or [[reference]] areas");
        }
        calibration = "reference areas of known lobes";
        for (DiffusePhotograph& p : loaded.photographs) {
            const auto gain =
                static_cast<float>(reference_gain(view, p, setup.references, options));
            for (float& v : p.radiance) v *= gain;
            for (float& v : p.sigma) v *= gain;
        }
    }
    DiffuseResult result = solve_diffuse(view, loaded.photographs, options, progress);
    result.calibration = calibration;
    return result;
}

std::string source_text(const CaptureSetup& setup, const DiffuseResult& result) {
    return "measured: " + std::to_string(setup.photographs.size()) +
           (setup.photographs.size() == 1 ? " photograph" : " photographs") +
           " under diffuse light; calibrated by " + result.calibration + "; " +
           (result.mu_measured ? "half widths measured where not masked, about "
                               : "half widths not measured, those of ") +
           load_material(setup.material).name;
}

}  // namespace togishi
