#include "capture/diffuse.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

#include <Eigen/Dense>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/parallel.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

/// ln mu at which the lobes' radiances are kept, about the material's own.
constexpr int nodes = 13;
constexpr double node_range = 1.2;
constexpr double node_step = 2 * node_range / (nodes - 1);
/// Parameters: w, ln mu of ji and ha; with hadori also its share of the rest and its ln mu.
enum Parameter : int { at_w, at_ji, at_ha, at_h, at_hadori, most_parameters };
constexpr int without_hadori = at_h;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_parameters, 1>;
using Matrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_parameters, most_parameters>;
/// One over the variance of a share of which nothing is known but that it lies in [0, 1].
constexpr double share_information = 12;

/// Radiances of the lobes over ln mu, for one photograph at one pixel.
struct Curves {
    std::array<float, nodes> ji{}, ha{}, hadori{};
};

struct Sample {
    double value = 0, slope = 0;
};

// Cubic through four nodes (Catmull-Rom): smooth, so that a fit does not stick at a node.
Sample sample(const std::array<float, nodes>& curve, double s) {
    const double x = std::clamp((s + node_range) / node_step, 0.0, nodes - 1.0);
    const int i = std::min(static_cast<int>(x), nodes - 2);
    const double t = x - i;
    const auto at = [&](int k) { return static_cast<double>(curve[static_cast<std::size_t>(k)]); };
    const double p1 = at(i), p2 = at(i + 1), p0 = i > 0 ? at(i - 1) : 2 * p1 - p2,
                 p3 = i + 2 < nodes ? at(i + 2) : 2 * p2 - p1;
    const double a = 0.5 * (3 * (p1 - p2) + p3 - p0), b = p0 - 2.5 * p1 + 2 * p2 - 0.5 * p3,
                 c = 0.5 * (p2 - p0);
    return {p1 + t * (c + t * (b + t * a)), (c + t * (2 * b + t * 3 * a)) / node_step};
}

struct Reading {
    double radiance, sigma;
};

// One pixel's problem.
class Pixel {
  public:
    Pixel(const std::vector<Curves>& curves, const std::vector<Reading>& readings, double spread,
          bool hadori)
        : curves_(curves),
          readings_(readings),
          prior_(1 / (spread * spread)),
          size_(hadori ? most_parameters : without_hadori) {}

