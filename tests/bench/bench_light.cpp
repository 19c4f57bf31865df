// How far lights of a size are from their reference quadrature, and what they cost. Prints one JSON
// object; tests/bench/light.py runs it and writes the rows.
//
//   bench_light rectangle|disk|sphere|sun CONFIGURATIONS SEED   full radiance, every level of
//   quality bench_light aa TRIALS SEED          highlights that are small against a pixel
//   bench_light env                     the surroundings' taps
//
// A configuration: a lobe whose axes both lie in 0.05 to 15 degrees, aspect 1 to 10, any azimuth; a
// view 0 to 80 degrees from the normal; ji with normalised or with constant weight, or hamon; iron,
// copper or gold (n, k at 550 nm); a light of half size 0.25 to 45 degrees whose centre lies in the
// mirror direction (rectangles: sides 1 to 20 apart, both at least 0.25 degrees), turned about its
// normal and tilted up to 60 degrees; all sizes even in the logarithm. Its profile: that light
// moved along a random direction, so that its edge passes through the lobe: at the centre, and 1.5
// and 0.5 lobe widths (twice the wide half width) inside and outside of both edges. Errors are
// shares of the largest radiance of the profile.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "brdf/area_lights.hpp"
#include "reference/area_light.hpp"

namespace {

using namespace togishi;

constexpr double pi = std::numbers::pi, degree = pi / 180;

class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double uniform(double from, double to) {
        // Not std::uniform_real_distribution, whose numbers are each library's own.
        return from + (to - from) * static_cast<double>(engine_() >> 11) * 0x1p-53;
    }
    double even_log(double from, double to) {
        return std::exp(uniform(std::log(from), std::log(to)));
    }

  private:
    std::mt19937_64 engine_;
};

enum class Kind { rectangle, disk, sphere, sun };

struct Configuration {
    AreaLightPoint point;
    glm::dvec3 u, v;
    double half_u, half_v, half_angle;
    double mu_t_deg, aspect, incidence_deg;
    std::vector<glm::dvec3> centres;
    std::vector<double> reference;
    double peak;
};

Configuration draw(Random& random, Kind kind, bool isotropic) {
    Configuration c;
    c.aspect = isotropic ? 1 : random.even_log(1, 10);
    const double mu_b = random.even_log(0.05, 15 / c.aspect);
    c.mu_t_deg = mu_b * c.aspect;
    const auto lobe = f64::lobe_from_mu(c.mu_t_deg * degree, mu_b * degree, random.uniform(0, pi));
    c.point.lobe = {lobe.ln_mu_deg, lobe.e1, lobe.e2};
    c.incidence_deg = random.uniform(0, 80);
    const double azimuth = random.uniform(0, 2 * pi);
    const double sine = std::sin(c.incidence_deg * degree);
    c.point.normal = {0, 0, 1};
    c.point.tangent = {1, 0, 0};
    c.point.view = {sine * std::cos(azimuth), sine * std::sin(azimuth),
                    std::cos(c.incidence_deg * degree)};
    const double model = random.uniform(0, 3);
    c.point.model = model < 2 ? AreaLightModel::ji : AreaLightModel::hamon;
    c.point.weight = model < 1 ? 1.0 : -1.0;
    constexpr double metals[3][2] = {{2.9, 3.1}, {1.0, 2.6}, {0.35, 2.7}};
    const auto* metal = metals[static_cast<std::size_t>(random.uniform(0, 3))];
    c.point.n = metal[0];
    c.point.k = metal[1];
    c.half_angle = random.even_log(0.25, 45) * degree;
    const double sides = kind == Kind::rectangle ? random.even_log(1, 20) : 1;
    c.half_u = std::tan(c.half_angle);
    c.half_v = std::tan(std::max(c.half_angle / sides, 0.25 * degree));
    const glm::dvec3 mirror(-c.point.view.x, -c.point.view.y, c.point.view.z);
    const auto around = f64::smooth_frame(mirror);
    const double tilt = random.uniform(0, 60) * degree, towards = random.uniform(0, 2 * pi);
    const glm::dvec3 normal =
        -(std::cos(tilt) * mirror + std::sin(tilt) * (std::cos(towards) * around.tangent +
                                                      std::sin(towards) * around.bitangent));
    const auto plane = f64::tangent_frame(normal, around.bitangent + 0.3 * around.tangent);
    const double turn = random.uniform(0, 2 * pi), way = random.uniform(0, 2 * pi);
    c.u = std::cos(turn) * plane.tangent + std::sin(turn) * plane.bitangent;
    c.v = glm::cross(normal, c.u);
    const double cu = std::abs(std::cos(way)), cv = std::abs(std::sin(way));
    const double edge = kind == Kind::rectangle ? 1 / std::max(cu / c.half_u, cv / c.half_v)
                                                : 1 / std::hypot(cu / c.half_u, cv / c.half_v);
    const double width = 2 * c.mu_t_deg * degree;
    const glm::dvec3 move = std::cos(way) * c.u + std::sin(way) * c.v;
    for (const double by :
         {0.0, -edge - 1.5 * width, -edge - 0.5 * width, -edge + 0.5 * width, -edge + 1.5 * width,
          edge - 1.5 * width, edge - 0.5 * width, edge + 0.5 * width, edge + 1.5 * width})
        c.centres.push_back(mirror + by * move);
    return c;
}

