#include "capture/light_stack.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <utility>

#include "base/error.hpp"
#include "brdf/model.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/metal.hpp"

namespace togishi {
namespace {

constexpr double deg_per_rad = 57.295779513082320877;
constexpr int reflectance_steps = 128;  // over the cosine; linear between: 2e-5

// Luminance reflectance of the metal under the light, over equal steps of the cosine.
std::vector<double> reflectance_table(const StackOptions& options) {
    const RefractiveIndex index = find_metal(options.metal)->at(grid_61);
    const ColourWeights weights =
        colour_weights(*find_light(options.light), *find_observer(default_observer), grid_61);
    std::vector<double> table(reflectance_steps + 1);
    std::vector<double> spectrum(index.n.size());
    for (int i = 0; i <= reflectance_steps; ++i) {
        const double cosine = static_cast<double>(i) / reflectance_steps;
        for (std::size_t w = 0; w < spectrum.size(); ++w)
            spectrum[w] = f64::fresnel_conductor(index.n[w], index.k[w], cosine);
        table[static_cast<std::size_t>(i)] = weights.xyz(spectrum).y;
    }
    return table;
}

// Squared distance to the third nearest neighbour: the room that a half vector has.
std::vector<float> rooms(const std::vector<float>& u, const std::vector<float>& v) {
    constexpr std::size_t nth = 2;
    std::vector<float> area(u.size(), 1.0F), distance;
    if (u.size() <= nth + 1) return area;
    for (std::size_t i = 0; i < u.size(); ++i) {
        distance.clear();
        for (std::size_t k = 0; k < u.size(); ++k) {
            const float du = u[k] - u[i], dv = v[k] - v[i];
            if (k != i) distance.push_back(du * du + dv * dv);
        }
        std::nth_element(distance.begin(), distance.begin() + nth, distance.end());
        area[i] = distance[nth];
    }
    return area;
}

void check_spread(const LightFile& file, const RegionLights& lights) {
    double su = 0, sv = 0, n = 0;
    for (std::size_t i = 0; i < lights.u_deg.size(); ++i) {
        if (!(lights.gain[i] > 0)) continue;
        su += lights.u_deg[i];
        sv += lights.v_deg[i];
        n += 1;
    }
    su /= n;
    sv /= n;
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t i = 0; i < lights.u_deg.size(); ++i) {
        if (!(lights.gain[i] > 0)) continue;
        const double du = lights.u_deg[i] - su, dv = lights.v_deg[i] - sv;
        xx += du * du;
        xy += du * dv;
        yy += dv * dv;
    }
    const double mean = 0.5 * (xx + yy), q = std::hypot(0.5 * (xx - yy), xy);
    const double ratio = std::sqrt(std::max(0.0, mean - q) / std::max(mean + q, 1e-30));
    constexpr double least = 0.05;
    if (ratio < least) {
        throw InputError(file.path.string(), "lights",
                         "all in one plane (their half vectors spread " +
                             std::to_string(100 * ratio).substr(0, 4) +
                             " % as far across it as along it)",
                         "lights around the object: 5 % or more; one arc never shows both widths");
    }
}

}  // namespace

PixelLights RegionLights::view() const {
    PixelLights lights;
    lights.count = static_cast<int>(u_deg.size());
    lights.u_deg = u_deg.data();
    lights.v_deg = v_deg.data();
    lights.gain = gain.data();
    lights.diffuse = diffuse.data();
    lights.area = area.data();
    lights.spacing_deg = static_cast<float>(spacing_deg);
    lights.reach_deg = static_cast<float>(reach_deg);
    return lights;
}

LightStack::LightStack(const LightFile& file, const StackOptions& options, int unknowns)
    : file_(file), lights_(file.lights), options_(options) {
    near_ = file.near || options.camera_distance_mm > 0;
    if (!(glm::dot(options.view, options.view) > 1e-12))
        throw InputError("capture", "view", "a zero vector", "a direction towards the camera");
    options_.view = glm::normalize(options.view);
    if (near_ && !(options.mm_per_pixel > 0)) {
        throw InputError(file.path.string(), "scale", "missing",
                         "mm per pixel, where lights or camera stand at stated distances");
    }
    if (static_cast<int>(lights_.size()) < unknowns) {
        throw InputError(
            file.path.string(), "lights", std::to_string(lights_.size()),
            "at least " + std::to_string(unknowns) + ", as many as a pixel has unknowns");
    }
    reflectance_ = reflectance_table(options_);
    irradiance_.reserve(lights_.size());
    for (const LightEntry& light : lights_) irradiance_.push_back(light.intensity);
    check_spread(file_, region(glm::dvec3(0, 0, 1)));
}

void LightStack::set_irradiance(std::size_t i, double irradiance) {
    irradiance_.at(i) = irradiance;
}

double LightStack::falloff(std::size_t i, const glm::dvec3& place) const {
    if (!file_.near) return 1;
    const glm::dvec3 from = lights_[i].position_mm - place;
    return glm::dot(lights_[i].position_mm, lights_[i].position_mm) / glm::dot(from, from);
}