    struct Linear {
        double chi2 = 0;
        Matrix information;  // without the prior
        Vector gradient;
    };
    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] bool hadori() const { return size_ > without_hadori; }
    [[nodiscard]] Vector none() const { return Vector::Zero(size_); }
    [[nodiscard]] static bool is_share(int k) { return k == at_w || k == at_h; }
    [[nodiscard]] double prior() const { return prior_; }

    [[nodiscard]] Linear linearise(const Vector& x) const {
        Linear out{0, Matrix::Zero(size_, size_), none()};
        Vector j = none();
        for (std::size_t p = 0; p < readings_.size(); ++p) {
            const double inverse = 1 / readings_[p].sigma;
            const double r = (readings_[p].radiance - modelled(p, x, &j)) * inverse;
            j *= inverse;
            out.chi2 += r * r;
            out.information += j * j.transpose();
            out.gradient += j * r;
        }
        return out;
    }
    [[nodiscard]] double cost(const Vector& x) const {
        double sum = 0;
        for (int k = 0; k < size_; ++k)
            if (!is_share(k)) sum += prior_ * x[k] * x[k];
        for (std::size_t p = 0; p < readings_.size(); ++p) {
            const double r = (readings_[p].radiance - modelled(p, x, nullptr)) / readings_[p].sigma;
            sum += r * r;
        }
        return sum;
    }
    /// The best w in [0, 1] where the rest of x is given.
    [[nodiscard]] double best_w(Vector x) const {
        double top = 0, bottom = 0;
        for (std::size_t p = 0; p < readings_.size(); ++p) {
            x[at_w] = 0;
            const double rest = modelled(p, x, nullptr);
            x[at_w] = 1;
            const double d = modelled(p, x, nullptr) - rest;
            const double weight = 1 / (readings_[p].sigma * readings_[p].sigma);
            top += weight * d * (readings_[p].radiance - rest);
            bottom += weight * d * d;
        }
        return bottom > 0 ? std::clamp(top / bottom, 0.0, 1.0) : 0.5;
    }
    /// Levenberg-Marquardt within shares of 0 to 1 and the nodes' range.
    [[nodiscard]] Vector refine(Vector x) const {
        double lambda = 1e-3, best = cost(x);
        for (int step = 0; step < 25; ++step) {
            Linear l = linearise(x);
            for (int k = 0; k < size_; ++k) {
                if (!is_share(k)) {
                    l.information(k, k) += prior_;
                    l.gradient[k] -= prior_ * x[k];
                } else if ((x[k] <= 0 && l.gradient[k] < 0) || (x[k] >= 1 && l.gradient[k] > 0)) {
                    // A share that is held at its border takes no part.
                    l.information.row(k).setZero();
                    l.information.col(k).setZero();
                    l.information(k, k) = 1;
                    l.gradient[k] = 0;
                }
            }
            Matrix damped = l.information;
            damped.diagonal() *= 1 + lambda;
            damped.diagonal().array() += 1e-12;
            Vector next = x + damped.ldlt().solve(l.gradient);
            for (int k = 0; k < size_; ++k) {
                next[k] = is_share(k) ? std::clamp(next[k], 0.0, 1.0)
                                      : std::clamp(next[k], -node_range, node_range);
            }
            const double found = cost(next);
            if (found <= best) {
                const double gain = best - found;
                x = next;
                best = found;
                lambda = std::max(lambda * 0.2, 1e-9);
                if (gain < 1e-6 * (1 + best)) break;
            } else {
                lambda *= 8;
                if (lambda > 1e9) break;
            }
        }
        return x;
    }

  private:
    [[nodiscard]] double modelled(std::size_t p, const Vector& x, Vector* slope) const {
        const double w = x[at_w];
        const Sample ji = sample(curves_[p].ji, x[at_ji]), ha = sample(curves_[p].ha, x[at_ha]);
        double rest = ji.value, h = 0;
        if (hadori()) {
            const Sample white = sample(curves_[p].hadori, x[at_hadori]);
            h = x[at_h];
            rest += h * (white.value - ji.value);
            if (slope != nullptr) {
                (*slope)[at_h] = (1 - w) * (white.value - ji.value);
                (*slope)[at_hadori] = (1 - w) * h * white.slope;
            }
        }
        if (slope != nullptr) {
            (*slope)[at_w] = ha.value - rest;
            (*slope)[at_ji] = (1 - w) * (1 - h) * ji.slope;
            (*slope)[at_ha] = w * ha.slope;
        }
        return (1 - w) * rest + w * ha.value;
    }

    const std::vector<Curves>& curves_;
    const std::vector<Reading>& readings_;
    double prior_;
    int size_;
};

// The parameter of the lobe that has most of a pixel.
int leading_lobe(const Vector& x) {
    const double h = x.size() > without_hadori ? x[at_h] : 0, w = x[at_w];
    const double ji = (1 - w) * (1 - h), white = (1 - w) * h;
    if (w >= ji && w >= white) return at_ha;
    return white > ji ? at_hadori : at_ji;
}

struct Answer {
    Vector x, sigma;
    double sigma_lead = 0;  // of the leading lobe's ln mu, by the photographs alone
    double chi2 = 0;
    bool ambiguous = false;
};

double safe_root(double v) {
    return v > 0 ? std::sqrt(v) : 0.0;
}

// Where a fit begins: each lobe in turn over its range, only the valleys, w by the straight line;
// with hadori also some of its shares.
std::vector<Vector> starts_of(const Pixel& pixel, bool fit_mu) {
    std::vector<Vector> starts;
    const auto with_w = [&](Vector x) {
        x[at_w] = pixel.best_w(x);
        return x;
    };
    if (!fit_mu) {
        starts.push_back(with_w(pixel.none()));
    } else {
        for (const int lobe : {int(at_ji), int(at_ha)}) {
            std::array<Vector, nodes> scan;
            std::array<double, nodes> costs{};
            for (std::size_t k = 0; k < nodes; ++k) {
                Vector x = pixel.none();
                x[lobe] = -node_range + static_cast<double>(k) * node_step;
                scan[k] = with_w(x);
                costs[k] = pixel.cost(scan[k]);
            }
            for (std::size_t k = 0; k < nodes; ++k) {
                if ((k == 0 || costs[k] <= costs[k - 1]) &&
                    (k + 1 == nodes || costs[k] < costs[k + 1]))
                    starts.push_back(scan[k]);
            }
        }
    }
    if (pixel.hadori()) {
        for (const double h : {0.5, 1.0}) {
            Vector x = pixel.none();
            x[at_h] = h;
            starts.push_back(with_w(x));
        }
    }
    if (starts.empty()) starts.push_back(with_w(pixel.none()));
    return starts;
}