AreaLight light_of(const Configuration& c, Kind kind, const glm::dvec3& centre) {
    switch (kind) {
        case Kind::rectangle:
            return RectangleLight{centre, c.half_u * c.u, c.half_v * c.v};
        case Kind::disk:
            return EllipseLight{centre, c.half_u * c.u, c.half_v * c.v};
        case Kind::sphere:
            return SphereLight{centre, std::sin(c.half_angle) * glm::length(centre)};
        default:
            return SunLight{glm::normalize(centre), c.half_angle};
    }
}

void measure_reference(std::vector<Configuration>& all, Kind kind) {
    parallel_for(all.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Configuration& c = all[i];
            c.peak = 0;
            for (const auto& centre : c.centres) {
                c.reference.push_back(
                    reference_area_light(c.point, light_of(c, kind, centre), 1e-5).value);
                c.peak = std::max(c.peak, c.reference.back());
            }
        }
    });
}

/// What the shader does for one pixel and light; the look-up of F is the formula here.
float radiance(const Configuration& c, Kind kind, const glm::dvec3& centre64, int slices,
               bool fine) {
    const glm::vec3 centre(centre64), view(c.point.view);
    const auto frame = f32::tangent_frame(glm::vec3(c.point.normal), glm::vec3(c.point.tangent));
    const auto form =
        f32::lobe_form({static_cast<float>(c.point.lobe[0]), static_cast<float>(c.point.lobe[1]),
                        static_cast<float>(c.point.lobe[2])});
    const float n = static_cast<float>(c.point.n), k = static_cast<float>(c.point.k);
    const bool ji = c.point.model == AreaLightModel::ji, constant = c.point.weight >= 0;
    const float n_dot_v = glm::dot(frame.normal, view);
    float sum = 0;
    const auto add = [&](const f32::LightNode& node) {
        if (!(node.measure > 0)) return;
        const float fresnel = f32::fresnel_conductor(n, k, ji ? node.n_dot_l : node.v_dot_h);
        const float shadowing =
            ji && constant
                ? 1.0F
                : f32::shadowing_over_cos_r(node.n_dot_h, n_dot_v, node.n_dot_l, node.v_dot_h);
        sum += node.measure * fresnel * shadowing;
    };
    const auto add_slice = [&](const f32::LightSlice& slice) {
        add(slice.first);
        add(slice.second);
    };
    const auto add_parts = [&](const f32::SliceParts& parts) {
        add_slice(parts.lower);
        add_slice(parts.middle);
        add_slice(parts.upper);
    };
    if (kind == Kind::rectangle) {
        const auto light =
            f32::flat_light(centre, glm::vec3(c.u), glm::vec3(c.v), static_cast<float>(c.half_u),
                            static_cast<float>(c.half_v));
        const auto cut = f32::rectangle_slices(light, frame, view, form, slices);
        for (int i = 0; i < slices; ++i) {
            if (fine)
                add_parts(f32::rectangle_slice_fine(cut, slices, i));
            else
                add_slice(f32::rectangle_slice(cut, slices, i));
        }
    } else {
        f32::DiskSlices cut;
        if (kind == Kind::disk) {
            const auto light =
                f32::flat_light(centre, glm::vec3(c.u), glm::vec3(c.v),
                                static_cast<float>(c.half_u), static_cast<float>(c.half_v));
            cut = f32::ellipse_slices(light, frame, view, form, slices);
        } else {
            cut = f32::cone_slices(glm::normalize(centre), static_cast<float>(c.half_angle), frame,
                                   view, form, slices);
        }
        for (int i = 0; i < slices; ++i) {
            if (fine)
                add_parts(f32::disk_slice_fine(cut, slices, i));
            else
                add_slice(f32::disk_slice(cut, slices, i));
        }
    }
    return sum *
           (constant ? static_cast<float>(c.point.weight) : f32::lobe_normalised_weight(form));
}

