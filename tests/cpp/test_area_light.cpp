// Lights of a size: the quadrature reference against independent sums, limits that are known in
// closed form, the shared slices against the reference, extremes, float against double.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "brdf/area_lights.hpp"
#include "reference/area_light.hpp"

namespace {

using namespace togishi;

constexpr double degree = std::numbers::pi / 180;

AreaLightPoint point_at(double incidence_deg, double mu_t_deg, double mu_b_deg, double rho_deg) {
    const auto lobe = f64::lobe_from_mu(mu_t_deg * degree, mu_b_deg * degree, rho_deg * degree);
    AreaLightPoint p;
    p.normal = {0, 0, 1};
    p.tangent = {1, 0, 0};
    p.view = {std::sin(incidence_deg * degree), 0, std::cos(incidence_deg * degree)};
    p.lobe = {lobe.ln_mu_deg, lobe.e1, lobe.e2};
    return p;
}

glm::dvec3 mirrored(const AreaLightPoint& p) {
    return {-p.view.x, -p.view.y, p.view.z};
}

// A rectangle around a direction, facing the point.
RectangleLight rectangle_at(const glm::dvec3& centre, double half_u, double half_v,
                            double turn = 0) {
    const auto f = f64::tangent_frame(-glm::normalize(centre), {0.3, 0.5, 0.1});
    const glm::dvec3 u = std::cos(turn) * f.tangent + std::sin(turn) * f.bitangent;
    return {centre, half_u * u, half_v * glm::cross(f.normal, u)};
}

// What a rectangle emits at the point that is seen in a direction; 1 of other lights.
double emitted(const AreaLight& light, const glm::dvec3& direction) {
    const auto* r = std::get_if<RectangleLight>(&light);
    if (!r || !r->emission) return 1;
    const glm::dvec3 facing = glm::cross(r->half_u, r->half_v);
    const glm::dvec3 at =
        direction * (glm::dot(r->centre, facing) / glm::dot(direction, facing)) - r->centre;
    return r->emission(glm::dot(at, r->half_u) / glm::dot(r->half_u, r->half_u),
                       glm::dot(at, r->half_v) / glm::dot(r->half_v, r->half_v));
}

// The shared formula in the precision of the namespace, with F = 1 and normalised ji.
#define TG_TEST_EVALUATE(name, ns, real, vec)                                                      \
    double name(const AreaLightPoint& p, const AreaLight& light, int slices, bool fine) {          \
        const auto frame = ns::tangent_frame(vec(p.normal), vec(p.tangent));                       \
        const auto form =                                                                          \
            ns::lobe_form({static_cast<real>(p.lobe[0]), static_cast<real>(p.lobe[1]),             \
                           static_cast<real>(p.lobe[2])});                                         \
        const vec view(p.view);                                                                    \
        const real n_dot_v = glm::dot(frame.normal, view);                                         \
        double sum = 0;                                                                            \
        const auto add = [&](const ns::LightNode& n) {                                             \
            if (n.measure == 0) return;                                                            \
            sum += emitted(light, glm::dvec3(n.direction)) *                                       \
                   static_cast<double>(n.measure * ns::shadowing_over_cos_r(                       \
                                                       n.n_dot_h, n_dot_v, n.n_dot_l, n.v_dot_h)); \
        };                                                                                         \
        const auto add_slice = [&](const ns::LightSlice& s) { add(s.first), add(s.second); };      \
        const auto add_parts = [&](const ns::SliceParts& h) {                                      \
            add_slice(h.lower), add_slice(h.middle), add_slice(h.upper);                           \
        };                                                                                         \
        const auto flat = [&](const glm::dvec3& c, const glm::dvec3& u, const glm::dvec3& v) {     \
            const double a = glm::length(u), b = glm::length(v);                                   \
            return ns::flat_light(vec(c), vec(u / a), vec(v / b), static_cast<real>(a),            \
                                  static_cast<real>(b));                                           \
        };                                                                                         \
        if (const auto* r = std::get_if<RectangleLight>(&light)) {                                 \
            const auto cut = ns::rectangle_slices(flat(r->centre, r->half_u, r->half_v), frame,    \
                                                  view, form, slices);                             \
            for (int k = 0; k < slices; ++k)                                                       \
                fine ? add_parts(ns::rectangle_slice_fine(cut, slices, k))                         \
                     : add_slice(ns::rectangle_slice(cut, slices, k));                             \
        } else {                                                                                   \
            ns::DiskSlices cut;                                                                    \
            if (const auto* e = std::get_if<EllipseLight>(&light)) {                               \
                cut = ns::ellipse_slices(flat(e->centre, e->half_u, e->half_v), frame, view, form, \
                                         slices);                                                  \
            } else {                                                                               \
                const auto& sun = std::get<SunLight>(light);                                       \
                cut = ns::cone_slices(vec(sun.direction), static_cast<real>(sun.half_angle_rad),   \
                                      frame, view, form, slices);                                  \
            }                                                                                      \
            for (int k = 0; k < slices; ++k)                                                       \
                fine ? add_parts(ns::disk_slice_fine(cut, slices, k))                              \
                     : add_slice(ns::disk_slice(cut, slices, k));                                  \
        }                                                                                          \
        return sum * static_cast<double>(ns::lobe_normalised_weight(form));                        \
    }
TG_TEST_EVALUATE(shared_float, f32, float, glm::vec3)
TG_TEST_EVALUATE(shared_double, f64, double, glm::dvec3)
#undef TG_TEST_EVALUATE

// --- the reference
// --------------------------------------------------------------------------------

TEST(AreaLightReference, IsThePlainSumOverTheLight) {
    for (const double incidence : {10.0, 70.0}) {
        auto p = point_at(incidence, 6, 3, 25);
        p.n = 2.9;
        p.k = 3.1;
        const auto light = rectangle_at(2.0 * mirrored(p) + glm::dvec3(0.1, 0.2, 0), 0.5, 0.2);
        const auto frame = f64::tangent_frame(p.normal, p.tangent);
        const auto form = f64::lobe_form({p.lobe[0], p.lobe[1], p.lobe[2]});
        const glm::dvec3 face = glm::normalize(glm::cross(light.half_u, light.half_v));
        constexpr int n = 400;
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                const glm::dvec3 q = light.centre + ((2 * i + 1.0) / n - 1) * light.half_u +
                                     ((2 * j + 1.0) / n - 1) * light.half_v;
                const double r = glm::length(q);
                const auto g = f64::light_geometry(frame.normal, frame.tangent, frame.bitangent,
                                                   p.view, q / r);
                sum += f64::ji_reflection(form, g, -1) * f64::fresnel_conductor(p.n, p.k, g.cos_i) *
                       std::max(0.0, -glm::dot(face, q) / r) / (r * r);
            }
        }
        sum *= 4 * glm::length(light.half_u) * glm::length(light.half_v) / (n * n);
        EXPECT_NEAR(reference_area_light(p, light).value / sum, 1, 2e-5) << incidence;
    }
}