Answer solve_pixel(const Pixel& pixel, bool fit_mu) {
    Answer answer;
    const std::vector<Vector> starts = starts_of(pixel, fit_mu);
    std::vector<Vector> found;
    std::vector<double> costs;
    found.reserve(starts.size());
    costs.reserve(starts.size());
    for (const Vector& start : starts) {
        found.push_back(pixel.refine(start));
        costs.push_back(pixel.cost(found.back()));
    }
    const auto best =
        static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
    answer.x = found[best];
    const int lead = leading_lobe(answer.x);
    const auto white = [&](const Vector& x) {
        return pixel.hadori() ? (1 - x[at_w]) * x[at_h] : 0.0;
    };
    for (std::size_t k = 0; k < found.size(); ++k) {
        // Another answer nearly as good: within two standard deviations.
        if (costs[k] - costs[best] > 4) continue;
        const Vector d = found[k] - answer.x;
        if (std::abs(d[at_w]) > 0.15 || std::abs(d[lead]) > 0.25 ||
            std::abs(white(found[k]) - white(answer.x)) > 0.15)
            answer.ambiguous = true;
    }
    const Pixel::Linear l = pixel.linearise(answer.x);
    answer.chi2 = l.chi2;
    Matrix full = l.information;
    for (int k = 0; k < pixel.size(); ++k)
        full(k, k) += Pixel::is_share(k) ? share_information : pixel.prior();
    const Matrix covariance = full.inverse();
    answer.sigma = pixel.none();
    for (int k = 0; k < pixel.size(); ++k) answer.sigma[k] = safe_root(covariance(k, k));
    Matrix alone = full;
    alone(lead, lead) -= pixel.prior();
    const Eigen::FullPivLU<Matrix> lu(alone);
    answer.sigma_lead = lu.isInvertible() ? safe_root(lu.inverse()(lead, lead))
                                          : std::numeric_limits<double>::infinity();
    if (answer.sigma_lead == 0) answer.sigma_lead = std::numeric_limits<double>::infinity();
    return answer;
}

// The lobes' radiances at a pixel.
class CurveMaker {
  public:
    CurveMaker(const SurfaceView& view, const std::vector<DiffusePhotograph>& photographs,
               const DiffuseOptions& options)
        : view_(view),
          photographs_(photographs),
          fresnel_(options.metal, options.light),
          weights_{options.ji.weight, options.ha.weight},
          ji_(stored_lobe(options.ji)),
          ha_(stored_lobe(options.ha)) {
        double wide = std::max(options.ji.mu_t_deg, options.ha.mu_t_deg);
        if (options.hadori) {
            hadori_ = stored_lobe(*options.hadori);
            hadori_weights_ = {-1, options.hadori->weight};
            wide = std::max(wide, options.hadori->mu_t_deg);
        }
        wide *= std::exp(node_range);
        max_phi_ = std::min(4.3 * wide, 75.0) * double(TG_RAD_PER_DEG);
    }
    [[nodiscard]] std::vector<Curves> at(std::size_t pixel) const {
        const glm::dvec3 point = view_.position_mm[pixel];
        const SurfacePose pose{point, glm::normalize(glm::dvec3(view_.normal[pixel])),
                               glm::dvec3(view_.tangent[pixel]), view_.camera.view(point)};
        std::vector<Curves> curves(photographs_.size());
        for (std::size_t p = 0; p < photographs_.size(); ++p) {
            const DiffuseResponse response(photographs_[p].source, pose, fresnel_, weights_,
                                           max_phi_);
            for (std::size_t k = 0; k < nodes; ++k) {
                const double s = -node_range + static_cast<double>(k) * node_step;
                curves[p].ji[k] = static_cast<float>(response.ji({ji_[0] + s, ji_[1], ji_[2]}));
                curves[p].ha[k] = static_cast<float>(response.ha({ha_[0] + s, ha_[1], ha_[2]}));
            }
            if (!hadori_) continue;
            // Hadori reflects by the hamon's formula, with a weight of its own.
            const std::array<double, 3>& lobe = *hadori_;
            const DiffuseResponse white(photographs_[p].source, pose, fresnel_, hadori_weights_,
                                        max_phi_);
            for (std::size_t k = 0; k < nodes; ++k) {
                const double s = -node_range + static_cast<double>(k) * node_step;
                curves[p].hadori[k] = static_cast<float>(white.ha({lobe[0] + s, lobe[1], lobe[2]}));
            }
        }
        return curves;
    }

