#include "capture/diffuse_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include <Eigen/Dense>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/parallel.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr std::size_t mu_count = 33;
constexpr double least_mu_deg = 0.2, most_mu_deg = 15;
constexpr std::size_t most_points = 96;
/// One over the variance of a share of which nothing is known but that it lies in [0, 1].
constexpr double share_information = 12;

std::string number(double value, const char* format = "%.2g") {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

struct Point {
    std::vector<std::vector<double>> radiance;  // [source][mu]
    std::vector<double> sigma_ln_mu;
    double sigma_w = 0;   // the larger of a surface all ji and one all ha
    double contrast = 0;  // between any two polishes
};

constexpr std::array<PlotColour, 6> line_colours{
    {{31, 119, 180}, {214, 90, 30}, {44, 140, 60}, {150, 60, 150}, {120, 90, 60}, {90, 90, 90}}};

PlotColour mask_colour(std::uint8_t mask) {
    if ((mask & mask_unseen) != 0) return {28, 28, 32};
    if ((mask & (mask_clipped | mask_not_finite)) != 0) return {230, 60, 60};
    if ((mask & mask_misfit) != 0) return {200, 60, 200};
    if ((mask & mask_ambiguous) != 0) return {240, 150, 40};
    if ((mask & mask_border) != 0) return {60, 60, 66};
    return {96, 96, 140};
}

// Dark blue over green to yellow, even in lightness.
PlotColour scale_colour(double x) {
    constexpr std::array<std::array<double, 3>, 5> stops{
        {{45, 30, 90}, {50, 90, 150}, {40, 150, 140}, {120, 200, 90}, {250, 235, 60}}};
    const double at = std::clamp(x, 0.0, 1.0) * (stops.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), stops.size() - 2);
    const double f = at - static_cast<double>(i);
    const auto mix = [&](std::size_t c) {
        return static_cast<std::uint8_t>(
            std::lround(stops[i][c] + f * (stops[i + 1][c] - stops[i][c])));
    };
    return {mix(0), mix(1), mix(2)};
}

template <class Colour>
Picture picture_of(const DiffuseResult& result, const Colour& colour) {
    Picture picture;
    picture.width = static_cast<int>(result.width);
    picture.height = static_cast<int>(result.height);
    picture.rgb.reserve(3 * result.mask.size());
    for (std::size_t i = 0; i < result.mask.size(); ++i) {
        const PlotColour c = colour(i);
        picture.rgb.insert(picture.rgb.end(), {c.r, c.g, c.b});
    }
    return picture;
}

}  // namespace

