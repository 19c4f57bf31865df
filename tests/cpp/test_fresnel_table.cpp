// The 1-D table against the sum that it stands for.
#include "bake/fresnel_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bake/half.hpp"
#include "base/error.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

FresnelTableRequest request_of(std::string_view metal, std::string_view light) {
    FresnelTableRequest request;
    request.metal = metal;
    request.light = light;
    return request;
}

glm::dvec3 direct_rgb(std::string_view metal, std::string_view light, double cos_theta) {
    const auto index = find_metal(metal)->at(grid_61);
    const auto weights = colour_weights(*find_light(light), *find_observer(default_observer));
    glm::dvec3 xyz(0.0);
    for (std::size_t i = 0; i < grid_61.count; ++i) {
        const double f = f64::fresnel_conductor(index.n[i], index.k[i], cos_theta);
        xyz += f * glm::dvec3(weights.x[i], weights.y[i], weights.z[i]);
    }
    return find_colour_space(default_colour_space).rgb_from_xyz * xyz;
}

TEST(FresnelTable, EveryTexelIsTheDirectSum) {
    for (const auto& metal : builtin_metals()) {
        for (const auto* light : {"D65", "HPS", "line:436"}) {
            const auto table = fresnel_table(request_of(metal->name(), light));
            ASSERT_EQ(table.size(), 192U);
            for (std::size_t i = 0; i < 64; ++i) {
                const double c = std::pow(static_cast<double>(i) / 63.0, 2);
                const auto rgb = direct_rgb(metal->name(), light, c);
                const double scale = std::max({std::abs(rgb.x), std::abs(rgb.y), std::abs(rgb.z)});
                for (int k = 0; k < 3; ++k)
                    EXPECT_NEAR(static_cast<double>(table[3 * i + k]), rgb[k], 1e-7 * scale);
            }
        }
    }
}

TEST(FresnelTable, GrazingLightKeepsItsColour) {
    for (const auto* light : {"D65", "A", "LPS", "line:589.3"}) {
        const auto table = fresnel_table(request_of(default_metal, light));
        const auto white =
            colour_weights(*find_light(light), *find_observer(default_observer)).white;
        const auto rgb = find_colour_space(default_colour_space).rgb_from_xyz * white;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(table[c]), rgb[c], 1e-6);
    }
}

TEST(FresnelTable, BetweenTexelsFourInTenThousand) {
    // The worst over all angles to 88 degrees, of the light's largest component; float and half.
    for (const auto* light : {"D65", "A", "FL11", "HPS"}) {
        const auto table = fresnel_table(request_of(default_metal, light));
        double worst = 0.0;
        double worst_half = 0.0;
        const double scale = *std::max_element(table.begin(), table.begin() + 3);
        for (double angle_deg = 0.0; angle_deg <= 88.0; angle_deg += 0.1) {
            const double c = std::cos(angle_deg * 0.017453292519943295769);
            const double position = f64::fresnel_table_position(c, 64.0);
            const auto i = std::min<std::size_t>(static_cast<std::size_t>(position), 62);
            const double t = position - static_cast<double>(i);
            const auto rgb = direct_rgb(default_metal, light, c);
            for (std::size_t k = 0; k < 3; ++k) {
                auto halved = [&](std::size_t j) {
                    return static_cast<double>(float_from_half(half_from_float(table[j])));
                };
                const double value = (1.0 - t) * static_cast<double>(table[3 * i + k]) +
                                     t * static_cast<double>(table[3 * i + 3 + k]);
                const double half = (1.0 - t) * halved(3 * i + k) + t * halved(3 * i + 3 + k);
                worst = std::max(worst, std::abs(value - rgb[static_cast<int>(k)]) / scale);
                worst_half =
                    std::max(worst_half, std::abs(half - rgb[static_cast<int>(k)]) / scale);
            }
        }
        EXPECT_LE(worst, 4e-4) << light;
        EXPECT_LE(worst_half, 8e-4) << light;
    }
}

// The largest difference between the rows of a table and each row's own sum, over the largest of
// the row's components.
double polynomial_error(const RefractiveIndex& index, const ColourWeights& weights,
                        std::size_t size) {
    const auto& rgb_from_xyz = find_colour_space(default_colour_space).rgb_from_xyz;
    const auto fast = fresnel_table(MetalReflectance(index, size), weights, rgb_from_xyz);
    const auto exact =
        fresnel_table(MetalReflectance(index, size, TableRows::every_row), weights, rgb_from_xyz);
    double worst = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
        double scale = 0.0;
        double off = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto value = static_cast<double>(exact[3 * i + c]);
            scale = std::max(scale, std::abs(value));
            off = std::max(off, std::abs(static_cast<double>(fast[3 * i + c]) - value));
        }
        worst = std::max(worst, off / scale);
    }
    return worst;
}