struct Level {
    int slices;
    bool fine;
};
constexpr Level levels[] = {{2, false},  {3, false},  {4, false}, {6, false}, {8, false},
                            {12, false}, {16, false}, {8, true},  {12, true}, {16, true}};

/// Seconds of one evaluation: the fastest of three rounds over some of the configurations.
double seconds(const std::vector<Configuration>& all, Kind kind, Level level) {
    double best = INFINITY;
    volatile float sink = 0;
    for (int round = 0; round < 3; ++round) {
        std::size_t count = 0;
        const auto begin = std::chrono::steady_clock::now();
        for (std::size_t i = 0; i < all.size(); i += 7) {
            for (const auto& centre : all[i].centres) {
                sink = radiance(all[i], kind, centre, level.slices, level.fine);
                ++count;
            }
        }
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        best = std::min(best, took.count() / static_cast<double>(count));
    }
    static_cast<void>(sink);
    return best;
}

struct Errors {
    std::vector<double> percent;
    [[nodiscard]] double largest() const {
        return percent.empty() ? 0 : *std::max_element(percent.begin(), percent.end());
    }
    [[nodiscard]] double mean() const {
        double sum = 0;
        for (const double e : percent) sum += e;
        return percent.empty() ? 0 : sum / static_cast<double>(percent.size());
    }
    [[nodiscard]] double quantile(double share) {
        if (percent.empty()) return 0;
        std::sort(percent.begin(), percent.end());
        return percent[static_cast<std::size_t>(share * static_cast<double>(percent.size() - 1))];
    }
};

void print_levels(const std::vector<Configuration>& all, Kind kind) {
    std::printf("{\"levels\": [");
    bool first = true;
    for (const Level level : levels) {
        Errors overall, usual;
        for (const Configuration& c : all) {
            // Where the whole profile is dark there is nothing to be a share of.
            if (c.peak < 1e-12) continue;
            const bool common = c.incidence_deg <= 60 && c.aspect <= 3 && c.mu_t_deg <= 5;
            for (std::size_t i = 0; i < c.centres.size(); ++i) {
                const double ours = radiance(c, kind, c.centres[i], level.slices, level.fine);
                double error = 100 * std::abs(ours - c.reference[i]) / c.peak;
                if (!std::isfinite(error)) error = 1e9;
                overall.percent.push_back(error);
                if (common) usual.percent.push_back(error);
            }
        }
        std::printf(
            "%s\n {\"slices\": %d, \"fine\": %s, \"max\": %.6g, \"mean\": %.6g, "
            "\"p99\": %.6g, \"p999\": %.6g, \"usual_max\": %.6g, \"usual_mean\": %.6g, "
            "\"points\": %zu, \"ns\": %.6g}",
            first ? "" : ",", level.slices, level.fine ? "true" : "false", overall.largest(),
            overall.mean(), overall.quantile(0.99), overall.quantile(0.999), usual.largest(),
            usual.mean(), overall.percent.size(), 1e9 * seconds(all, kind, level));
        first = false;
    }
    std::printf("\n]}\n");
}

// --- anti-aliasing
// --------------------------------------------------------------------------------

f64::Facet facet(double x, double y) {
    return {x, y};
}

double brute_box(const f64::LobeForm& form, f64::Facet at, f64::Facet x, f64::Facet y, int side) {
    double sum = 0;
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) {
            const double s = (i + 0.5) / side - 0.5, t = (j + 0.5) / side - 0.5;
            sum += f64::lobe_value(form,
                                   facet(at.dx + s * x.dx + t * y.dx, at.dy + s * x.dy + t * y.dy));
        }
    }
    return sum / (side * side);
}

struct Filter {
    double energy, peak;  ///< largest errors, %
};