  private:
    const SurfaceView& view_;
    const std::vector<DiffusePhotograph>& photographs_;
    LuminousFresnel fresnel_;
    LobeWeights weights_;
    std::array<double, 3> ji_, ha_;
    std::optional<std::array<double, 3>> hadori_;
    LobeWeights hadori_weights_;
    double max_phi_ = 0;
};

void check(const SurfaceView& view, const std::vector<DiffusePhotograph>& photographs,
           const DiffuseOptions& options) {
    if (photographs.empty()) throw InputError("diffuse", "photographs", "none", "one or more");
    const std::size_t n = view.pixels();
    for (std::size_t p = 0; p < photographs.size(); ++p) {
        const DiffusePhotograph& photograph = photographs[p];
        for (const std::size_t size :
             {photograph.radiance.size(), photograph.sigma.size(), photograph.clipped.size()}) {
            if (size != n) {
                throw InputError("diffuse", "photograph " + std::to_string(p + 1),
                                 std::to_string(size) + " pixels",
                                 std::to_string(n) + ", as the surface has");
            }
        }
        check_source(photograph.source, "photograph " + std::to_string(p + 1));
    }
    const auto positive = [](const char* field, double value) {
        if (!(value > 0 && value < 10))
            throw InputError("diffuse", field, std::to_string(value), "above 0, to 10");
    };
    positive("spread", options.spread);
    positive("known_spread", options.known_spread);
    positive("max_sigma_w", options.max_sigma_w);
    positive("max_sigma_ln_mu", options.max_sigma_ln_mu);
    if (!(options.border_px >= 0 && options.border_px <= 100))
        throw InputError("diffuse", "border_px", std::to_string(options.border_px), "0 to 100");
    if (options.hadori && photographs.size() < 2) {
        throw InputError("diffuse", "hadori", "one photograph",
                         "two or more: one radiance cannot tell the shares of three lobes");
    }
    if (!(options.model_error >= 0 && options.model_error < 1))
        throw InputError("diffuse", "model_error", std::to_string(options.model_error), "0 to 1");
}

void check_areas(const std::vector<ReferenceArea>& references, std::size_t width,
                 std::size_t height) {
    for (const ReferenceArea& area : references) {
        if (area.x < 0 || area.y < 0 || area.width < 1 || area.height < 1 ||
            static_cast<std::size_t>(area.x) + static_cast<std::size_t>(area.width) > width ||
            static_cast<std::size_t>(area.y) + static_cast<std::size_t>(area.height) > height) {
            throw InputError("reference", "box_px",
                             std::to_string(area.x) + ", " + std::to_string(area.y) + ", " +
                                 std::to_string(area.width) + ", " + std::to_string(area.height),
                             "x, y, width, height within the picture of " + std::to_string(width) +
                                 " x " + std::to_string(height));
        }
    }
}