DiffusePlan plan_diffuse(const SurfaceView& view, const std::vector<DiffuseSource>& sources,
                         const DiffuseOptions& options, double sigma) {
    if (sources.empty()) throw InputError("plan", "sources", "none", "one or more");
    for (const DiffuseSource& source : sources) check_source(source, "plan");
    if (!(sigma > 0)) throw InputError("plan", "sigma", std::to_string(sigma), "above 0");
    std::vector<std::size_t> seen;
    glm::dvec3 mean(0);
    const std::vector<std::uint8_t> evaluated = evaluated_pixels(view);
    for (std::size_t i = 0; i < view.pixels(); ++i) {
        if (evaluated[i] == 0) continue;
        seen.push_back(i);
        mean += view.position_mm[i];
    }
    if (seen.empty())
        throw InputError("plan", "surface", "not in the picture", "a surface that is seen");
    mean /= static_cast<double>(seen.size());
    // Points all over the surface, and the one nearest to its middle first.
    std::vector<std::size_t> points{
        *std::min_element(seen.begin(), seen.end(), [&](std::size_t a, std::size_t b) {
            return glm::length(view.position_mm[a] - mean) <
                   glm::length(view.position_mm[b] - mean);
        })};
    const std::size_t step = std::max<std::size_t>(1, seen.size() / most_points);
    for (std::size_t k = step / 2; k < seen.size(); k += step) points.push_back(seen[k]);

    DiffusePlan plan;
    plan.mu_deg.resize(mu_count);
    for (std::size_t k = 0; k < mu_count; ++k) {
        plan.mu_deg[k] = least_mu_deg * std::pow(most_mu_deg / least_mu_deg,
                                                 static_cast<double>(k) / (mu_count - 1));
    }
    const double step_ln = std::log(plan.mu_deg[1] / plan.mu_deg[0]);
    const LuminousFresnel fresnel(options.metal, options.light);
    const auto ji = stored_lobe(options.ji), ha = stored_lobe(options.ha);
    const double max_phi = 65 * double(TG_RAD_PER_DEG);
    const auto noise = [&](double radiance) {
        return std::hypot(sigma * std::sqrt(std::max(radiance, 0.02)), options.model_error);
    };
    std::vector<Point> found(points.size());
    parallel_for(
        points.size(), 1,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                const std::size_t i = points[n];
                Point& point = found[n];
                const SurfacePose pose{
                    view.position_mm[i], glm::normalize(glm::dvec3(view.normal[i])),
                    glm::dvec3(view.tangent[i]), view.camera.view(view.position_mm[i])};
                // Of ln mu and of w towards the other lobe; and of w, ln mu of ji and of ha.
                std::vector<Eigen::Matrix2d> information(mu_count, Eigen::Matrix2d::Zero());
                std::array<Eigen::Matrix3d, 2> shares{Eigen::Matrix3d::Zero(),
                                                      Eigen::Matrix3d::Zero()};
                for (const DiffuseSource& source : sources) {
                    const DiffuseResponse response(source, pose, fresnel,
                                                   {options.ji.weight, options.ha.weight}, max_phi);
                    std::vector<double> c(mu_count);
                    for (std::size_t k = 0; k < mu_count; ++k)
                        c[k] = response.ji({std::log(plan.mu_deg[k]), ji[1], ji[2]});
                    const double f = response.ji(ji), t = response.ha(ha);
                    for (std::size_t k = 0; k < mu_count; ++k) {
                        const std::size_t a = k > 0 ? k - 1 : 0, b = std::min(k + 1, mu_count - 1);
                        const double slope = (c[b] - c[a]) / (step_ln * static_cast<double>(b - a));
                        const double other =
                            std::log(plan.mu_deg[k]) < 0.5 * (ji[0] + ha[0]) ? t : f;
                        const Eigen::Vector2d j =
                            Eigen::Vector2d(slope, other - c[k]) / noise(c[k]);
                        information[k] += j * j.transpose();
                    }
                    constexpr double s = 0.05;
                    const double slope_f = (response.ji({ji[0] + s, ji[1], ji[2]}) - f) / s;
                    const double slope_t = (response.ha({ha[0] + s, ha[1], ha[2]}) - t) / s;
                    for (const double w : {0.0, 1.0}) {
                        const Eigen::Vector3d j =
                            Eigen::Vector3d(t - f, (1 - w) * slope_f, w * slope_t) /
                            noise((1 - w) * f + w * t);
                        shares[w > 0.5 ? 1 : 0] += j * j.transpose();
                    }
                    const auto [low, high] = std::minmax_element(c.begin(), c.end());
                    point.contrast =
                        std::max({point.contrast, (*high - *low) / std::max(*high, 1e-6),
                                  std::abs(t - f) / std::max({t, f, 1e-6})});
                    point.radiance.push_back(std::move(c));
                }
                for (Eigen::Matrix2d& v : information) {
                    // With one photograph w has to be known.
                    v(1, 1) += sources.size() > 1 ? share_information : 1e12;
                    const double det = v.determinant();
                    point.sigma_ln_mu.push_back(det > 0 && v(0, 0) > 0
                                                    ? std::sqrt(v(1, 1) / det)
                                                    : std::numeric_limits<double>::infinity());
                }
                const double spread = sources.size() > 1 ? options.spread : options.known_spread;
                for (Eigen::Matrix3d& v : shares) {
                    v.diagonal() += Eigen::Vector3d(share_information, 1 / (spread * spread),
                                                    1 / (spread * spread));
                    point.sigma_w = std::max(point.sigma_w, std::sqrt(v.inverse()(0, 0)));
                }
            }
        },
        options.threads);

    for (std::size_t p = 0; p < sources.size(); ++p) {
        DiffusePlanCurve curve;
        curve.radiance = found[0].radiance[p];
        for (std::size_t k = 1; k + 1 < mu_count; ++k) {
            const double before = curve.radiance[k] - curve.radiance[k - 1],
                         after = curve.radiance[k + 1] - curve.radiance[k];
            // A turn, not the noise of a flat line.
            if (before * after < 0 && std::abs(before - after) > 1e-4)
                curve.flat_at_deg.push_back(plan.mu_deg[k]);
        }
        plan.photographs.push_back(std::move(curve));
    }
    double contrast = 0;
    for (std::size_t k = 0; k < mu_count; ++k) {
        std::vector<double> sigmas;
        double good = 0;
        for (const Point& point : found) {
            sigmas.push_back(point.sigma_ln_mu[k]);
            good += point.sigma_ln_mu[k] <= options.max_sigma_ln_mu ? 1 : 0;
        }
        plan.sigma_ln_mu.push_back(median(sigmas));
        plan.mu_share.push_back(good / static_cast<double>(found.size()));
    }
    for (const Point& point : found) {
        plan.w_share += point.sigma_w <= options.max_sigma_w ? 1 : 0;
        contrast = std::max(contrast, point.contrast);
    }
    plan.w_share /= static_cast<double>(found.size());
    plan.blind =
        contrast < 0.05 ||
        (plan.w_share == 0 && *std::max_element(plan.mu_share.begin(), plan.mu_share.end()) == 0);

    if (plan.blind) {
        plan.sentences.push_back(
            "Every polish has the same radiance under these sources, as under an even hemisphere: "
            "they tell neither the half width nor ji from hamon. Leave part of the directions "
            "dark.");
        return plan;
    }
    for (std::size_t p = 0; p < sources.size(); ++p) {
        for (const double mu : plan.photographs[p].flat_at_deg) {
            plan.sentences.push_back("Photograph " + std::to_string(p + 1) +
                                     ": at the middle of the surface radiance does not change "
                                     "about " +
                                     number(mu) + " degrees, and either side looks alike.");
        }
    }
    const auto visible = [&](std::size_t k) { return plan.mu_share[k] >= 0.5; };
    for (std::size_t k = 0; k < mu_count; ++k) {
        if (!visible(k)) continue;
        std::size_t last = k;
        while (last + 1 < mu_count && visible(last + 1)) ++last;
        plan.sentences.push_back("Half widths of " + number(plan.mu_deg[k]) + " to " +
                                 number(plan.mu_deg[last]) + " degrees are held to " +
                                 number(100 * options.max_sigma_ln_mu, "%.0f") +
                                 " % on half of the surface or more" +
                                 (sources.size() == 1 ? ", where w is known." : "."));
        k = last;
    }
    if (std::none_of(plan.mu_share.begin(), plan.mu_share.end(),
                     [](double share) { return share >= 0.5; })) {
        plan.sentences.push_back(
            "No half width is held to " + number(100 * options.max_sigma_ln_mu, "%.0f") +
            " % on half of the surface: best " +
            number(100 * *std::max_element(plan.mu_share.begin(), plan.mu_share.end()), "%.0f") +
            " % of it.");
    }
    plan.sentences.push_back(
        "Ji and hamon are told apart (w to " + number(options.max_sigma_w) + ") on " +
        number(100 * plan.w_share, "%.0f") + " % of the surface, where the lobes are known to " +
        number(100 * (sources.size() > 1 ? options.spread : options.known_spread), "%.0f") + " %.");
    return plan;
}