glm::dvec3 LightStack::towards(std::size_t i, const glm::dvec3& place) const {
    return file_.near ? glm::normalize(lights_[i].position_mm - place) : lights_[i].direction;
}

void LightStack::correct(const glm::dvec3& normal, const std::vector<glm::dvec2>& offset_deg) {
    const auto frame = f64::tangent_frame(normal, glm::dvec3(1, 0, 0));
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        LightEntry& light = lights_[i];
        const auto g = f64::light_geometry(frame.normal, frame.tangent, frame.bitangent,
                                           options_.view, light.direction);
        if (g.lit < 0.5) continue;
        const glm::dvec2 uv = glm::dvec2(g.facet.dx, g.facet.dy) + offset_deg.at(i) / deg_per_rad;
        const double phi = glm::length(uv);
        const glm::dvec3 half =
            phi > 0 ? std::cos(phi) * frame.normal +
                          std::sin(phi) / phi * (uv.x * frame.tangent + uv.y * frame.bitangent)
                    : frame.normal;
        light.direction = glm::normalize(2 * glm::dot(half, options_.view) * half - options_.view);
        light.position_mm = glm::length(light.position_mm) * light.direction;
    }
}

double LightStack::reflectance(double cosine) const {
    const double x = std::clamp(cosine, 0.0, 1.0) * reflectance_steps;
    const double cell = std::min(std::floor(x), reflectance_steps - 1.0);
    const auto i = static_cast<std::size_t>(cell);
    return reflectance_[i] + (x - cell) * (reflectance_[i + 1] - reflectance_[i]);
}

glm::dvec3 LightStack::place_mm(double column, double row) const {
    return {(column - options_.origin_px.x) * options_.mm_per_pixel,
            (options_.origin_px.y - row) * options_.mm_per_pixel, 0};
}

double LightStack::sigma_h_deg() const {
    // A light's error has two components; the half vector turns by half as much.
    return options_.light_error_deg / (2 * std::numbers::sqrt2);
}

RegionLights LightStack::region(const glm::dvec3& normal, const glm::dvec3& place) const {
    RegionLights r;
    const auto frame = f64::tangent_frame(normal, glm::dvec3(1, 0, 0));
    r.normal = frame.normal;
    r.tangent = frame.tangent;
    r.bitangent = frame.bitangent;
    const glm::dvec3 view =
        options_.camera_distance_mm > 0
            ? glm::normalize(options_.camera_distance_mm * options_.view - place)
            : options_.view;
    r.cos_view = glm::dot(frame.normal, view);
    double reach2 = 0;
    std::vector<double> radius2;
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        const glm::dvec3 to_light = towards(i, place);
        const double irradiance = irradiance_[i] * falloff(i, place);
        const auto g =
            f64::light_geometry(frame.normal, frame.tangent, frame.bitangent, view, to_light);
        double u = g.facet.dx * deg_per_rad, v = g.facet.dy * deg_per_rad;
        double gain = 0;
        if (g.lit > 0.5) {
            const double f = reflectance(options_.model == LobeModel::ji ? g.cos_i : g.cos_h);
            gain = irradiance * f * g.g_over_cos_r;
            radius2.push_back(u * u + v * v);
            reach2 = std::max(reach2, u * u + v * v);
        } else {
            // Below this region's horizon: no sample, whatever the picture shows.
            u = v = 1e3;
        }
        r.u_deg.push_back(static_cast<float>(u));
        r.v_deg.push_back(static_cast<float>(v));
        r.gain.push_back(static_cast<float>(gain));
        r.diffuse.push_back(
            static_cast<float>(irradiance * std::max(0.0, g.cos_i) / std::numbers::pi));
    }
    r.area = rooms(r.u_deg, r.v_deg);
    r.reach_deg = std::sqrt(reach2);
    // As wide as the disc about the normal that holds a sixth of the lights is for each of them.
    const std::size_t few = std::min(radius2.size(), std::max<std::size_t>(6, radius2.size() / 6));
    if (few > 0) {
        std::sort(radius2.begin(), radius2.end());
        r.spacing_deg = std::sqrt(std::numbers::pi * radius2[few - 1] / static_cast<double>(few));
    }
    return r;
}

StackReach LightStack::reach(const glm::dvec3& normal) const {
    const RegionLights r = region(glm::normalize(normal));
    return {r.spacing_deg, r.reach_deg, 0.65 * r.spacing_deg, 0.5 * r.spacing_deg,
            RegionLights::widest_of(r.reach_deg)};
}

std::string reach_sentence(const StackReach& reach, std::size_t lights) {
    std::ostringstream t;
    t << std::setprecision(2) << lights << " lights, half vectors " << reach.spacing_deg
      << " deg apart near the normal, out to " << reach.reach_deg
      << " deg: narrow half widths are measured from " << reach.mu_sure_deg
      << " deg (most pixels from " << reach.mu_mostly_deg << "), wide ones up to "
      << reach.mu_widest_deg << " deg. Narrower lobes are flagged, not guessed.";
    return t.str();
}

}  // namespace togishi