// Whether a pixel nearer than `border_px` shows something else.
bool near_border(const std::vector<std::uint8_t>& evaluated, std::size_t width, std::size_t height,
                 std::size_t x, std::size_t y, double border_px) {
    const double reach = border_px + 0.5;
    const auto steps = static_cast<std::ptrdiff_t>(reach);
    for (std::ptrdiff_t dy = -steps; dy <= steps; ++dy) {
        for (std::ptrdiff_t dx = -steps; dx <= steps; ++dx) {
            const std::ptrdiff_t px = static_cast<std::ptrdiff_t>(x) + dx,
                                 py = static_cast<std::ptrdiff_t>(y) + dy;
            if (px < 0 || py < 0 || px >= static_cast<std::ptrdiff_t>(width) ||
                py >= static_cast<std::ptrdiff_t>(height))
                continue;
            if (evaluated[static_cast<std::size_t>(py) * width + static_cast<std::size_t>(px)] ==
                    0 &&
                std::hypot(static_cast<double>(dx), static_cast<double>(dy)) <= reach)
                return true;
        }
    }
    return false;
}

DiffuseResult empty_result(std::size_t width, std::size_t height, const DiffuseOptions& options) {
    DiffuseResult result;
    const std::size_t n = width * height;
    result.width = width;
    result.height = height;
    for (auto* plane : {&result.w, &result.sigma_w, &result.h, &result.sigma_h, &result.sigma_ji,
                        &result.sigma_ha, &result.chi2})
        plane->assign(n, 0.0F);
    result.ji_ln_mu_deg.assign(n, static_cast<float>(stored_lobe(options.ji)[0]));
    result.ha_ln_mu_deg.assign(n, static_cast<float>(stored_lobe(options.ha)[0]));
    result.mask.assign(n, mask_unseen);
    return result;
}

}  // namespace

std::vector<std::uint8_t> evaluated_pixels(const SurfaceView& view) {
    std::vector<std::uint8_t> out = view.seen;
    for (std::size_t i = 0; i < view.part.size(); ++i)
        if (view.part[i] != Part::ji && view.part[i] != Part::ha) out[i] = 0;
    return out;
}

std::size_t DiffuseResult::seen() const {
    return static_cast<std::size_t>(std::count_if(
        mask.begin(), mask.end(), [](std::uint8_t m) { return (m & mask_unseen) == 0; }));
}

std::size_t DiffuseResult::masked(std::uint8_t bits) const {
    return static_cast<std::size_t>(std::count_if(mask.begin(), mask.end(), [&](std::uint8_t m) {
        return (m & mask_unseen) == 0 && (m & bits) != 0;
    }));
}

