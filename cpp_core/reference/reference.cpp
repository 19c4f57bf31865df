#include "reference/reference.hpp"

#include <cmath>
#include <string_view>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "brdf/model.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/metal.hpp"
#include "spectral/observer.hpp"

namespace togishi {
namespace {

void check_size(std::string_view field, std::size_t found, std::size_t expected,
                std::string_view what) {
    if (found == expected) return;
    throw InputError("reference_xyz", field, std::to_string(found) + " values",
                     std::to_string(expected) + ", " + std::string(what));
}

template <class T>
void check_per_point(std::string_view field, const PerPoint<T>& values, std::size_t points) {
    if (values.values.size() != 1)
        check_size(field, values.values.size(), points, "one for all or one a point");
}

void check(const ReferenceScene& scene) {
    const std::size_t points = scene.normal.size(), lights = scene.light_of.size();
    check_size("tangent", scene.tangent.size(), points, "as many as normals");
    check_size("view", scene.view.size(), points, "as many as normals");
    check_size("light_direction", scene.light_direction.size(), points * lights,
               "points times lights");
    check_size("irradiance", scene.irradiance.size(), points * lights, "points times lights");
    check_per_point("lobe_ji", scene.lobe_ji, points);
    check_per_point("lobe_hadori", scene.lobe_hadori, points);
    check_per_point("lobe_ha", scene.lobe_ha, points);
    check_per_point("w", scene.w, points);
    check_per_point("h", scene.h, points);
    for (const std::int32_t index : scene.light_of) {
        if (index < 0 || static_cast<std::size_t>(index) >= scene.lights.size()) {
            throw InputError(
                "reference_xyz", "light_of", std::to_string(index),
                "0 to " + std::to_string(scene.lights.size()) + " - 1, an index into lights");
        }
    }
}

// A vector of any length as one of unit length; zero, NaN and infinity become zero, which reflects
// nothing. What is a unit vector to a float's rounding stays as it is: near grazing light L + V is
// short, and normalising would turn it away from what a float renderer, fed the same vectors,
// computes.
glm::dvec3 unit(const glm::dvec3& v) {
    if (std::abs(glm::dot(v, v) - 1.0) < 1e-6) return v;
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(largest > 0.0 && largest < INFINITY && v.x == v.x && v.y == v.y && v.z == v.z))
        return glm::dvec3(0.0);
    const glm::dvec3 scaled = v / largest;
    return scaled / glm::length(scaled);
}

f64::Lobe lobe_of(const StoredLobe& stored) {
    return {stored[0], stored[1], stored[2]};
}

// Sum over the wavelengths of F(cosine) times each weight. A cosine whose factor is 0 is never
// asked for.
glm::dvec3 spectral_sum(const RefractiveIndex& index, const ColourWeights& weights, double cosine) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < weights.x.size(); ++i) {
        // A spectral line has two samples; the others would add nothing.
        if (weights.x[i] == 0 && weights.y[i] == 0 && weights.z[i] == 0) continue;
        const double f = f64::fresnel_conductor(index.n[i], index.k[i], cosine);
        sum.x += f * weights.x[i];
        sum.y += f * weights.y[i];
        sum.z += f * weights.z[i];
    }
    return sum;
}

}  // namespace

std::vector<glm::dvec3> reference_xyz(const ReferenceScene& scene, unsigned threads) {
    check(scene);
    const Grid& grid = scene.grid == ReferenceGrid::samples_61 ? grid_61 : grid_full;
    const auto observer = find_observer(scene.observer);
    const RefractiveIndex index = find_metal(scene.metal)->at(grid);
    std::vector<ColourWeights> spectra;
    for (const auto& light : scene.lights) {
        spectra.push_back(colour_weights(*find_light(light), *observer, grid));
    }
    std::optional<ColourWeights> room;
    double room_radiance = 0;
    if (scene.world) {
        room = colour_weights(*find_light(scene.world->first), *observer, grid);
        room_radiance = scene.world->second;
        if (!(room_radiance >= 0 && room_radiance < INFINITY)) {
            throw InputError("reference_xyz", "world", std::to_string(room_radiance),
                             "a radiance, 0 or more");
        }
    }
    const std::size_t lights = scene.light_of.size();
    std::vector<glm::dvec3> xyz(scene.normal.size(), glm::dvec3(0.0));
    const auto evaluate = [&](std::size_t p) {
        const glm::dvec3 view = unit(scene.view[p]);
        const auto frame = f64::tangent_frame(unit(scene.normal[p]), unit(scene.tangent[p]));
        const auto ji = f64::lobe_form(lobe_of(scene.lobe_ji[p]));
        const auto hadori = f64::lobe_form(lobe_of(scene.lobe_hadori[p]));
        const auto ha = f64::lobe_form(lobe_of(scene.lobe_ha[p]));
        glm::dvec3 sum(0.0);
        for (std::size_t k = 0; k < lights; ++k) {
            const double irradiance = scene.irradiance[p * lights + k];
            if (!(irradiance > 0 && irradiance < INFINITY)) continue;
            const auto g = f64::light_geometry(frame.normal, frame.tangent, frame.bitangent, view,
                                               unit(scene.light_direction[p * lights + k]));
            if (g.lit == 0) continue;
            const auto r = f64::blend_reflection(
                f64::ji_reflection(ji, g, scene.chi),
                f64::hamon_reflection(hadori, g, scene.beta_hadori),
                f64::hamon_reflection(ha, g, scene.beta_ha), scene.w[p], scene.h[p]);
            const auto& weights = spectra[static_cast<std::size_t>(scene.light_of[k])];
            if (r.at_theta_i > 0)
                sum += irradiance * r.at_theta_i * spectral_sum(index, weights, g.cos_i);
            if (r.at_theta_h > 0)
                sum += irradiance * r.at_theta_h * spectral_sum(index, weights, g.cos_h);
        }
        const double cos_r = glm::dot(frame.normal, view);
        if (room && cos_r > double(TG_MIN_COS))
            sum += room_radiance * spectral_sum(index, *room, cos_r);
        xyz[p] = sum;
    };
    parallel_for(
        scene.normal.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p) evaluate(p);
        },
        threads);
    return xyz;
}

}  // namespace togishi