TEST(FresnelTable, LargeTablesShowNothingOfTheirPolynomial) {
    // The last bit of a float is 1.2e-7 of its value.
    std::vector<std::string> lights = {"E",
                                       "D65",
                                       "A",
                                       "FL11",
                                       "LED-B3",
                                       "LED-RGB1",
                                       "HPS",
                                       "LPS",
                                       "daylight:4000",
                                       "daylight:25000",
                                       "blackbody:2000"};
    for (int nm = 400; nm <= 700; nm += 20) lights.push_back("line:" + std::to_string(nm));
    const auto observer = find_observer(default_observer);
    for (const auto& metal : builtin_metals()) {
        const auto index = metal->at(grid_61);
        ASSERT_TRUE(MetalReflectance(index, 512).by_polynomial()) << metal->name();
        for (const auto& light : lights) {
            const auto weights = colour_weights(*find_light(light), *observer);
            EXPECT_LE(polynomial_error(index, weights, 512), 1.5e-7)
                << metal->name() << " " << light;
        }
    }
    const auto iron = find_metal(default_metal)->at(grid_61);
    const auto d65 = colour_weights(*find_light("D65"), *observer);
    for (const std::size_t size : {std::size_t{65}, std::size_t{100}, max_table_size})
        EXPECT_LE(polynomial_error(iron, d65, size), 1.5e-7) << size;
}

TEST(FresnelTable, SmallTablesAndBentCurvesHaveEveryRowOfTheirOwn) {
    const auto iron = find_metal(default_metal)->at(grid_61);
    EXPECT_FALSE(MetalReflectance(iron, exact_table_size).by_polynomial());
    EXPECT_TRUE(MetalReflectance(iron, exact_table_size + 1).by_polynomial());
    auto uniform = [](double n, double k) {
        RefractiveIndex index;
        index.n.assign(grid_61.count, n);
        index.k.assign(grid_61.count, k);
        return index;
    };
    // Air against air is black but for grazing light; the second has a critical angle; the others
    // bend beside grazing light, or have no limit.
    const auto weights = colour_weights(*find_light("D65"), *find_observer(default_observer));
    for (const auto& [n, k] : {std::pair{1.0, 0.0}, std::pair{0.5, 0.0}, std::pair{1.001, 0.001},
                               std::pair{1e4, 1e4}, std::pair{0.0, 0.0}, std::pair{1.0, 0.1}}) {
        const auto index = uniform(n, k);
        EXPECT_LE(polynomial_error(index, weights, 512), 5e-7) << n << " " << k;
    }
    EXPECT_FALSE(MetalReflectance(uniform(1.0, 0.0), 512).by_polynomial());
    EXPECT_FALSE(MetalReflectance(uniform(0.5, 0.0), 512).by_polynomial());
    auto one_bent = iron;
    one_bent.n[30] = 1.0;
    one_bent.k[30] = 0.0;
    EXPECT_FALSE(MetalReflectance(one_bent, 512).by_polynomial());
}

TEST(FresnelTable, SizesAndNamesAreChecked) {
    auto request = request_of(default_metal, "D65");
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{4097}, SIZE_MAX}) {
        request.size = size;
        EXPECT_THROW((void)fresnel_table(request), InputError) << size;
    }
    request.size = 2;
    EXPECT_EQ(fresnel_table(request).size(), 6U);
    request.size = 4096;
    EXPECT_EQ(fresnel_table(request).size(), 3U * 4096U);
    EXPECT_THROW((void)fresnel_table(request_of("unobtainium", "D65")), InputError);
    EXPECT_THROW((void)fresnel_table(request_of(default_metal, "moon")), InputError);
}

TEST(FresnelTable, AdaptationMakesTheLightWhite) {
    for (const auto* adaptation : {"bradford", "cat16"}) {
        auto request = request_of(default_metal, "A");
        request.adaptation = adaptation;
        const auto table = fresnel_table(request);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(table[c]), 1.0, 1e-6);
    }
}

TEST(FresnelTable, ManyThreadsAtOnceGetTheSameTable) {
    const auto expected = fresnel_table(request_of("gold_johnson_christy", "A"));
    std::vector<int> equal(8, 0);
    {
        std::vector<std::jthread> threads;
        for (std::size_t t = 0; t < equal.size(); ++t) {
            threads.emplace_back([&, t] {
                for (int i = 0; i < 50; ++i) {
                    auto other = request_of("iron_querry", "D50");
                    other.size = 2 + t * 50 + static_cast<std::size_t>(i);  // more than are kept
                    (void)fresnel_table(other);
                    equal[t] +=
                        fresnel_table(request_of("gold_johnson_christy", "A")) == expected ? 1 : 0;
                }
            });
        }
    }
    for (const int count : equal) EXPECT_EQ(count, 50);
}

}  // namespace
}  // namespace togishi