/// A highlight on pixels of the given turns: sums over pixels at any phase, and the brightest
/// pixel. width: standard deviation of D in pixels. angle: of the surface's curvature against the
/// grid.
Filter filter_error(double width, double angle, double second, double aspect, int nodes,
                    Random& random) {
    Filter worst{0, 0};
    for (int phase = 0; phase < 8; ++phase) {
        // The lobe's narrow axis of 0.1 degrees turns once over `width` pixels.
        const double mu = 0.1 * degree;
        const double rho = aspect > 1 ? random.uniform(0, pi) : 0;
        const auto form =
            f64::lobe_form(f64::lobe_from_mu(mu * std::sqrt(aspect), mu / std::sqrt(aspect), rho));
        const double rate = mu / 1.17741 / width;
        // Principal directions of the curvature, rates `rate` and `second` of it, against the
        // pixels.
        const double c = std::cos(angle), s = std::sin(angle), r2 = second * rate;
        const f64::Facet x = facet(rate * c * c + r2 * s * s, (rate - r2) * c * s);
        const f64::Facet y = facet((rate - r2) * c * s, rate * s * s + r2 * c * c);
        const double px = random.uniform(-0.5, 0.5), py = random.uniform(-0.5, 0.5);
        const int reach = static_cast<int>(std::ceil(5 * std::max(1.0, width * aspect))) + 1;
        double sum = 0, exact = 0, peak = 0, exact_peak = 0;
        // Straight highlights: one row across; else all pixels around.
        const int rows = second > 0 ? std::min(reach, 12) : 0;
        for (int j = -rows; j <= rows; ++j) {
            for (int i = -reach; i <= reach; ++i) {
                const f64::Facet at =
                    facet((i + px) * x.dx + (j + py) * y.dx, (i + px) * x.dy + (j + py) * y.dy);
                const double ours = f64::lobe_value_box(form, at, x, y, nodes);
                // Pixels that both agree to be dark need no samples.
                const double truth =
                    ours < 1e-9 ? 0 : brute_box(form, at, x, y, second > 0 ? 128 : 256);
                sum += ours;
                exact += truth;
                peak = std::max(peak, ours);
                exact_peak = std::max(exact_peak, truth);
            }
        }
        if (exact <= 0) continue;
        worst.energy = std::max(worst.energy, 100 * std::abs(sum / exact - 1));
        worst.peak = std::max(worst.peak, 100 * std::abs(peak / exact_peak - 1));
    }
    return worst;
}

/// Two planes and the rounding between them, cut anywhere by the pixel's edges: mean radiance
/// error, %.
double ridge_error(double width, double edge_deg, Random& random) {
    double sum = 0, exact = 0;
    const double mu = random.even_log(0.1, 3) * degree;
    const auto form = f64::lobe_form(f64::lobe_from_mu(mu, mu, 0));
    const double from_deg = -random.uniform(0.1, 0.9) * edge_deg;
    const double across = random.uniform(-1, 1) * mu;
    const f64::Facet from = facet(from_deg * degree, across);
    const f64::Facet to = facet((from_deg + edge_deg) * degree, across);
    const double phase = random.uniform(-0.5, 0.5);
    const int reach = static_cast<int>(std::ceil(width)) + 2;
    for (int i = -reach; i <= reach; ++i) {
        const double begin = i + phase, end = begin + width;
        sum += f64::lobe_value_ridge(form, from, to, begin, end);
        constexpr int samples = 4096;
        double mean = 0;
        for (int k = 0; k < samples; ++k) {
            // Evenly over the rounding's part and over the planes' apart: a narrow rounding would
            // be missed.
            const double lo = std::clamp(begin, -0.5, 0.5), hi = std::clamp(end, -0.5, 0.5);
            const double x = lo + (hi - lo) * (k + 0.5) / samples;
            const double share = (x - begin) / (end - begin);
            mean += f64::lobe_value(form, facet(from.dx + share * (to.dx - from.dx), across)) *
                    (hi - lo) / samples;
            if (k == 0) {
                mean += (lo + 0.5) * f64::lobe_value(form, from) +
                        (0.5 - hi) * f64::lobe_value(form, to);
            }
        }
        exact += mean;
    }
    return 100 * std::abs(sum / exact - 1);
}