// A window: brighter upwards, with a bar across it.
double window(double u, double v) {
    return std::abs(u - 0.1) < 0.15 ? 0 : 1 + 0.5 * v;
}

TEST(AreaLightReference, APictureIsASumOfItsPanes) {
    const auto p = point_at(35, 8, 4, 20);
    const glm::dvec3 centre = 2.0 * mirrored(p) + glm::dvec3(0.2, 0.1, 0);
    RectangleLight whole = rectangle_at(centre, 0.6, 0.3);
    const auto pane = [&](double lo, double hi) {
        RectangleLight part = whole;
        part.centre += 0.5 * (lo + hi) * whole.half_u;
        part.half_u *= 0.5 * (hi - lo);
        part.emission = [](double, double v) { return 1 + 0.5 * v; };
        return reference_area_light(p, part).value;
    };
    const double panes = pane(-1, -0.05) + pane(0.25, 1);
    whole.emission = window;
    EXPECT_NEAR(reference_area_light(p, whole, 1e-5).value / panes, 1, 1e-4);
}

TEST(AreaLight, NodesSeeThePicture) {
    double even_share = 0;
    for (const double incidence : {0.0, 40.0, 65.0}) {
        for (const double mu : {0.5, 3.0, 10.0}) {
            const auto p = point_at(incidence, mu, mu, 0);
            RectangleLight light =
                rectangle_at(2.0 * mirrored(p) + glm::dvec3(0.1, 0.05, 0), 0.6, 0.3);
            const double even = reference_area_light(p, light).value;
            light.emission = [](double u, double v) {
                return 1 + 0.6 * std::sin(3 * u) + 0.3 * std::cos(4 * v);
            };
            const double exact = reference_area_light(p, light).value;
            even_share = std::max(even_share, std::abs(exact / even - 1));
            EXPECT_NEAR(shared_double(p, light, 16, true) / exact, 1, 0.012) << incidence << mu;
            EXPECT_NEAR(shared_double(p, light, 4, false) / exact, 1, 0.2) << incidence << mu;
        }
    }
    EXPECT_GT(even_share, 0.1);  // the picture matters
}

