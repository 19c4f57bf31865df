// How well photographs under many known lights are turned into maps, and how fast. Prints one JSON
// object; tests/bench/capture_lights.py runs it and writes the rows.
//
//   bench_capture recover PIXELS SEED STACKS [CASE ...]
//   bench_capture time CASE PIXELS SEED REPEATS   pixels a second of one core
//   bench_capture export CASE PIXELS SEED         the pixels, for a rival
//   bench_capture efforts CASE PIXELS SEED        error and time against lights and method
//
// A case: 60 lights, directions known to 0.5 degrees (rms), noise of 1 % at full scale (photons)
// and 1.2 steps of 12 bits (electronics), normals 2 degrees (per axis) about the region's, azimuths
// at random, mu_t and mu_b log-uniform in the part's range and mu_t/mu_b at least 1.5, diffuse
// albedo 0.02. Full scale is 1/0.9 of the 90th percentile of the pixels' brightest samples; with
// two exposures the long one has 16 times that light, the short one 1/32 of the long one. Truth by
// the reference evaluation.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random_normal.hpp"
#include "brdf/model.hpp"
#include "capture/light_stack.hpp"
#include "capture/pixel_result.hpp"
#include "capture/self_calibration.hpp"
#include "reference/reference.hpp"

namespace {

using namespace togishi;

constexpr double pi = 3.14159265358979323846;
constexpr double rad = pi / 180;

struct Setup {
    const char* name;
    double tilt_deg;   // of the sample against the camera
    double reach_deg;  // of the half vectors; 0: dome
    double power;      // radius = reach ((i + 0.5)/M)^power
};
constexpr Setup setups[] = {
    {"dome", 0, 0, 0}, {"graded", 12, 22, 0.85}, {"concentrated", 12, 8, 0.5}};

struct Part {
    const char* name;
    double low_deg, high_deg;
    LobeModel model;
};
constexpr Part parts[] = {{"hamon", 3, 12, LobeModel::hamon},
                          {"hadori", 2, 6, LobeModel::hamon},
                          {"ji", 0.5, 2, LobeModel::ji}};

struct Case {
    std::string name;
    const Setup* setup;
    const Part* part;
    int lights = 60;
    bool bracket = false;
    bool calibrate = false;
    double haze = 0;
    double light_error_deg = 0.5;
    double scatter_deg = 2;
};

glm::dvec3 in_frame(const f64::TangentFrame& f, double u_deg, double v_deg) {
    const double phi = std::hypot(u_deg, v_deg) * rad;
    if (phi == 0) return f.normal;
    return std::cos(phi) * f.normal +
           std::sin(phi) / std::hypot(u_deg, v_deg) * (u_deg * f.tangent + v_deg * f.bitangent);
}

struct Simulated {
    std::vector<glm::dvec3> normal;
    std::vector<f64::LobeAxes> axes;  // in tangent_frame(normal, x)
    std::vector<double> weight, diffuse;
    LightFile lights;  // as known
    glm::dvec3 region_normal;
    SampleBlocks samples;
    PixelKernelOptions options;
    std::vector<glm::dvec2> true_offset_deg;
    std::size_t pixels = 0;
};

glm::dvec3 turned(const glm::dvec3& direction, double rms_deg, RandomNormal& random) {
    const auto f = f64::tangent_frame(direction, glm::dvec3(0.31, 0.7, 0.11));
    const double each = rms_deg / std::sqrt(2.0);
    return in_frame(f, each * random.normal(), each * random.normal());
}

Simulated simulate(const Case& c, std::size_t pixels, std::uint64_t seed) {
    RandomNormal random(seed);
    Simulated s;
    s.pixels = pixels;
    const glm::dvec3 view(0, 0, 1), x(1, 0, 0);
    s.region_normal =
        glm::dvec3(std::sin(c.setup->tilt_deg * rad), 0, std::cos(c.setup->tilt_deg * rad));
    const auto frame = f64::tangent_frame(s.region_normal, x);
    const auto count = static_cast<std::size_t>(c.lights);
    std::vector<glm::dvec3> truth;
    for (std::size_t i = 0; i < count; ++i) {
        const double share = (static_cast<double>(i) + 0.5) / c.lights;
        const double azimuth = 2.399963229728653 * static_cast<double>(i);
        glm::dvec3 direction;
        if (c.setup->reach_deg > 0) {
            const double r = c.setup->reach_deg * std::pow(share, c.setup->power);
            const glm::dvec3 h = in_frame(frame, r * std::cos(azimuth), r * std::sin(azimuth));
            direction = 2 * glm::dot(h, view) * h - view;
        } else {
            const double z = std::cos(12 * rad) + share * (std::cos(70 * rad) - std::cos(12 * rad));
            const double r = std::sqrt(1 - z * z);
            direction = glm::dvec3(r * std::cos(azimuth), r * std::sin(azimuth), z);
        }
        truth.push_back(glm::normalize(direction));
        LightEntry entry;
        entry.direction = glm::normalize(turned(direction, c.light_error_deg, random));
        s.lights.lights.push_back(entry);
        const auto at = [&](const glm::dvec3& l) {
            const auto g =
                f64::light_geometry(frame.normal, frame.tangent, frame.bitangent, view, l);
            return glm::dvec2(g.facet.dx, g.facet.dy) / rad;
        };
        s.true_offset_deg.push_back(at(truth.back()) - at(entry.direction));
    }
    s.lights.path = "simulated.lp";

    std::vector<StoredLobe> lobes, wide;
    std::vector<glm::dvec3> tangent(pixels, x), views(pixels, view), directions;
    std::vector<double> irradiance(pixels * count, 1.0);
    for (std::size_t p = 0; p < pixels; ++p) {
        const glm::dvec3 normal =
            in_frame(frame, c.scatter_deg * random.normal(), c.scatter_deg * random.normal());
        s.normal.push_back(normal);
        const double low = std::log(c.part->low_deg), high = std::log(c.part->high_deg),
                     apart = std::log(1.5);
        const double t = low + apart + (high - low - apart) * random.uniform();
        const double b = low + (t - apart - low) * random.uniform();
        const double rho = pi * random.uniform();
        const f64::Lobe lobe = f64::lobe_from_mu(std::exp(t) * rad, std::exp(b) * rad, rho);
        s.axes.push_back(f64::lobe_axes(lobe));
        lobes.push_back({lobe.ln_mu_deg, lobe.e1, lobe.e2});
        wide.push_back({lobe.ln_mu_deg + std::log(3.0), lobe.e1, lobe.e2});
        s.weight.push_back(f64::lobe_normalised_weight(f64::lobe_form(lobe)));
        s.diffuse.push_back(0.02);
        directions.insert(directions.end(), truth.begin(), truth.end());
    }
    const std::vector<std::int32_t> light_of(count, 0);
    const std::vector<double> w{c.part->model == LobeModel::ji ? 0.0 : 1.0}, none{0.0};
    const auto luminance = [&](const std::vector<StoredLobe>& of) {
        // One light at a time, as each has its own picture.
        std::vector<double> y(pixels * count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::vector<glm::dvec3> one(pixels, truth[i]);
            const std::vector<double> full(pixels, 1.0);
            const std::vector<std::int32_t> first{0};
            ReferenceScene scene;
            scene.metal = "iron_johnson_christy";
            scene.lights = {"D65"};
            scene.light_of = first;
            scene.normal = s.normal;
            scene.tangent = tangent;
            scene.view = views;
            scene.light_direction = one;
            scene.irradiance = full;
            scene.lobe_ji = {of};
            scene.lobe_hadori = {of};
            scene.lobe_ha = {of};
            scene.w = {w};
            scene.h = {none};
            const auto xyz = reference_xyz(scene);
            for (std::size_t p = 0; p < pixels; ++p) y[p * count + i] = xyz[p].y;
        }
        return y;
    };
    std::vector<double> signal = luminance(lobes);
    if (c.haze > 0) {
        const std::vector<double> second = luminance(wide);
        // Normalised weights: 9 times lower at 3 times the width. The share is of the height.
        for (std::size_t k = 0; k < signal.size(); ++k) signal[k] += 9 * c.haze * second[k];
    }
    std::vector<double> brightest;
    for (std::size_t p = 0; p < pixels; ++p) {
        double top = 0;
        for (std::size_t i = 0; i < count; ++i) {
            double& y = signal[p * count + i];
            y += s.diffuse[p] * std::max(0.0, glm::dot(s.normal[p], truth[i])) / pi;
            top = std::max(top, y);
        }
        brightest.push_back(top);
    }
    std::nth_element(brightest.begin(),
                     brightest.begin() + static_cast<std::ptrdiff_t>(pixels * 9 / 10),
                     brightest.end());
    double full_scale = brightest[pixels * 9 / 10] / 0.9;
    constexpr double shorter = 1.0 / 32;
    if (c.bracket) full_scale /= 16;

    // The camera.
    constexpr double photon_gain = 1e-4, bits = 4095;
    constexpr double read = 1.2 / bits;
    const std::size_t blocks = (pixels + block_pixels - 1) / block_pixels;
    s.samples.blocks = blocks;
    s.samples.value.assign(blocks * count * block_pixels, 0.0F);
    s.samples.scale.assign(blocks * count * block_pixels, 0.0F);
    const auto picture = [&](double relative) {
        const double exact = std::max(0.0, relative);
        const double noisy = exact + std::sqrt(photon_gain * exact + read * read) * random.normal();
        return std::clamp(std::round(noisy * bits), -64.0, bits) / bits;
    };
    for (std::size_t p = 0; p < pixels; ++p) {
        for (std::size_t i = 0; i < count; ++i) {
            const double relative = signal[p * count + i] / full_scale;
            double value = picture(relative), scale = 1;
            if (c.bracket) {
                const double second = picture(relative * shorter);
                if (value >= 1) {
                    value = second / shorter;
                    scale = 1 / shorter;
                }
            }
            const bool clipped = value * (scale > 1 ? shorter : 1.0) >= 1;
            const std::size_t at = (p / block_pixels * count + i) * block_pixels + p % block_pixels;
            s.samples.value[at] = static_cast<float>(value * full_scale);
            s.samples.scale[at] = static_cast<float>(clipped ? -scale : scale);
        }
    }
    s.options.noise_gain = static_cast<float>(photon_gain * full_scale);
    s.options.noise_floor2 =
        static_cast<float>((read * read + 1 / (12 * bits * bits)) * full_scale * full_scale);
    return s;
}

struct Tally {
    std::vector<double> mu_t, mu_b, rho, normal, weight;
    std::size_t pixels = 0, flagged = 0, wrong = 0;
    std::array<std::size_t, 5> held{};
    std::array<std::size_t, 8> reason{};
    double chi2 = 0, steps = 0, seconds = 0;
    bool keep_flagged = false;