void print_anti_aliasing(int trials, Random& random) {
    std::printf("{\"straight\": [");
    bool first = true;
    for (const double width : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0}) {
        const Filter f = filter_error(width, 0, 0, 1, 1, random);
        std::printf("%s\n {\"width_px\": %g, \"energy\": %.6g, \"peak\": %.6g}", first ? "" : ",",
                    width, f.energy, f.peak);
        first = false;
    }
    Filter turned{0, 0};
    double curved_1 = 0, curved_4 = 0, curved_8 = 0, ridge = 0;
    for (int i = 0; i < trials; ++i) {
        const double width = random.even_log(0.05, 2), angle = random.uniform(-pi / 4, pi / 4);
        // Up to 45 degrees: a row of pixels across the highlight then tiles it.
        const Filter f = filter_error(width, angle, 0, 1, 2, random);
        turned.energy = std::max(turned.energy, f.energy);
        turned.peak = std::max(turned.peak, f.peak);
        if (i % 4 == 0) {
            const double second = random.uniform(0.1, 1), aspect = random.even_log(1, 9);
            const double around = std::max(width, 0.1);
            const auto keep = [&](double& worst, int nodes) {
                Random same(static_cast<std::uint64_t>(i) + 1);
                const Filter d = filter_error(around, angle, second, aspect, nodes, same);
                worst = std::max(worst, d.energy);
            };
            keep(curved_1, 1);
            keep(curved_4, 4);
            keep(curved_8, 8);
        }
        ridge =
            std::max(ridge, ridge_error(random.even_log(1e-3, 30), random.uniform(5, 60), random));
    }
    std::printf(
        "\n], \"turned_energy\": %.6g, \"turned_peak\": %.6g, \"curved_1\": %.6g, "
        "\"curved_4\": %.6g, \"curved_8\": %.6g, \"ridge\": %.6g}\n",
        turned.energy, turned.peak, curved_1, curved_4, curved_8, ridge);
}

// --- surroundings
// ---------------------------------------------------------------------------------

/// Largest error of the row of taps, % of the reflection's peak; patch: width of the source, a
/// Gaussian, in the lobe's short standard deviations (0: a point).
double taps_error(double aspect, int count, double patch) {
    const auto taps = f32::environment_taps(static_cast<float>(aspect), count);
    std::vector<double> place, weight;
    double total = 0;
    for (int k = 0; k < count; ++k) {
        place.push_back(f32::environment_tap_place(taps, count, k));
        weight.push_back(f32::environment_tap_weight(taps, static_cast<float>(place.back())));
        total += weight.back();
    }
    const double width = taps.width, tap = width * width + patch * patch;
    const double along = aspect * aspect + patch * patch, across = 1 + patch * patch;
    double worst = 0;
    for (int i = 0; i < 500; ++i) {
        const double x = 0.01 * aspect * i;
        for (int j = 0; j < 80; ++j) {
            const double y = 0.06 * std::sqrt(across) * j;
            double sum = 0;
            for (std::size_t k = 0; k < place.size(); ++k)
                sum += weight[k] * std::exp(-0.5 * ((x - place[k]) * (x - place[k]) + y * y) / tap);
            const double lobe = std::exp(-0.5 * (x * x / along + y * y / across));
            worst = std::max(worst, std::abs(sum / total * std::sqrt(along * across) / tap - lobe));
        }
    }
    return 100 * worst;
}

void print_taps() {
    std::printf("{\"taps\": [");
    bool first = true;
    for (const double aspect : {2.0, 3.0, 5.0, 10.0, 20.0}) {
        for (const int count : {3, 5, 7, 9, 13, 25}) {
            std::printf("%s\n {\"aspect\": %g, \"taps\": %d, \"patch\": %.6g, \"point\": %.6g}",
                        first ? "" : ",", aspect, count, taps_error(aspect, count, 1),
                        taps_error(aspect, count, 0));
            first = false;
        }
    }
    std::printf("\n]}\n");
}

int usage() {
    std::fputs(
        "bench_light rectangle|disk|sphere|sun CONFIGURATIONS SEED [isotropic]\n"
        "bench_light aa TRIALS SEED\nbench_light env\n",
        stderr);
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string what = argc > 1 ? argv[1] : "";
    if (what == "env" && argc == 2) {
        print_taps();
        return 0;
    }
    if (argc < 4) return usage();
    const long count = std::strtol(argv[2], nullptr, 10);
    Random random(std::strtoull(argv[3], nullptr, 10));
    if (count < 1) return usage();
    if (what == "aa" && argc == 4) {
        print_anti_aliasing(static_cast<int>(count), random);
        return 0;
    }
    const char* const names[] = {"rectangle", "disk", "sphere", "sun"};
    const auto* const name = std::find(std::begin(names), std::end(names), what);
    const bool isotropic = argc == 5 && std::strcmp(argv[4], "isotropic") == 0;
    if (name == std::end(names) || argc > 5 || (argc == 5 && !isotropic)) return usage();
    const auto kind = static_cast<Kind>(name - std::begin(names));
    std::vector<Configuration> all;
    all.reserve(static_cast<std::size_t>(count));
    for (long i = 0; i < count; ++i) all.push_back(draw(random, kind, isotropic));
    measure_reference(all, kind);
    print_levels(all, kind);
    return 0;
}