DiffuseResult solve_diffuse(const SurfaceView& view,
                            const std::vector<DiffusePhotograph>& photographs,
                            const DiffuseOptions& options, const DiffuseProgress& progress) {
    check(view, photographs, options);
    const auto width = static_cast<std::size_t>(view.camera.width_px),
               height = static_cast<std::size_t>(view.camera.height_px);
    DiffuseResult result = empty_result(width, height, options);
    const bool fit_mu = photographs.size() > 1;
    const double spread = fit_mu ? options.spread : options.known_spread;
    result.mu_measured = fit_mu;
    const CurveMaker maker(view, photographs, options);
    const std::vector<std::uint8_t> evaluated = evaluated_pixels(view);
    std::atomic<std::size_t> rows_done{0};
    std::atomic<bool> cancelled{false};
    std::mutex telling;
    parallel_for(
        height, 1,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end && !cancelled; ++y) {
                for (std::size_t x = 0; x < width; ++x) {
                    const std::size_t i = y * width + x;
                    if (evaluated[i] == 0) continue;
                    std::uint8_t mask =
                        near_border(evaluated, width, height, x, y, options.border_px) ? mask_border
                                                                                       : 0;
                    std::vector<Reading> readings;
                    readings.reserve(photographs.size());
                    for (const DiffusePhotograph& p : photographs) {
                        const double model =
                            options.model_error * std::max(1.0, std::abs(double(p.radiance[i])));
                        readings.push_back({p.radiance[i], std::hypot(double(p.sigma[i]), model)});
                        if (p.clipped[i] != 0) mask |= mask_clipped;
                        if (!std::isfinite(p.radiance[i]) || !(p.sigma[i] > 0) ||
                            !std::isfinite(p.sigma[i]))
                            mask |= mask_not_finite;
                    }
                    if ((mask & mask_not_finite) != 0) {
                        result.mask[i] = mask;
                        result.sigma_w[i] = 1;
                        continue;
                    }
                    const std::vector<Curves> curves = maker.at(i);
                    const Pixel pixel(curves, readings, spread, options.hadori.has_value());
                    const Answer answer = solve_pixel(pixel, fit_mu);
                    if (answer.sigma[at_w] > options.max_sigma_w) mask |= mask_flat_w;
                    if (pixel.hadori()) {
                        result.h[i] = static_cast<float>(answer.x[at_h]);
                        result.sigma_h[i] = static_cast<float>(answer.sigma[at_h]);
                        if ((1 - answer.x[at_w]) * answer.sigma[at_h] > options.max_sigma_w)
                            mask |= mask_flat_w;
                    }
                    // Maps hold no lobe of the hadori.
                    if (!fit_mu || answer.sigma_lead > options.max_sigma_ln_mu ||
                        leading_lobe(answer.x) == at_hadori)
                        mask |= mask_flat_mu;
                    if (answer.ambiguous) mask |= mask_ambiguous;
                    if (answer.chi2 > options.max_misfit * static_cast<double>(readings.size()))
                        mask |= mask_misfit;
                    result.mask[i] = mask;
                    result.w[i] = static_cast<float>(answer.x[at_w]);
                    result.sigma_w[i] = static_cast<float>(answer.sigma[at_w]);
                    result.ji_ln_mu_deg[i] += fit_mu ? static_cast<float>(answer.x[at_ji]) : 0.0F;
                    result.ha_ln_mu_deg[i] += fit_mu ? static_cast<float>(answer.x[at_ha]) : 0.0F;
                    result.sigma_ji[i] = static_cast<float>(answer.sigma[at_ji]);
                    result.sigma_ha[i] = static_cast<float>(answer.sigma[at_ha]);
                    result.chi2[i] = static_cast<float>(answer.chi2);
                }
                const std::size_t done = ++rows_done;
                if (progress) {
                    const std::scoped_lock lock(telling);
                    if (!progress(static_cast<double>(done) / static_cast<double>(height)))
                        cancelled = true;
                }
            }
        },
        options.threads);
    if (cancelled) throw DiffuseCancelled{};
    const std::size_t seen = result.seen();
    if (seen == 0)
        throw InputError("diffuse", "surface", "not in the picture", "a surface that is seen");
    if (result.masked(mask_flat_w) == seen && (result.masked(mask_flat_mu) == seen)) {
        throw InputError("diffuse", "sources", "tell neither w nor mu at any pixel",
                         "sources that leave some directions dark (under an even hemisphere every "
                         "polish has the same radiance), and less noise");
    }
    return result;
}

double reference_gain(const SurfaceView& view, const DiffusePhotograph& photograph,
                      const std::vector<ReferenceArea>& references, const DiffuseOptions& options) {
    check(view, {photograph}, options);
    const auto width = static_cast<std::size_t>(view.camera.width_px);
    check_areas(references, width, static_cast<std::size_t>(view.camera.height_px));
    if (references.empty())
        throw InputError("diffuse", "reference", "none", "an area whose lobe is known");
    const LuminousFresnel fresnel(options.metal, options.light);
    double modelled = 0, measured = 0;
    for (const ReferenceArea& area : references) {
        auto lobe = stored_lobe(area.ha ? options.ha : options.ji);
        if (area.mu_deg > 0) lobe[0] = std::log(area.mu_deg);
        // The response is smooth: some hundred pixels of an area are as good as all.
        const int step = std::max(
            1, static_cast<int>(std::sqrt(static_cast<double>(area.width) * area.height / 128)));
        for (int y = area.y; y < area.y + area.height; y += step) {
            for (int x = area.x; x < area.x + area.width; x += step) {
                const std::size_t i =
                    static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
                if (view.seen[i] == 0 || photograph.clipped[i] != 0 ||
                    !std::isfinite(photograph.radiance[i]))
                    continue;
                const glm::dvec3 point = view.position_mm[i];
                const SurfacePose pose{point, glm::normalize(glm::dvec3(view.normal[i])),
                                       glm::dvec3(view.tangent[i]), view.camera.view(point)};
                const DiffuseResponse response(photograph.source, pose, fresnel,
                                               {options.ji.weight, options.ha.weight}, 1.1);
                const double m = area.ha ? response.ha(lobe) : response.ji(lobe);
                modelled += m * m;
                measured += m * photograph.radiance[i];
            }
        }
    }
    if (!(measured > 0)) {
        throw InputError("diffuse", "reference", "dark, clipped or outside the surface",
                         "areas that show the source");
    }
    return modelled / measured;
}

