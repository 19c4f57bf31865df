// Error and time of the reflection colour F(theta) E, computed by the product's table and by the
// simplifications that people use instead. Prints one JSON object; tests/bench/accuracy_spectral.py
// runs it and writes the rows.
//
// Error: the largest CIEDE2000, Lab under the light's own white
// (under D65 for lights with less than 1 % of X, Y or Z, which are no whites), against 360 to 830
// nm at 1 nm in double precision, over metals x lights x 0 to 88 degrees. Time: one evaluation
// (cosine in, linear RGB out) in float on one core; all methods take turns, so that a disturbance
// hits all of them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bake/fresnel_table.hpp"
#include "bake/half.hpp"
#include "brdf/model.hpp"
#include "spectral/colour_space.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/delta_e.hpp"

namespace {

using namespace togishi;

constexpr double rad_per_deg = 0.017453292519943295769;
const char* const lights_of_the_comparison[] = {"E",
                                                "D65",
                                                "D55",
                                                "D50",
                                                "A",
                                                "FL11",
                                                "LED-B3",
                                                "LED-RGB1",
                                                "HPS",
                                                "LPS",
                                                "daylight:4000",
                                                "daylight:5000",
                                                "daylight:10000",
                                                "daylight:25000",
                                                "blackbody:2000",
                                                "blackbody:3200",
                                                "blackbody:10000"};
const char* const lines_of_the_comparison[] = {"line:436",   "line:480.3", "line:546.1",
                                               "line:577.5", "line:589.3", "line:632.8"};

glm::vec3 narrowed(const glm::dvec3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// A metal under a light, and what the methods prepare from it.
struct Pair {
    std::shared_ptr<const Metal> metal;
    std::shared_ptr<const Light> light;
    std::shared_ptr<const Observer> observer;
    glm::dmat3 rgb_from_xyz;
    glm::dvec3 white_xyz;
};

// Evaluates many cosines at once, so that the call costs nothing.
using Evaluate = std::function<void(std::span<const float> cosines, glm::vec3* rgb)>;

// Power and colour-matching functions as sampled on the grid, and each of X, Y, Z brought to the
// light's white of 1 nm by one factor.
ColourWeights sampled_weights(const Pair& pair, const Grid& grid) {
    const auto power = pair.light->sample(grid);
    const auto functions = pair.observer->at(grid);
    ColourWeights weights{grid, functions[0], functions[1], functions[2], pair.white_xyz};
    std::vector<double>* const columns[] = {&weights.x, &weights.y, &weights.z};
    for (int c = 0; c < 3; ++c) {
        double sum = 0.0;
        for (std::size_t i = 0; i < grid.count; ++i) sum += (*columns[c])[i] *= power[i];
        if (sum <= 0.0) continue;
        for (double& w : *columns[c]) w *= pair.white_xyz[c] / sum;
    }
    return weights;
}

Evaluate direct_sum(const Pair& pair, const ColourWeights& weights) {
    const Grid& grid = weights.grid;
    const auto index = pair.metal->at(grid);
    struct Sample {
        float n, k;
        glm::vec3 rgb;
    };
    std::vector<Sample> samples(grid.count);
    for (std::size_t i = 0; i < grid.count; ++i) {
        samples[i] = {
            static_cast<float>(index.n[i]), static_cast<float>(index.k[i]),
            narrowed(pair.rgb_from_xyz * glm::dvec3(weights.x[i], weights.y[i], weights.z[i]))};
    }
    return [samples = std::move(samples)](std::span<const float> cosines, glm::vec3* rgb) {
        for (const float c : cosines) {
            glm::vec3 sum(0.0F);
            for (const auto& s : samples) sum += f32::fresnel_conductor(s.n, s.k, c) * s.rgb;
            *rgb++ = sum;
        }
    };
}

// RGB of a spectrum under D65, relative to D65: what a renderer without wavelengths stores.
glm::vec3 rgb_under_d65(const Pair& pair, std::span<const double> spectrum) {
    const auto weights = colour_weights(*find_light("D65"), *pair.observer);
    return narrowed((pair.rgb_from_xyz * weights.xyz(spectrum)) /
                    (pair.rgb_from_xyz * weights.white));
}

glm::vec3 light_rgb(const Pair& pair) {
    return narrowed(pair.rgb_from_xyz * pair.white_xyz);
}

Evaluate rgb_n_k(const Pair& pair) {
    const auto index = pair.metal->at(grid_61);
    const glm::vec3 n = rgb_under_d65(pair, index.n);
    const glm::vec3 k = rgb_under_d65(pair, index.k);
    return [n, k, light = light_rgb(pair)](std::span<const float> cosines, glm::vec3* rgb) {
        for (const float c : cosines) {
            *rgb++ = light * glm::vec3(f32::fresnel_conductor(n.x, k.x, c),
                                       f32::fresnel_conductor(n.y, k.y, c),
                                       f32::fresnel_conductor(n.z, k.z, c));
        }
    };
}

Evaluate schlick(const Pair& pair) {
    const MetalReflectance metal(pair.metal->at(grid_61), 2);
    const glm::vec3 f0 = rgb_under_d65(pair, metal.sample(1));
    return [f0, light = light_rgb(pair)](std::span<const float> cosines, glm::vec3* rgb) {
        for (const float c : cosines) {
            const float m = 1.0F - c;
            const float m2 = m * m;
            *rgb++ = light * (f0 + (glm::vec3(1.0F) - f0) * (m2 * m2 * m));
        }
    };
}

std::vector<glm::vec3> table_of(const Pair& pair, const Light& light, std::size_t size,
                                TableRows rows = TableRows::fast) {
    const MetalReflectance metal(pair.metal->at(grid_61), size, rows);
    const auto flat =
        fresnel_table(metal, colour_weights(light, *pair.observer), pair.rgb_from_xyz);
    std::vector<glm::vec3> table(size);
    for (std::size_t i = 0; i < size; ++i)
        table[i] = {flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]};
    return table;
}

glm::vec3 look_up(const std::vector<glm::vec3>& table, float size, float c) {
    const float position = f32::fresnel_table_position(c, size);
    const auto i = std::min(static_cast<std::size_t>(position), table.size() - 2);
    const float t = position - static_cast<float>(i);
    return table[i] + t * (table[i + 1] - table[i]);
}

Evaluate float_table(std::vector<glm::vec3> table, const glm::vec3& factor) {
    return [table = std::move(table), factor](std::span<const float> cosines, glm::vec3* rgb) {
        const auto size = static_cast<float>(table.size());
        for (const float c : cosines) *rgb++ = factor * look_up(table, size, c);
    };
}

// The GPU's texture unit widens halves while it reads; here the widening happens once, beforehand,
// so that the time is the float table's and the error is the half's.
Evaluate half_table(std::vector<glm::vec3> table) {
    for (auto& texel : table) {
        for (int c = 0; c < 3; ++c) texel[c] = float_from_half(half_from_float(texel[c]));
    }
    return float_table(std::move(table), glm::vec3(1.0F));
}

struct Method {
    std::string name;
    std::function<Evaluate(const Pair&)> prepare;
};

std::vector<Method> methods() {
    std::vector<Method> all;
    for (const auto& [name, grid] :
         {std::pair{"reference_1nm", grid_full}, std::pair{"samples_61", grid_61},
          std::pair{"samples_31", Grid{400.0, 10.0, 31}},
          std::pair{"samples_16", Grid{400.0, 20.0, 16}}}) {
        all.push_back({name, [grid = grid](const Pair& pair) {
                           return direct_sum(pair,
                                             colour_weights(*pair.light, *pair.observer, grid));
                       }});
    }
    all.push_back({"samples_61_white_ratio", [](const Pair& pair) {
                       return direct_sum(pair, sampled_weights(pair, grid_61));
                   }});
    all.push_back({"rgb_nk", rgb_n_k});
    all.push_back({"schlick", schlick});
    all.push_back({"d65_table_rgb_light", [](const Pair& pair) {
                       const auto d65 = find_light("D65");
                       const auto d65_rgb =
                           narrowed(pair.rgb_from_xyz * colour_weights(*d65, *pair.observer).white);
                       return float_table(table_of(pair, *d65, 64), light_rgb(pair) / d65_rgb);
                   }});
    for (const std::size_t size : {8, 16, 32, 64, 128, 256}) {
        const std::string name = "table_" + std::to_string(size);
        all.push_back({name + "_float", [size](const Pair& pair) {
                           return float_table(table_of(pair, *pair.light, size), glm::vec3(1.0F));
                       }});
        all.push_back({name + "_half", [size](const Pair& pair) {
                           return half_table(table_of(pair, *pair.light, size));
                       }});
    }
    all.push_back({"table_512_float", [](const Pair& pair) {
                       return float_table(table_of(pair, *pair.light, 512), glm::vec3(1.0F));
                   }});
    all.push_back({"table_512_every_row", [](const Pair& pair) {
                       return float_table(table_of(pair, *pair.light, 512, TableRows::every_row),
                                          glm::vec3(1.0F));
                   }});
    return all;
}

struct Worst {
    double delta_e = 0.0;
    std::string metal;
    std::string light;
    double angle_deg = 0.0;
};

// A method's errors over a set of lights.
struct Errors {
    Worst de00;
    double xyz_rel = 0.0;  // largest error of X, Y or Z over Y against the 61-sample sum in double
};

struct Comparison {
    Worst grid;                        // 61 samples in double against 1 nm: accuracy.grid_de00
    std::vector<Errors> under_lights;  // per method
    std::vector<Errors> under_lines;   // per method, under spectral lines
};

void keep_worst(Worst& worst, double delta_e, const Pair& pair, double angle_deg) {
    // Written so that NaN is kept, and seen.
    if (delta_e <= worst.delta_e || std::isnan(worst.delta_e)) return;
    worst = {delta_e, std::string(pair.metal->name()), pair.light->description().name, angle_deg};
}

// Nobody adapts to a spectral line, and a white without Z would magnify rounding without bound.
glm::dvec3 lab_white_of(const Pair& pair) {
    const glm::dvec3& w = pair.white_xyz;
    if (std::min({w.x, w.y, w.z}) >= 0.01 * std::max({w.x, w.y, w.z})) return w;
    return colour_weights(*find_light("D65"), *pair.observer).white;
}

constexpr std::size_t angle_count = 177;  // 0 to 88 degrees

double angle_deg(std::size_t a) {
    return 0.5 * static_cast<double>(a);
}

double cosine(std::size_t a) {
    return std::cos(angle_deg(a) * rad_per_deg);
}

// F at every angle and wavelength of a grid, in double.
std::vector<std::vector<double>> reflectances(const Metal& metal, const Grid& grid) {
    const auto index = metal.at(grid);
    std::vector<std::vector<double>> all(angle_count, std::vector<double>(grid.count));
    for (std::size_t a = 0; a < angle_count; ++a) {
        for (std::size_t i = 0; i < grid.count; ++i) {
            all[a][i] = f64::fresnel_conductor(index.n[i], index.k[i], cosine(a));
        }
    }
    return all;
}

// The metal of a pair, reflecting on both grids: shared by all its lights.
struct Reflecting {
    std::vector<std::vector<double>> on_full;
    std::vector<std::vector<double>> on_61;
};

void compare_pair(const Pair& pair, const Reflecting& metal, const std::vector<Method>& all,
                  Worst& grid, std::vector<Errors>& errors) {
    const glm::dvec3 lab_white = lab_white_of(pair);
    auto error = [&](const glm::dvec3& xyz, const glm::dvec3& truth) {
        return delta_e00(lab_from_xyz(xyz, lab_white), lab_from_xyz(truth, lab_white));
    };
    const auto weights_full = colour_weights(*pair.light, *pair.observer, grid_full);
    const auto weights_61 = colour_weights(*pair.light, *pair.observer, grid_61);
    std::vector<glm::dvec3> truth;
    std::vector<glm::dvec3> on_61;
    std::vector<float> cosines;
    for (std::size_t a = 0; a < angle_count; ++a) {
        truth.push_back(weights_full.xyz(metal.on_full[a]));
        on_61.push_back(weights_61.xyz(metal.on_61[a]));
        cosines.push_back(static_cast<float>(cosine(a)));
        keep_worst(grid, error(on_61[a], truth[a]), pair, angle_deg(a));
    }
    const glm::dmat3 xyz_from_rgb = glm::inverse(pair.rgb_from_xyz);
    std::vector<glm::vec3> rgb(cosines.size());
    for (std::size_t m = 0; m < all.size(); ++m) {
        all[m].prepare(pair)(cosines, rgb.data());
        for (std::size_t a = 0; a < angle_count; ++a) {
            const glm::dvec3 xyz = xyz_from_rgb * glm::dvec3(rgb[a]);
            keep_worst(errors[m].de00, error(xyz, truth[a]), pair, angle_deg(a));
            const glm::dvec3 off = glm::abs(xyz - on_61[a]) / on_61[a].y;
            errors[m].xyz_rel = std::max({errors[m].xyz_rel, off.x, off.y, off.z});
        }
    }
}

Pair pair_of(const std::shared_ptr<const Metal>& metal, std::string_view light) {
    Pair pair{metal,
              find_light(light),
              find_observer(default_observer),
              find_colour_space(default_colour_space).rgb_from_xyz,
              {}};
    pair.white_xyz = colour_weights(*pair.light, *pair.observer).white;
    return pair;
}

struct Timing {
    double median = 0.0;
    double low = 0.0;   // first quartile
    double high = 0.0;  // third quartile
};

Timing quartiles(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return {values[values.size() / 2], values[values.size() / 4], values[values.size() * 3 / 4]};
}

double seconds_of(const std::function<void()>& body) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<Timing> time_methods(const std::vector<Method>& all, int rounds, float& sink) {
    const Pair pair = pair_of(find_metal(default_metal), default_light);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> any(0.0F, 1.0F);
    std::vector<float> cosines(1024);
    for (float& c : cosines) c = any(random);
    std::vector<glm::vec3> rgb(cosines.size());
    std::vector<Evaluate> evaluate;
    evaluate.reserve(all.size());
    for (const auto& method : all) evaluate.push_back(method.prepare(pair));
    std::vector<std::vector<double>> ns(all.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t m = 0; m < all.size(); ++m) {
            // Cheap methods repeat until the clock's own cost is out of sight.
            const bool cheap =
                all[m].name.find("table") != std::string::npos || all[m].name == "schlick";
            const int repeats = cheap ? 16 : 1;
            const double s = seconds_of([&] {
                for (int r = 0; r < repeats; ++r) evaluate[m](cosines, rgb.data());
            });
            sink += rgb[static_cast<std::size_t>(round) % rgb.size()].x;
            ns[m].push_back(s * 1e9 / (repeats * static_cast<double>(cosines.size())));
        }
    }
    std::vector<Timing> timings;
    timings.reserve(ns.size());
    for (auto& values : ns) timings.push_back(quartiles(std::move(values)));
    return timings;
}