TEST(AreaLightReference, ConvergesToItsOwnEstimate) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 24; ++i) {
        const double mu_b = 0.05 * std::pow(15 / 0.05, unit(random));
        auto p = point_at(85 * unit(random), std::min(15.0, 20 * mu_b), mu_b, 180 * unit(random));
        p.model = i % 2 == 0 ? AreaLightModel::ji : AreaLightModel::hamon;
        const double size = 0.005 * std::pow(200, unit(random));
        const auto rectangle = rectangle_at(mirrored(p), size, size * 0.3, unit(random));
        AreaLight light = rectangle;
        if (i % 3 == 1) light = EllipseLight{rectangle.centre, rectangle.half_u, rectangle.half_v};
        if (i % 3 == 2) light = SunLight{mirrored(p), std::min(0.7, size)};
        const auto rough = reference_area_light(p, light, 1e-3);
        const auto good = reference_area_light(p, light, 1e-5);
        const auto best = reference_area_light(p, light, 1e-7);
        ASSERT_GT(best.value, 0);
        EXPECT_LE(std::abs(rough.value / best.value - 1), 1e-3) << i;
        EXPECT_LE(std::abs(good.value / best.value - 1), 1e-5) << i;
    }
}

TEST(AreaLightReference, SphereIsItsConeOfDirectionsAndSpotItsBlend) {
    const auto p = point_at(40, 3, 1, 70);
    const glm::dvec3 centre = 3.0 * mirrored(p) + glm::dvec3(0, 0.1, 0);
    const double sphere = reference_area_light(p, SphereLight{centre, 0.6}).value;
    const double cone = reference_area_light(p, SunLight{glm::normalize(centre),
                                                         std::asin(0.6 / glm::length(centre))})
                            .value;
    EXPECT_NEAR(sphere / cone, 1, 1e-6);
    const glm::dvec3 axis = -glm::normalize(centre);
    EXPECT_NEAR(
        reference_area_light(p, SpotLight{centre, 0.6, axis, std::cos(1.0), 0.1}).value / sphere, 1,
        1e-6);
    EXPECT_EQ(reference_area_light(p, SpotLight{centre, 0.6, -axis, std::cos(0.5), 0.1}).value, 0);
    const double part =
        reference_area_light(p, SpotLight{centre, 0.6, axis, std::cos(0.15), 1}).value;
    EXPECT_GT(part, 0.02 * sphere);
    EXPECT_LT(part, 0.98 * sphere);
}

