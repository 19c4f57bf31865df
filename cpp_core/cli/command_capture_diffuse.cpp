// togishi capture diffuse: photographs under diffuse light become property maps.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "capture/diffuse_run.hpp"
#include "cli/capture_picture.hpp"
#include "cli/commands.hpp"
#include "image/float_image.hpp"
#include "image/map_file.hpp"
#include "image/picture_file.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string setup, output, preview, plot, material, truth;
    std::vector<int> only;  // photographs, from 1
    bool plan = false, no_geometry = false, hadori = false;
    DiffuseOptions diffuse;
};

Json json_of(const DiffusePlan& plan) {
    Json out{{"mu_deg", plan.mu_deg},
             {"mu_share", plan.mu_share},
             {"w_share", plan.w_share},
             {"blind", plan.blind},
             {"sentences", plan.sentences}};
    // JSON knows no infinity.
    for (const double s : plan.sigma_ln_mu)
        out["sigma_ln_mu"].push_back(std::isfinite(s) ? Json(s) : Json(nullptr));
    for (const auto& curve : plan.photographs) {
        out["photographs"].push_back(
            {{"radiance", curve.radiance}, {"flat_at_deg", curve.flat_at_deg}});
    }
    return out;
}

void print_plan(const DiffusePlan& plan) {
    std::cout << "half width  told on   sigma ln mu  radiance of each photograph\n" << std::fixed;
    for (std::size_t k = 0; k < plan.mu_deg.size(); k += 2) {
        std::cout << std::setw(9) << std::setprecision(2) << plan.mu_deg[k] << std::setw(8)
                  << std::setprecision(0) << 100 * plan.mu_share[k] << " %" << std::setw(13)
                  << std::setprecision(3);
        if (plan.sigma_ln_mu[k] < 10) {
            std::cout << plan.sigma_ln_mu[k];
        } else {
            std::cout << "-";
        }
        for (const auto& curve : plan.photographs)
            std::cout << std::setw(9) << std::setprecision(3) << curve.radiance[k];
        std::cout << '\n';
    }
    for (const std::string& sentence : plan.sentences) std::cout << sentence << '\n';
}

FloatImage quality_image(const DiffuseResult& result) {
    FloatImage image;
    image.width = static_cast<int>(result.width);
    image.height = static_cast<int>(result.height);
    image.names = {"sigma.w", "sigma.ji.ln_mu_deg", "sigma.ha.ln_mu_deg", "sigma.h", "chi2",
                   "mask"};
    image.channels = 6;
    image.values.reserve(6 * result.mask.size());
    for (std::size_t i = 0; i < result.mask.size(); ++i) {
        image.values.insert(
            image.values.end(),
            {result.sigma_w[i], result.sigma_ji[i], result.sigma_ha[i], result.sigma_h[i],
             result.chi2[i], static_cast<float>(result.mask[i])});
    }
    std::string bits;
    for (const auto& [bit, name] : diffuse_mask_names)
        bits += (bits.empty() ? "" : ", ") + std::to_string(bit) + " " + std::string(name);
    image.notes = {{"togishi:mask_bits", bits}, {"togishi:calibration", result.calibration}};
    return image;
}

Json json_of(const DiffuseResult& result) {
    const auto seen = static_cast<double>(result.seen());
    Json out{{"width", result.width},
             {"height", result.height},
             {"seen", result.seen()},
             {"mu_measured", result.mu_measured},
             {"calibration", result.calibration},
             {"masked_share_w", static_cast<double>(result.masked(mask_no_w)) / seen},
             {"masked_share_mu", static_cast<double>(result.masked(mask_no_mu)) / seen}};
    for (const auto& [bit, name] : diffuse_mask_names)
        out["masked"][std::string(name)] = result.masked(bit);
    out["notes"] = result.notes;
    return out;
}

// Leaves the named photographs.
void choose(CaptureSetup& setup, const std::vector<int>& only) {
    std::vector<PhotographSetup> chosen;
    for (const int number : only) {
        if (number < 1 || static_cast<std::size_t>(number) > setup.photographs.size()) {
            throw InputError("--only", "argument", std::to_string(number),
                             "1 to " + std::to_string(setup.photographs.size()));
        }
        chosen.push_back(setup.photographs[static_cast<std::size_t>(number - 1)]);
    }
    setup.photographs = std::move(chosen);
}