DiffuseResult solve_by_references(std::size_t width, std::size_t height,
                                  const std::vector<DiffusePhotograph>& photographs,
                                  const std::vector<ReferenceArea>& references,
                                  const DiffuseOptions& options) {
    if (photographs.empty()) throw InputError("diffuse", "photographs", "none", "one or more");
    const std::size_t n = width * height;
    for (const DiffusePhotograph& p : photographs) {
        if (p.radiance.size() != n || p.sigma.size() != n || p.clipped.size() != n)
            throw InputError("diffuse", "photograph", std::to_string(p.radiance.size()) + " pixels",
                             std::to_string(n));
    }
    check_areas(references, width, height);
    struct Level {
        double mean = 0, sigma = 0, count = 0;
    };
    std::vector<std::array<Level, 2>> levels(photographs.size());
    for (std::size_t p = 0; p < photographs.size(); ++p) {
        for (const ReferenceArea& area : references) {
            Level& level = levels[p][area.ha ? 1 : 0];
            for (int y = area.y; y < area.y + area.height; ++y) {
                for (int x = area.x; x < area.x + area.width; ++x) {
                    const std::size_t i =
                        static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
                    if (photographs[p].clipped[i] != 0 ||
                        !std::isfinite(photographs[p].radiance[i]))
                        continue;
                    level.mean += photographs[p].radiance[i];
                    level.sigma += photographs[p].sigma[i];
                    level.count += 1;
                }
            }
        }
        for (const int kind : {0, 1}) {
            Level& level = levels[p][static_cast<std::size_t>(kind)];
            if (level.count == 0) {
                throw InputError("diffuse", "reference",
                                 kind == 0 ? "no area of ji" : "no area of hamon",
                                 "without the sources' geometry, one area that is all ji and one "
                                 "that is all hamon, not clipped");
            }
            level.mean /= level.count;
            level.sigma /= level.count;
        }
        const double apart = std::abs(levels[p][1].mean - levels[p][0].mean);
        if (!(apart > 5 * std::max(levels[p][0].sigma, levels[p][1].sigma))) {
            throw InputError("diffuse", "reference",
                             "areas that look alike (" + std::to_string(levels[p][0].mean) + ", " +
                                 std::to_string(levels[p][1].mean) + ")",
                             "radiances more than 5 standard deviations apart");
        }
    }
    DiffuseResult result = empty_result(width, height, options);
    for (std::size_t i = 0; i < n; ++i) {
        std::uint8_t mask = mask_flat_mu;
        double top = 0, bottom = 0;
        for (std::size_t p = 0; p < photographs.size(); ++p) {
            const DiffusePhotograph& photograph = photographs[p];
            if (photograph.clipped[i] != 0) mask |= mask_clipped;
            const double d = levels[p][1].mean - levels[p][0].mean;
            const double sigma = photograph.sigma[i];
            if (!std::isfinite(photograph.radiance[i]) || !(sigma > 0) || !std::isfinite(sigma)) {
                mask |= mask_not_finite;
                continue;
            }
            top += d * (photograph.radiance[i] - levels[p][0].mean) / (sigma * sigma);
            bottom += d * d / (sigma * sigma);
        }
        if ((mask & mask_not_finite) == 0) {
            const double w = top / bottom, sigma = 1 / std::sqrt(bottom);
            result.w[i] = static_cast<float>(std::clamp(w, 0.0, 1.0));
            result.sigma_w[i] = static_cast<float>(sigma);
            if (sigma > options.max_sigma_w) mask |= mask_flat_w;
            // Far outside the line between the areas: another part, another geometry.
            const double beyond = std::max({w - 1, -w, 0.0});
            result.chi2[i] = static_cast<float>(beyond * beyond / (sigma * sigma));
            if (beyond > 0.25 + 3 * sigma) mask |= mask_misfit;
        }
        result.mask[i] = mask;
    }
    result.calibration =
        "two reference areas; the source's geometry is unknown, so w holds for surfaces that lie "
        "as they do";
    return result;
}