TEST(AreaLightReference, NothingFromBehind) {
    const auto p = point_at(30, 2, 2, 0);
    const auto front = rectangle_at(mirrored(p), 0.2, 0.2);
    EXPECT_GT(reference_area_light(p, front).value, 0);
    // The light's own back, below the horizon, inside a sphere.
    EXPECT_EQ(
        reference_area_light(p, RectangleLight{front.centre, front.half_v, front.half_u}).value, 0);
    EXPECT_EQ(reference_area_light(p, rectangle_at({0, 0, -1}, 0.2, 0.2)).value, 0);
    EXPECT_EQ(reference_area_light(p, SphereLight{{0.1, 0, 0.1}, 1}).value, 0);
}

// --- the shared formulas
// --------------------------------------------------------------------------

TEST(AreaLight, NormalPartAgainstErf) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 20'000; ++i) {
        const double a = -5 + 10 * unit(random), b = a + 10 * std::pow(unit(random), 4);
        const auto part = f64::normal_part(a, b);
        const double share = 0.5 * (std::erf(b / std::sqrt(2)) - std::erf(a / std::sqrt(2)));
        ASSERT_NEAR(part.share, share, 6e-7);
        ASSERT_TRUE(part.mean >= a && part.mean <= b);
        ASSERT_TRUE(part.spread >= 0 && part.spread <= (b - a) / std::sqrt(12) + 1e-12);
        const auto part32 = f32::normal_part(static_cast<float>(a), static_cast<float>(b));
        ASSERT_NEAR(static_cast<double>(part32.share), share, 1e-6);
    }
    EXPECT_NEAR(f64::normal_part(-1e9, 1e9).share, 1, 1e-12);
    EXPECT_NEAR(f64::normal_part(-1e9, 1e9).spread, 1, 1e-6);
    EXPECT_EQ(f64::normal_part(1, 1).share, 0);
    EXPECT_EQ(f64::normal_part(2, 1).share, 0);
}

TEST(AreaLight, GaussNodesIntegratePolynomials) {
    for (const int count : {1, 2, 3, 4, 6, 8, 12, 16, 32}) {
        for (int power = 0; power < 2 * std::min(count, 16); ++power) {
            double sum = 0;
            for (int k = 0; k < count; ++k) {
                const auto node = f64::gauss_node(count, k);
                sum += node.y * std::pow(node.x, power);
            }
            EXPECT_NEAR(sum, power % 2 == 0 ? 2.0 / (power + 1) : 0.0, 1e-14) << count;
        }
    }
}

TEST(AreaLight, TinyLightIsAPointLight) {
    for (const double incidence : {0.0, 35.0, 70.0}) {
        const auto p = point_at(incidence, 2, 0.7, 30);
        const glm::dvec3 direction = glm::normalize(mirrored(p) + glm::dvec3(0.01, 0.02, 0));
        const auto frame = f64::tangent_frame(p.normal, p.tangent);
        const auto form = f64::lobe_form({p.lobe[0], p.lobe[1], p.lobe[2]});
        const auto g =
            f64::light_geometry(frame.normal, frame.tangent, frame.bitangent, p.view, direction);
        const double expected = f64::ji_reflection(form, g, -1);
        const double half = 0.008 * degree;
        for (const bool fine : {false, true}) {
            const auto light = rectangle_at(direction, half, half, 0.4);
            EXPECT_NEAR(shared_double(p, light, 4, fine) / (4 * half * half * expected), 1, 1e-3);
            EXPECT_NEAR(shared_float(p, light, 4, fine) / (4 * half * half * expected), 1, 2e-3);
            const EllipseLight disk{light.centre, light.half_u, light.half_v};
            const double area = std::numbers::pi * half * half;
            EXPECT_NEAR(shared_double(p, disk, 8, fine) / (area * expected), 1, 3e-3);
            EXPECT_NEAR(shared_float(p, SunLight{direction, half}, 8, fine) / (area * expected), 1,
                        8e-3);
        }
    }
}