    void add(const Simulated& s, std::size_t p, const PixelResult& r) {
        ++pixels;
        if ((r.flags & unusable_flags) != 0 && !keep_flagged) {
            ++flagged;
            for (std::size_t k = 0; k < reason.size(); ++k) reason[k] += (r.flags >> k) & 1;
            return;
        }
        const f64::LobeAxes found = f64::lobe_axes({r.ln_mu_deg, r.e1, r.e2});
        const double t = std::log(found.mu_t_rad / s.axes[p].mu_t_rad);
        const double b = std::log(found.mu_b_rad / s.axes[p].mu_b_rad);
        const double turn = std::remainder(found.rho_rad - s.axes[p].rho_rad, pi) / rad;
        const double lean =
            std::acos(std::min(1.0, glm::dot(glm::dvec3(r.normal), s.normal[p]))) / rad;
        const double height = std::log(r.weight / s.weight[p]);
        mu_t.push_back(100 * std::abs(std::exp(t) - 1));
        mu_b.push_back(100 * std::abs(std::exp(b) - 1));
        rho.push_back(std::abs(turn));
        normal.push_back(lean);
        weight.push_back(100 * std::abs(height));
        constexpr double off = 25;
        wrong += mu_t.back() > off || mu_b.back() > off ? 1 : 0;
        held[0] += std::abs(t) <= r.sigma_ln_mu_t ? 1 : 0;
        held[1] += std::abs(b) <= r.sigma_ln_mu_b ? 1 : 0;
        held[2] += std::abs(turn) <= r.sigma_rho_deg ? 1 : 0;
        // Two components: their length stays within 1.07 of the root of both variances in 68 %.
        held[3] += lean <= 1.07 * r.sigma_normal_deg ? 1 : 0;
        held[4] += std::abs(height) <= r.sigma_ln_weight ? 1 : 0;
        chi2 += r.chi2_reduced;
    }
    static double quantile(std::vector<double> v, double q) {
        if (v.empty()) return -1;
        const auto at =
            std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())));
        std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(at), v.end());
        return v[at];
    }
    void print() const {
        const auto judged = static_cast<double>(std::max<std::size_t>(1, mu_t.size()));
        const auto all = static_cast<double>(std::max<std::size_t>(1, pixels));
        std::printf("\"pixels\": %zu, \"flagged_pct\": %.4g, \"wrong_unflagged_pct\": %.4g", pixels,
                    100 * static_cast<double>(flagged) / all,
                    100 * static_cast<double>(wrong) / judged);
        const struct {
            const char* name;
            const std::vector<double>& of;
        } columns[] = {{"mu_t_pct", mu_t},
                       {"mu_b_pct", mu_b},
                       {"rho_deg", rho},
                       {"normal_deg", normal},
                       {"weight_pct", weight}};
        for (std::size_t k = 0; k < 5; ++k) {
            std::printf(", \"%s\": {\"p50\": %.4g, \"p90\": %.4g, \"coverage\": %.4g}",
                        columns[k].name, quantile(columns[k].of, 0.5), quantile(columns[k].of, 0.9),
                        100 * static_cast<double>(held[k]) / judged);
        }
        std::printf(", \"chi2_reduced\": %.4g, \"steps\": %.4g, \"px_per_s\": %.5g, \"reasons\": [",
                    chi2 / judged, steps / all, all / std::max(seconds, 1e-9));
        for (std::size_t k = 0; k < reason.size(); ++k)
            std::printf(k > 0 ? ", %zu" : "%zu", reason[k]);
        std::printf("]");
    }
};