double PictureNoise::sigma(double value) const {
    return std::sqrt(gain * std::max(value, 0.0) + read * read + quantum * quantum / 12);
}

PictureNoise estimate_noise(const std::vector<float>& picture, std::size_t width,
                            std::size_t height) {
    // Differences of four neighbours, in which slopes cancel; by level, the median of their size.
    struct Level {
        std::vector<double> differences;
        double sum = 0;
    };
    constexpr std::size_t levels = 16;
    std::array<Level, levels> level;
    float top = 0;
    for (const float v : picture)
        if (std::isfinite(v)) top = std::max(top, v);
    if (!(top > 0)) return {};
    for (std::size_t y = 0; y + 1 < height; ++y) {
        for (std::size_t x = 0; x + 1 < width; ++x) {
            const std::size_t i = y * width + x;
            const double a = picture[i], b = picture[i + 1], c = picture[i + width],
                         d = picture[i + width + 1];
            const double mean = 0.25 * (a + b + c + d), difference = 0.5 * (a - b - c + d);
            if (!std::isfinite(mean)) continue;
            const auto k =
                static_cast<std::size_t>(std::clamp(mean / double(top), 0.0, 0.999) * levels);
            level[k].differences.push_back(std::abs(difference));
            level[k].sum += mean;
        }
    }
    // Variance against level, a straight line through the levels that have enough pixels.
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (Level& one : level) {
        if (one.differences.size() < 64) continue;
        const double sigma = median(one.differences) / 0.6745;
        const double x = one.sum / static_cast<double>(one.differences.size());
        const double weight = std::sqrt(static_cast<double>(one.differences.size()));
        n += weight;
        sx += weight * x;
        sy += weight * sigma * sigma;
        sxx += weight * x * x;
        sxy += weight * x * sigma * sigma;
    }
    PictureNoise noise;
    if (n == 0) {
        noise.read = 0.01 * top;
        return noise;
    }
    const double det = n * sxx - sx * sx;
    noise.gain = det > 1e-12 * n * sxx ? std::max((n * sxy - sx * sy) / det, 0.0) : 0;
    noise.read = std::sqrt(std::max((sy - noise.gain * sx) / n, 1e-12 * top * top));
    return noise;
}

PropertyMaps diffuse_maps(const DiffuseResult& result, const DiffuseOptions& options) {
    PropertyMaps maps;
    maps.width = result.width;
    maps.height = result.height;
    const auto ji = stored_lobe(options.ji), ha = stored_lobe(options.ha);
    maps[MapChannel::ji_e1] = {static_cast<float>(ji[1])};
    maps[MapChannel::ji_e2] = {static_cast<float>(ji[2])};
    maps[MapChannel::ha_e1] = {static_cast<float>(ha[1])};
    maps[MapChannel::ha_e2] = {static_cast<float>(ha[2])};
    const auto plane = [&](const std::vector<float>& from) {
        std::vector<float> to(from.size());
        for (std::size_t row = 0; row < result.height; ++row) {
            std::copy_n(
                from.begin() + static_cast<std::ptrdiff_t>(row * result.width), result.width,
                to.begin() + static_cast<std::ptrdiff_t>((result.height - 1 - row) * result.width));
        }
        return to;
    };
    maps[MapChannel::ji_ln_mu_deg] = plane(result.ji_ln_mu_deg);
    maps[MapChannel::ha_ln_mu_deg] = plane(result.ha_ln_mu_deg);
    maps[MapChannel::w] = plane(result.w);
    maps[MapChannel::h] = options.hadori ? plane(result.h) : std::vector<float>{0.0F};
    std::vector<float> part(result.w.size());
    for (std::size_t i = 0; i < part.size(); ++i) {
        part[i] = (result.mask[i] & mask_unseen) != 0 ? float(TG_PART_OTHER)
                  : result.w[i] > 0.5F                ? float(TG_PART_HA)
                                                      : float(TG_PART_JI);
    }
    maps[MapChannel::part] = plane(part);
    return maps;
}

}  // namespace togishi