TEST(AreaLight, HugeLightIsAFurnace) {
    // A light that covers the lobe to far beyond its reach: all that is emitted comes back (F = 1).
    for (const double mu : {0.05, 0.5, 3.0}) {
        const auto p = point_at(20, mu, mu / 3 > 0.05 ? mu / 3 : mu, 50);
        const auto light = rectangle_at(mirrored(p), 1.5, 1.5);
        EXPECT_NEAR(shared_float(p, light, 12, true), 1, 0.01) << mu;
        EXPECT_NEAR(shared_float(p, SunLight{mirrored(p), 1.0}, 12, true), 1, 0.01) << mu;
        EXPECT_NEAR(reference_area_light(p, light, 1e-5).value, 1, 0.01) << mu;
    }
}

TEST(AreaLight, AgreesWithTheReference) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 60; ++i) {
        const double aspect = std::pow(3, unit(random));
        const double mu_b = 0.05 * std::pow(5 / 0.05 / aspect, unit(random));
        auto p = point_at(60 * unit(random), mu_b * aspect, mu_b, 180 * unit(random));
        const double half = std::tan(0.25 * degree * std::pow(180, unit(random)));
        const auto rectangle =
            rectangle_at(mirrored(p), half, half * (0.2 + 0.8 * unit(random)), unit(random));
        AreaLight light = rectangle;
        if (i % 3 == 1) light = EllipseLight{rectangle.centre, rectangle.half_u, rectangle.half_v};
        if (i % 3 == 2) light = SunLight{mirrored(p), std::atan(half)};
        const double truth = reference_area_light(p, light, 1e-4).value;
        EXPECT_NEAR(shared_float(p, light, 16, true) / truth, 1, 0.01) << i;
        EXPECT_NEAR(shared_float(p, light, 4, false) / truth, 1, 0.1) << i;
    }
}

TEST(AreaLight, NothingFromBehindOrBelow) {
    const auto p = point_at(30, 2, 1, 40);
    const auto front = rectangle_at(mirrored(p), 0.2, 0.2);
    const RectangleLight back{front.centre, front.half_v, front.half_u};
    const auto below = rectangle_at({0.1, 0.1, -1}, 0.3, 0.3);
    for (const auto& light : {back, below}) {
        EXPECT_EQ(shared_float(p, light, 8, false), 0);
        EXPECT_EQ(shared_float(p, EllipseLight{light.centre, light.half_u, light.half_v}, 8, false),
                  0);
    }
    EXPECT_EQ(shared_float(p, SunLight{{0, 0, -1}, 0.2}, 8, false), 0);
}

TEST(AreaLight, MissedByTheMirrorDirectionIsDark) {
    const auto p = point_at(30, 0.5, 0.2, 40);
    const glm::dvec3 beside = glm::normalize(mirrored(p) + glm::dvec3(0.4, 0.1, 0));
    EXPECT_LT(shared_float(p, rectangle_at(beside, 0.05, 0.1), 8, false), 1e-6);
    EXPECT_LT(shared_float(p, SunLight{beside, 0.1}, 8, false), 1e-6);
    EXPECT_GT(shared_float(p, rectangle_at(mirrored(p), 0.05, 0.1), 8, false), 0.5);
}

TEST(AreaLight, MirroredSceneMirrorsTheRadiance) {
    // y -> -y turns rho around and swaps the light's axes' sense.
    for (int i = 0; i < 8; ++i) {
        const double rho = 20.0 * i, turn = 0.3 * i;
        const auto p = point_at(45, 3, 1, rho), q = point_at(45, 3, 1, 180 - rho);
        const auto light = rectangle_at(mirrored(p) + glm::dvec3(0, 0.05, 0.02), 0.1, 0.05, turn);
        const auto flip = [](const glm::dvec3& v) { return glm::dvec3(v.x, -v.y, v.z); };
        const RectangleLight other{flip(light.centre), flip(light.half_v), flip(light.half_u)};
        EXPECT_NEAR(shared_double(p, light, 16, false) / shared_double(q, other, 16, false), 1,
                    1e-6);
    }
}