// Of this thread alone: what a core takes, whoever else uses the machine.
double thread_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void fit_all(const Simulated& s, const RegionLights& region, const PixelKernelOptions& options,
             const SharedError& shared, Tally& tally) {
    const std::size_t count = s.lights.lights.size();
    const PixelKernel& kernel = pixel_kernel();
    std::vector<PixelBlock> fitted(s.samples.blocks);
    std::vector<float> scratch(2 * count * block_pixels);
    const PixelLights view = region.view();
    const double start = thread_seconds();
    for (std::size_t b = 0; b < s.samples.blocks; ++b)
        kernel.fit(view, s.samples.block(b, count), options, scratch.data(), fitted[b]);
    tally.seconds += thread_seconds() - start;
    for (std::size_t p = 0; p < s.pixels; ++p) {
        const PixelBlock& block = fitted[p / block_pixels];
        tally.add(s, p, pixel_result(block, p % block_pixels, region, options, shared));
        tally.steps += block.steps[p % block_pixels];
    }
}

RegionLights region_of(const Case& c, const Simulated& s) {
    StackOptions stack_options;
    stack_options.model = c.part->model;
    stack_options.light_error_deg = c.light_error_deg;
    const LightStack stack(s.lights, stack_options, 7);
    return stack.region(s.region_normal);
}