struct BakeTimings {
    Timing whole;         // from a light's new temperature on, the metal's n and k kept
    Timing every_row;     // the same without the polynomial
    Timing light_change;  // through the product's entry point, which keeps the metal's reflectance
};

// A table of `size` rows, as the viewport asks for it when a light changes.
BakeTimings time_bake(std::size_t size, int rounds, float& sink) {
    const auto index = find_metal(default_metal)->at(grid_61);
    const auto observer = find_observer(default_observer);
    const auto& space = find_colour_space(default_colour_space);
    std::vector<double> whole_us;
    std::vector<double> every_row_us;
    std::vector<double> light_change_us;
    for (int round = 0; round < rounds * 10; ++round) {
        const std::string light = "daylight:" + std::to_string(4000 + round % 5000);
        auto bake_us = [&](TableRows rows) {
            return 1e6 * seconds_of([&] {
                       const auto weights = colour_weights(*find_light(light), *observer);
                       const MetalReflectance metal(index, size, rows);
                       sink += fresnel_table(metal, weights, space.rgb_from_xyz).back();
                   });
        };
        whole_us.push_back(bake_us(TableRows::fast));
        every_row_us.push_back(bake_us(TableRows::every_row));
        FresnelTableRequest request;
        request.light = light;
        request.size = size;
        light_change_us.push_back(1e6 * seconds_of([&] { sink += fresnel_table(request).back(); }));
    }
    return {quartiles(std::move(whole_us)), quartiles(std::move(every_row_us)),
            quartiles(std::move(light_change_us))};
}