TEST(AreaLight, FloatIsDouble) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 400; ++i) {
        const double mu_b = 0.05 * std::pow(300, unit(random));
        const auto p = point_at(80 * unit(random), std::min(15.0, mu_b * (1 + 9 * unit(random))),
                                mu_b, 180 * unit(random));
        const double half = std::tan(0.25 * degree * std::pow(180, unit(random)));
        const auto rectangle =
            rectangle_at(mirrored(p), half, half * (0.1 + 0.9 * unit(random)), 6 * unit(random));
        AreaLight light = rectangle;
        if (i % 3 == 1) light = EllipseLight{rectangle.centre, rectangle.half_u, rectangle.half_v};
        if (i % 3 == 2) light = SunLight{mirrored(p), std::atan(half)};
        const double wide = shared_double(p, light, 12, false);
        EXPECT_NEAR(shared_float(p, light, 12, false) / wide, 1, 5e-3) << i;
    }
}

// Single points of tests/bench/bench_light.cpp that once were the worst ones.
TEST(AreaLight, EightSlicesKeepTheWorstPoints) {
    struct Worst {
        std::array<double, 3> lobe;
        glm::dvec3 view, centre, u, v;
        double half, angle;  // angle: of a sun, else 0
    };
    const Worst all[] = {
        // The rim far off the lobe.
        {{-0.58671, -0.58303, 0.75040},
         {-0.664242, -0.718086, 0.207689},
         {0.998296, 0.617076, -0.208248},
         {0.343796, 0.345267, -0.873267},
         {0.579260, -0.809915, -0.092171},
         0.517849,
         0.000000},
        // The same.
        {{0.40595, 0.57608, -0.05039},
         {-0.958140, 0.207678, 0.197072},
         {1.047644, -0.382582, -0.048457},
         {-0.221822, 0.177529, 0.958790},
         {-0.199883, 0.954127, -0.222910},
         0.267762,
         0.000000},
        // An outline that closes between two steps.
        {{2.40449, 0.00000, 0.00000},
         {0.909507, -0.295897, 0.291963},
         {-1.036240, 0.047174, 0.266733},
         {0.238181, 0.647515, 0.723874},
         {-0.412641, -0.607241, 0.678959},
         0.299483,
         0.000000},
        // Slices cut on either side.
        {{0.07962, -0.93913, -0.25935},
         {-0.660843, -0.644483, 0.384614},
         {0.687001, 0.613178, 0.370506},
         {0.501501, -0.676750, -0.538987},
         {0.496961, -0.284623, 0.819768},
         0.093235,
         0.000000},
        // Ended by the horizon.
        {{2.21427, 0.40148, -0.18609},
         {0.806726, -0.010032, 0.590841},
         {-0.768682, -0.361965, 0.527361},
         {-0.009279, 0.654487, 0.756016},
         {0.941499, -0.248996, 0.227113},
         0.663318,
         0.585681},
        // Masking begins far off.
        {{2.05145, 0.00000, -0.00000},
         {0.015217, 0.969508, 0.244588},
         {-0.015217, -0.969508, 0.244588},
         {0.528129, 0.492741, 0.691582},
         {0.749463, -0.653373, -0.106813},
         0.953085,
         0.761382},
    };
    for (const Worst& w : all) {
        AreaLightPoint p;
        p.normal = {0, 0, 1};
        p.tangent = {1, 0, 0};
        p.view = glm::normalize(w.view);
        p.lobe = w.lobe;
        AreaLight light = EllipseLight{w.centre, w.half * w.u, w.half * w.v};
        if (w.angle > 0) light = SunLight{glm::normalize(w.centre), w.angle};
        const double truth = reference_area_light(p, light, 1e-4).value;
        EXPECT_NEAR(shared_float(p, light, 8, true) / truth, 1, 0.01) << w.lobe[0];
        EXPECT_NEAR(shared_float(p, light, 16, true) / truth, 1, 0.003) << w.lobe[0];
    }
}