PixelKernelOptions options_of(const Case& c, const Simulated& s) {
    PixelKernelOptions options = s.options;
    options.sigma_h_deg =
        static_cast<float>(std::max(0.003, c.light_error_deg / (2 * std::sqrt(2.0))));
    options.haze = c.haze > 0;
    return options;
}

void recover(const Case& c, std::size_t pixels, std::uint64_t seed, std::size_t stacks) {
    Tally tally;
    double before = 0, after = 0, claimed = 0, spacing = 0;
    const auto n = static_cast<double>(c.lights);
    for (std::size_t stack = 0; stack < stacks; ++stack) {
        const Simulated s = simulate(c, pixels, seed * 1'000'003U + stack);
        RegionLights region = region_of(c, s);
        spacing = region.spacing_deg;
        PixelKernelOptions options = options_of(c, s);
        SharedError shared;
        if (c.calibrate) {
            const Calibration found = self_calibrate(region, s.samples, options);
            options.sigma_h_deg = static_cast<float>(found.sigma_h_deg);
            shared = found.shared;
            // What is left of the lights' error, apart from the common turn.
            glm::dvec2 mean(0);
            for (const glm::dvec2& d : s.true_offset_deg) mean += d / n;
            for (std::size_t i = 0; i < s.true_offset_deg.size(); ++i) {
                const glm::dvec2 d = s.true_offset_deg[i] - mean;
                before += glm::dot(d, d) / n;
                after += glm::dot(d - found.offset_deg[i], d - found.offset_deg[i]) / n;
            }
            claimed += 2 * found.sigma_h_deg * found.sigma_h_deg;
        }
        fit_all(s, region, options, shared, tally);
    }
    std::printf(
        "\"%s\": {\"lights\": %d, \"stacks\": %zu, \"kernel\": \"%s\", \"spacing_deg\": %.3g, ",
        c.name.c_str(), c.lights, stacks, pixel_kernel().name, spacing);
    if (c.calibrate) {
        const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(stacks)); };
        std::printf(
            "\"calibration\": {\"before_deg\": %.4g, \"after_deg\": %.4g, \"claimed_deg\": %.4g}, ",
            rms(before), rms(after), rms(claimed));
    }
    tally.print();
    std::printf("}");
    std::fflush(stdout);
}