Picture plot_plan(const DiffusePlan& plan) {
    constexpr double left = 90, right = 1170, top = 60, bottom = 470, low_top = 520,
                     low_bottom = 680;
    const PlotColour ink{40, 40, 44}, grid{225, 225, 228};
    Canvas canvas(1200, 760, {255, 255, 255});
    const double x0 = std::log(least_mu_deg), x1 = std::log(most_mu_deg);
    const auto x_of = [&](double mu) {
        return left + (right - left) * (std::log(mu) - x0) / (x1 - x0);
    };
    double most = 0.05;
    for (const auto& curve : plan.photographs)
        for (const double v : curve.radiance) most = std::max(most, v);
    most = std::ceil(most * 10) / 10;
    const auto y_of = [&](double v) { return bottom - (bottom - top) * v / most; };
    for (const double mu : {0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0}) {
        canvas.stroke({{x_of(mu), top}, {x_of(mu), bottom}}, 1, grid);
        canvas.stroke({{x_of(mu), low_top}, {x_of(mu), low_bottom}}, 1, grid);
        canvas.text({x_of(mu), low_bottom + 24}, number(mu), 11, ink, TextAlign::centre);
    }
    for (int k = 0; k <= 5; ++k) {
        const double v = most * k / 5;
        canvas.stroke({{left, y_of(v)}, {right, y_of(v)}}, 1, grid);
        canvas.text({left - 10, y_of(v) + 5}, number(v, "%.2f"), 11, ink, TextAlign::right);
    }
    for (const double share : {0.0, 0.5, 1.0}) {
        const double y = low_bottom - (low_bottom - low_top) * share;
        canvas.stroke({{left, y}, {right, y}}, 1, grid);
        canvas.text({left - 10, y + 5}, number(100 * share, "%.0f %%"), 11, ink, TextAlign::right);
    }
    canvas.text({left, top - 22}, "Radiance over the source's, at the middle of the surface", 13,
                ink);
    canvas.text({left, low_top - 14}, "Share of the surface that tells this half width", 13, ink);
    canvas.text({(left + right) / 2, 745}, "half width, degrees", 13, ink, TextAlign::centre);
    for (std::size_t p = 0; p < plan.photographs.size(); ++p) {
        const PlotColour colour = line_colours[p % line_colours.size()];
        std::vector<PlotPoint> line;
        line.reserve(plan.mu_deg.size());
        for (std::size_t k = 0; k < plan.mu_deg.size(); ++k)
            line.push_back({x_of(plan.mu_deg[k]), y_of(plan.photographs[p].radiance[k])});
        canvas.stroke(line, 2.5, colour);
        for (const double mu : plan.photographs[p].flat_at_deg) {
            const auto k = static_cast<std::size_t>(
                std::find(plan.mu_deg.begin(), plan.mu_deg.end(), mu) - plan.mu_deg.begin());
            canvas.ring({x_of(mu), y_of(plan.photographs[p].radiance[k])}, 7, 2, colour);
        }
        const double y = top + 6 + 22 * static_cast<double>(p);
        canvas.stroke({{right - 150, y}, {right - 120, y}}, 2.5, colour);
        canvas.text({right - 110, y + 5}, "photograph " + std::to_string(p + 1), 12, ink);
    }
    std::vector<PlotPoint> share;
    share.reserve(plan.mu_deg.size());
    for (std::size_t k = 0; k < plan.mu_deg.size(); ++k) {
        share.push_back(
            {x_of(plan.mu_deg[k]), low_bottom - (low_bottom - low_top) * plan.mu_share[k]});
    }
    canvas.stroke(share, 2.5, ink);
    return canvas.picture();
}

Picture picture_of_w(const DiffuseResult& result) {
    return picture_of(result, [&](std::size_t i) {
        if ((result.mask[i] & mask_no_w) != 0) return mask_colour(result.mask[i]);
        const auto grey =
            static_cast<std::uint8_t>(std::lround(40 + 215 * static_cast<double>(result.w[i])));
        return PlotColour{grey, grey, grey};
    });
}

Picture picture_of_mu(const DiffuseResult& result) {
    return picture_of(result, [&](std::size_t i) {
        if ((result.mask[i] & mask_no_mu) != 0) return mask_colour(result.mask[i]);
        const double ln_mu = result.w[i] > 0.5F ? result.ha_ln_mu_deg[i] : result.ji_ln_mu_deg[i];
        return scale_colour((ln_mu - std::log(0.3)) / (std::log(10) - std::log(0.3)));
    });
}

}  // namespace togishi