// To a float all directions of a small light are nearly the same.
TEST(AreaLight, SmallLightsKeepTheirShapeInFloat) {
    for (const double mu : {0.05, 3.0}) {
        for (const double half : {1.2e-4, 3e-4, 1e-3}) {
            for (const double off : {0.0, 1.5, 3.0}) {
                const auto p = point_at(40, mu, mu, 0);
                const double turn = 2 * off * mu * degree / 1.17741;
                const auto rectangle =
                    rectangle_at(glm::normalize(mirrored(p) + turn * glm::dvec3(0.3, 0.954, 0)),
                                 half, half, 0.4);
                const double peak =
                    shared_double(p, rectangle_at(mirrored(p), half, half, 0.4), 16, false);
                const AreaLight lights[] = {
                    rectangle, EllipseLight{rectangle.centre, rectangle.half_u, rectangle.half_v},
                    SunLight{rectangle.centre, std::atan(half)}};
                for (const AreaLight& light : lights) {
                    EXPECT_NEAR(shared_float(p, light, 16, true), shared_double(p, light, 16, true),
                                5e-3 * peak)
                        << mu << ' ' << half << ' ' << off << ' ' << light.index();
                }
            }
        }
    }
}

TEST(AreaLight, ExtremesAreFinite) {
    const float inf = std::numeric_limits<float>::infinity();
    for (const double incidence : {0.0, 45.0, 89.0, 89.999}) {
        for (const double mu : {0.001, 0.05, 15.0, 80.0}) {
            for (const double aspect : {1.0, 20.0, 100.0}) {
                const auto p = point_at(incidence, mu, std::max(mu / aspect, 0.001), 33);
                for (const double distance : {1e-6, 1.0, 1e4}) {
                    for (const double size : {0.0, 1e-9, 0.1, 100.0}) {
                        const auto shape = rectangle_at(
                            distance * mirrored(p) + glm::dvec3(0, 0, 1e-9), 1, 1, 0.2);
                        for (const bool fine : {false, true}) {
                            const int count = fine ? 8 : 4;
                            const auto frame =
                                f32::tangent_frame(glm::vec3(p.normal), glm::vec3(p.tangent));
                            const auto form = f32::lobe_form({static_cast<float>(p.lobe[0]),
                                                              static_cast<float>(p.lobe[1]),
                                                              static_cast<float>(p.lobe[2])});
                            const auto light =
                                f32::flat_light(glm::vec3(shape.centre), glm::vec3(shape.half_u),
                                                glm::vec3(shape.half_v), static_cast<float>(size),
                                                static_cast<float>(size));
                            const glm::vec3 view(p.view);
                            const auto check = [&](const f32::LightNode& n) {
                                ASSERT_TRUE(n.measure >= 0 && n.measure < inf)
                                    << incidence << ' ' << mu << ' ' << distance << ' ' << size;
                                ASSERT_TRUE(n.n_dot_l <= 1.001F && n.v_dot_h <= 1.001F);
                            };
                            const auto r = f32::rectangle_slices(light, frame, view, form, count);
                            const auto e = f32::ellipse_slices(light, frame, view, form, count);
                            const auto s =
                                f32::cone_slices(glm::vec3(mirrored(p)), static_cast<float>(size),
                                                 frame, view, form, count);
                            for (int k = 0; k < count; ++k) {
                                if (fine) {
                                    check(f32::rectangle_slice_fine(r, count, k).lower.first);
                                    check(f32::disk_slice_fine(e, count, k).upper.second);
                                    check(f32::disk_slice_fine(s, count, k).lower.second);
                                } else {
                                    check(f32::rectangle_slice(r, count, k).second);
                                    check(f32::disk_slice(e, count, k).first);
                                    check(f32::disk_slice(s, count, k).second);
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

}  // namespace