// Pixels a second of one core, each repeat a fit of all pixels.
void time_fits(const Case& c, std::size_t pixels, std::uint64_t seed, std::size_t repeats) {
    const Simulated s = simulate(c, pixels, seed);
    const RegionLights region = region_of(c, s);
    std::printf("{\"kernel\": \"%s\", \"px_per_s\": [", pixel_kernel().name);
    for (std::size_t i = 0; i < repeats; ++i) {
        Tally tally;
        fit_all(s, region, options_of(c, s), {}, tally);
        std::printf(i > 0 ? ", %.6g" : "%.6g", static_cast<double>(pixels) / tally.seconds);
    }
    std::printf("]}\n");
}

void print_array(const char* name, const std::vector<float>& values) {
    std::printf("\"%s\": [", name);
    for (std::size_t i = 0; i < values.size(); ++i)
        std::printf(i > 0 ? ",%.9g" : "%.9g", values[i]);
    std::printf("]");
}

// What a rival needs to fit the same pixels from the same starts, and what this one found.
void export_pixels(const Case& c, std::size_t pixels, std::uint64_t seed) {
    const Simulated s = simulate(c, pixels, seed);
    const RegionLights region = region_of(c, s);
    PixelKernelOptions options = options_of(c, s);
    const std::size_t count = s.lights.lights.size();
    std::vector<float> value, scale, start, found, truth, scratch(2 * count * block_pixels);
    PixelBlock block;
    for (std::size_t p = 0; p < pixels; ++p) {
        const std::size_t b = p / block_pixels, lane = p % block_pixels;
        const PixelSamples samples = s.samples.block(b, count);
        for (std::size_t i = 0; i < count; ++i) {
            value.push_back(samples.value[i * block_pixels + lane]);
            scale.push_back(samples.scale[i * block_pixels + lane]);
        }
        for (const PixelEffort effort : {PixelEffort::log_linear, PixelEffort::full}) {
            options.effort = effort;
            pixel_kernel().fit(region.view(), samples, options, scratch.data(), block);
            for (std::size_t a = 0; a < 7; ++a)
                (effort == PixelEffort::full ? found : start).push_back(block.x[a][lane]);
        }
        truth.push_back(static_cast<float>(s.axes[p].mu_t_rad / rad));
        truth.push_back(static_cast<float>(s.axes[p].mu_b_rad / rad));
    }
    std::printf(
        "{\"lights\": %zu, \"noise_gain\": %.9g, \"noise_floor2\": %.9g, \"sigma_h_deg\": %.9g,\n",
        count, double{options.noise_gain}, double{options.noise_floor2},
        double{options.sigma_h_deg});
    print_array("u", region.u_deg);
    for (const auto& [name, values] : {std::pair{"v", &region.v_deg},
                                       {"gain", &region.gain},
                                       {"diffuse", &region.diffuse},
                                       {"value", &value},
                                       {"scale", &scale},
                                       {"start", &start},
                                       {"found", &found},
                                       {"truth", &truth}}) {
        std::printf(",\n");
        print_array(name, *values);
    }
    std::printf(",\n\"directions\": [");
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3& d = s.lights.lights[i].direction;
        std::printf("%s[%.12g,%.12g,%.12g]", i > 0 ? "," : "", d.x, d.y, d.z);
    }
    std::printf("]}\n");
}