// Against the truth that `capture simulate` wrote: absolute errors of w, errors of the leading half
// width in per cent, and how often one sigma holds the truth.
Json compare(const DiffuseResult& result, const std::string& path) {
    const FloatImage truth = read_float_image(path);
    const auto channel = [&](std::string_view name) {
        const auto found = std::find(truth.names.begin(), truth.names.end(), name);
        if (found == truth.names.end())
            throw InputError(path, "channel", "no " + std::string(name), "truth.exr of simulate");
        return static_cast<std::size_t>(found - truth.names.begin());
    };
    if (truth.pixels() != result.mask.size())
        throw InputError(path, "size",
                         std::to_string(truth.width) + " x " + std::to_string(truth.height),
                         "that of the pictures");
    const std::size_t w_at = channel("w"), h_at = channel("h"), ji_at = channel("ji.ln_mu_deg"),
                      ha_at = channel("ha.ln_mu_deg");
    std::vector<double> w_error, h_error, mu_error;
    double in_w = 0, in_mu = 0;
    for (std::size_t i = 0; i < result.mask.size(); ++i) {
        const float* t = truth.values.data() + i * static_cast<std::size_t>(truth.channels);
        if ((result.mask[i] & mask_no_w) != 0) continue;
        w_error.push_back(std::abs(double(result.w[i]) - t[w_at]));
        in_w += w_error.back() <= result.sigma_w[i] ? 1 : 0;
        // Hadori's share of the whole: where all is ha, its share of nothing does not count.
        h_error.push_back(
            std::abs((1 - double(result.w[i])) * result.h[i] - (1 - double(t[w_at])) * t[h_at]));
        if ((result.mask[i] & mask_no_mu) != 0) continue;
        const bool ha = result.w[i] > 0.5F, truly_ha = t[w_at] > 0.5F;
        const double found = ha ? result.ha_ln_mu_deg[i] : result.ji_ln_mu_deg[i];
        const double off = found - t[truly_ha ? ha_at : ji_at];
        mu_error.push_back(100 * std::abs(std::expm1(off)));
        in_mu += std::abs(off) <= (ha ? result.sigma_ha[i] : result.sigma_ji[i]) ? 1 : 0;
    }
    Json out{{"w_pixels", w_error.size()}, {"mu_pixels", mu_error.size()}};
    if (!w_error.empty()) {
        out["w_p50"] = quantile(w_error, 0.5);
        out["w_p90"] = quantile(w_error, 0.9);
        out["hadori_p90"] = quantile(h_error, 0.9);
        out["w_coverage"] = in_w / static_cast<double>(w_error.size());
    }
    if (!mu_error.empty()) {
        out["mu_p50_pct"] = quantile(mu_error, 0.5);
        out["mu_p90_pct"] = quantile(mu_error, 0.9);
        out["mu_coverage"] = in_mu / static_cast<double>(mu_error.size());
    }
    return out;
}