void print_worst(const char* key, const Worst& w) {
    std::printf("\"%s\": {\"de00\": %.6g, \"metal\": \"%s\", \"light\": \"%s\", \"angle_deg\": %g}",
                key, w.delta_e, w.metal.c_str(), w.light.c_str(), w.angle_deg);
}

void print_timing(const char* key, const Timing& t) {
    std::printf("\"%s\": {\"median\": %.6g, \"low\": %.6g, \"high\": %.6g}", key, t.median, t.low,
                t.high);
}

}  // namespace

// bench_spectral [ROUNDS [ROWS]]: ROWS of the viewport's table, which the caller knows.
int main(int argc, char** argv) {
    const int rounds = argc > 1 ? std::max(3, std::atoi(argv[1])) : 31;
    const std::size_t rows =
        argc > 2 ? static_cast<std::size_t>(std::atoi(argv[2])) : default_table_size;
    const auto all = methods();
    Comparison comparison;
    comparison.under_lights.resize(all.size());
    comparison.under_lines.resize(all.size());
    for (const auto& metal : builtin_metals()) {
        const Reflecting reflecting{reflectances(*metal, grid_full), reflectances(*metal, grid_61)};
        for (const auto* light : lights_of_the_comparison) {
            compare_pair(pair_of(metal, light), reflecting, all, comparison.grid,
                         comparison.under_lights);
        }
        for (const auto* line : lines_of_the_comparison) {
            compare_pair(pair_of(metal, line), reflecting, all, comparison.grid,
                         comparison.under_lines);
        }
        // The hardest spectra for a grid, wherever they fall between its samples.
        for (int nm = 400; nm < 700; ++nm) {
            const auto line = "line:" + std::to_string(nm) + ".5";
            compare_pair(pair_of(metal, line), reflecting, {}, comparison.grid,
                         comparison.under_lines);
        }
    }
    float sink = 0.0F;
    const auto timings = time_methods(all, rounds, sink);
    const auto bake = time_bake(rows, rounds, sink);
    if (!std::isfinite(sink)) return 1;

    std::printf("{\n ");
    print_worst("grid", comparison.grid);
    std::printf(",\n ");
    print_timing("table_us", bake.whole);
    std::printf(",\n ");
    print_timing("table_every_row_us", bake.every_row);
    std::printf(",\n ");
    print_timing("light_change_us", bake.light_change);
    std::printf(",\n \"methods\": {\n");
    for (std::size_t m = 0; m < all.size(); ++m) {
        std::printf("  \"%s\": {", all[m].name.c_str());
        for (const auto& [key, errors] : {std::pair{"lights", comparison.under_lights[m]},
                                          std::pair{"lines", comparison.under_lines[m]}}) {
            print_worst(key, errors.de00);
            std::printf(", \"%s_xyz_rel\": %.3g, ", key, errors.xyz_rel);
        }
        print_timing("ns", timings[m]);
        std::printf("}%s\n", m + 1 < all.size() ? "," : "");
    }
    std::printf(" }\n}\n");
    return 0;
}