// Error and time of each way of fitting, against the number of lights.
void efforts(std::size_t pixels, std::uint64_t seed, const Case& base) {
    std::printf("{\"rows\": [");
    bool first = true;
    for (const int lights : {12, 20, 30, 40, 60, 80, 120}) {
        Case c = base;
        c.lights = lights;
        const Simulated s = simulate(c, pixels, seed);
        for (int way = 0; way < 4; ++way) {
            RegionLights region = region_of(c, s);
            PixelKernelOptions options = options_of(c, s);
            options.effort = static_cast<PixelEffort>(std::min(way, 2));
            SharedError shared;
            double calibration = 0;
            if (way == 3) {
                const double start = thread_seconds();
                const Calibration found = self_calibrate(region, s.samples, options, 5, 1);
                calibration = thread_seconds() - start;
                options.sigma_h_deg = static_cast<float>(found.sigma_h_deg);
                shared = found.shared;
            }
            Tally tally;
            tally.keep_flagged = true;  // moments' residuals would flag them all
            fit_all(s, region, options, shared, tally);
            std::vector<double> mu = tally.mu_t;
            mu.insert(mu.end(), tally.mu_b.begin(), tally.mu_b.end());
            static constexpr const char* names[] = {"moments", "log_linear", "full", "calibrated"};
            std::printf(
                "%s\n{\"lights\": %d, \"way\": \"%s\", \"mu_p50_pct\": %.5g, \"us_per_px\": %.5g, "
                "\"calibration_s\": %.4g}",
                first ? "" : ",", lights, names[way], Tally::quantile(mu, 0.5),
                1e6 * tally.seconds / static_cast<double>(pixels), calibration);
            first = false;
        }
    }
    std::printf("\n]}\n");
}

std::vector<Case> cases() {
    const auto make = [](const char* name, const Setup& setup, const Part& part) {
        Case c;
        c.name = name;
        c.setup = &setup;
        c.part = &part;
        return c;
    };
    std::vector<Case> all;
    all.push_back(make("dome.hamon", setups[0], parts[0]));
    all.push_back(make("dome.ji", setups[0], parts[2]));
    all.push_back(make("graded.single", setups[1], parts[0]));
    all.push_back(make("graded.hamon", setups[1], parts[0]));
    all.back().bracket = true;
    all.push_back(make("graded.hadori", setups[1], parts[1]));
    all.back().bracket = true;
    all.push_back(make("concentrated.hadori", setups[2], parts[1]));
    all.push_back(make("concentrated.ji", setups[2], parts[2]));
    all.back().bracket = all.back().calibrate = true;
    const Case clean = all.back();
    for (const double share : {0.01, 0.03, 0.1}) {
        Case c = clean;
        c.name = "haze_" + std::to_string(static_cast<int>(100 * share + 0.5)) + ".ji";
        c.haze = share;
        all.push_back(c);
    }
    return all;
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const auto number = [&](std::size_t i, long otherwise) {
        return i < arguments.size() ? std::strtol(arguments[i].c_str(), nullptr, 10) : otherwise;
    };
    if (!arguments.empty() && arguments[0] == "recover") {
        const auto pixels = static_cast<std::size_t>(std::max(16L, number(1, 3000)));
        const auto seed = static_cast<std::uint64_t>(number(2, 1));
        const auto stacks = static_cast<std::size_t>(std::max(1L, number(3, 8)));
        bool first = true;
        std::printf("{\"seed\": %llu, \"cases\": {", static_cast<unsigned long long>(seed));
        for (const Case& c : cases()) {
            if (arguments.size() > 4 &&
                std::find(arguments.begin() + 4, arguments.end(), c.name) == arguments.end())
                continue;
            std::printf(first ? "\n" : ",\n");
            first = false;
            recover(c, pixels, seed, stacks);
        }
        std::printf("\n}}\n");
        return 0;
    }
    if (arguments.size() >= 2) {
        const auto pixels = static_cast<std::size_t>(std::max(16L, number(2, 500)));
        const auto seed = static_cast<std::uint64_t>(number(3, 1));
        for (const Case& c : cases()) {
            if (c.name != arguments[1]) continue;
            if (arguments[0] == "time") {
                time_fits(c, pixels, seed, static_cast<std::size_t>(std::max(1L, number(4, 5))));
            } else if (arguments[0] == "export") {
                export_pixels(c, pixels, seed);
            } else if (arguments[0] == "efforts") {
                efforts(pixels, seed, c);
            } else {
                break;
            }
            return 0;
        }
    }
    std::fprintf(
        stderr,
        "bench_capture recover PIXELS SEED STACKS [CASE ...] | time CASE PIXELS SEED REPEATS |\n"
        "              export CASE PIXELS SEED | efforts CASE PIXELS SEED\n");
    return 2;
}