void run(Options o, const Common& common) {
    CaptureSetup setup = read_capture_setup(o.setup);
    if (!o.plan) refine_camera(setup, read_capture_picture);
    if (!o.only.empty()) choose(setup, o.only);
    if (!o.material.empty()) setup.material = o.material;
    take_material(setup, o.hadori, o.diffuse);
    const bool geometry = !o.no_geometry && has_geometry(setup);
    const bool show = isatty(STDERR_FILENO) != 0;
    if (o.plan) {
        const DiffusePlan plan = plan_setup(setup, o.diffuse);
        if (!o.plot.empty()) {
            const Picture picture = plot_plan(plan);
            write_png(o.plot, picture.width, picture.height, picture.rgb);
        }
        if (common.json) {
            std::cout << json_of(plan).dump(1) << '\n';
        } else {
            print_plan(plan);
        }
        return;
    }
    if (o.output.empty() || !o.output.ends_with(".exr"))
        throw InputError("--output", "file name", o.output, "a name that ends in .exr");
    check_output_folder(o.output);
    if (setup.camera) check_map_size(o.output, setup.camera->width_px, setup.camera->height_px);
    const DiffuseProgress progress = [show](double done) {
        if (show) {
            std::cerr << "\rtogishi capture diffuse: " << std::setw(3)
                      << static_cast<int>(100 * done) << " %" << (done < 1 ? "" : "\n")
                      << std::flush;
        }
        return true;
    };
    const DiffuseResult result =
        evaluate_setup(setup, o.diffuse, geometry, read_capture_picture, progress);
    MapFileInfo info;
    if (setup.camera && !setup.camera->pinhole) {
        info.chart_mm = {static_cast<float>(setup.camera->width_px / setup.camera->scale),
                         static_cast<float>(setup.camera->height_px / setup.camera->scale)};
    }
    info.source = source_text(setup, result);
    info.software = "togishi " TOGISHI_VERSION;
    write_map_file(o.output, diffuse_maps(result, o.diffuse), info, MapPrecision::single);
    const std::string stem = o.output.substr(0, o.output.size() - 4);
    write_float_image(stem + "-quality.exr", quality_image(result));
    Json report{{"map", o.output}, {"quality", stem + "-quality.exr"}};
    if (!o.preview.empty()) {
        const auto write = [&](const std::string& name, const Picture& picture) {
            const std::string path = (std::filesystem::path(o.preview) / name).string();
            write_png(path, picture.width, picture.height, picture.rgb);
            report["previews"].push_back(path);
        };
        write("w.png", picture_of_w(result));
        if (result.mu_measured) write("mu.png", picture_of_mu(result));
    }
    report.update(json_of(result));
    if (!o.truth.empty()) report["errors"] = compare(result, o.truth);
    if (common.json) {
        std::cout << report.dump(1) << '\n';
        return;
    }
    std::cout << o.output << ": " << result.width << " x " << result.height << ", calibrated by "
              << result.calibration << "\n  w untold on " << std::setprecision(3)
              << 100 * report["masked_share_w"].get<double>() << " % of the surface, mu on "
              << 100 * report["masked_share_mu"].get<double>() << " %\n";
    for (const auto& [name, count] : report["masked"].items())
        if (count.get<std::size_t>() > 0)
            std::cout << "  " << std::left << std::setw(11) << name << ' ' << count << " pixels\n";
    if (report.contains("errors")) std::cout << "errors: " << report["errors"].dump() << '\n';
    std::cout << "quality: " << stem << "-quality.exr\n";
}

}  // namespace

void add_capture_diffuse_command(CLI::App& capture, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command = capture.add_subcommand(
        "diffuse", "Maps of w and of half widths from photographs under diffuse light");
    command->add_option("setup", o->setup, "Set-up of camera, surface, sources, pictures (.toml)")
        ->required();
    command->add_option("-o,--output", o->output,
                        "Map to write (.exr); NAME-quality.exr beside it holds sigma and mask");
    command->add_option("--preview", o->preview, "Folder for w.png and mu.png");
    command->add_flag("--plan", o->plan,
                      "Do not evaluate: say which half widths this set-up can tell");
    command->add_option("--plot", o->plot, "With --plan: the same as a picture (.png)");
    command->add_flag("--no-geometry", o->no_geometry,
                      "Do not use the sources' geometry: by two reference areas");
    command->add_option("--only", o->only, "Numbers of the photographs to use, from 1");
    command->add_option("--material", o->material, "Known lobes, instead of the set-up's");
    command->add_option("--truth", o->truth, "truth.exr of capture simulate: report the errors");
    DiffuseOptions& d = o->diffuse;
    command->add_flag("--hadori", o->hadori,
                      "The blade has hadori: the material's lobe of it is a third one");
    command->add_option("--border-px", d.border_px, "Masked beside the outline and other parts")
        ->capture_default_str();
    command->add_option("--spread", d.spread, "Prior standard deviation of ln mu")
        ->capture_default_str();
    command
        ->add_option("--known-spread", d.known_spread,
                     "The same where the lobes are taken as known: one photograph")
        ->capture_default_str();
    command->add_option("--model-error", d.model_error, "Error of a radiance, of the source's")
        ->capture_default_str();
    command->add_option("--max-sigma-w", d.max_sigma_w, "Above it w is masked")
        ->capture_default_str();
    command->add_option("--max-sigma-ln-mu", d.max_sigma_ln_mu, "Above it mu is masked")
        ->capture_default_str();
    command->callback([o, &common] { run(*o, common); });
}

}  // namespace togishi::cli
