#include "capture/diffuse_response.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/fresnel_table.hpp"
#include "bake/lobe_lanes.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int first_lines = 40;
constexpr int most_divisions = 4;
constexpr std::size_t bins = 26;
/// Half widths by which lines are compared, in degrees.
constexpr std::array<double, 4> probe_deg{0.5, 1.5, 4, 10};
constexpr double line_tolerance = 0.004;  ///< share of a full lobe

struct Segment {
    double from, to;
    double smooth_f, smooth_t;
};

struct Polar {
    double azimuth = 0;
    std::vector<Segment> segments;
    std::array<double, probe_deg.size()> seen{};  ///< share of a full lobe along this line
};

class Tracer {
  public:
    Tracer(const DiffuseSource& source, const SurfacePose& pose, const LuminousFresnel& fresnel,
           const LobeWeights& weights, double max_phi)
        : source_(source), pose_(pose), fresnel_(fresnel), weights_(weights) {
        frame_ = f64::tangent_frame(pose.normal, pose.tangent);
        for (std::size_t k = 0; k <= bins; ++k)
            edges_[k] = max_phi * std::pow(static_cast<double>(k) / bins, 1.5);
    }

    [[nodiscard]] Polar line(double azimuth) const {
        Polar polar;
        polar.azimuth = azimuth;
        const double c = std::cos(azimuth), s = std::sin(azimuth);
        const glm::dvec3 outwards = c * frame_.tangent + s * frame_.bitangent;
        double before = edges_[0], inside_before = inside(outwards, before);
        for (std::size_t k = 1; k <= bins; ++k) {
            // The middle too, so that a source narrower than a bin is not stepped over.
            for (const double to : {0.5 * (edges_[k - 1] + edges_[k]), edges_[k]}) {
                const double inside_to = inside(outwards, to);
                double from = before, end = to;
                if ((inside_before > 0) != (inside_to > 0)) {
                    const double crossing = find_crossing(outwards, before, to, inside_before > 0);
                    (inside_before > 0 ? end : from) = crossing;
                }
                if (inside_before > 0 || inside_to > 0) add(polar, outwards, from, end);
                before = to;
                inside_before = inside_to;
            }
        }
        for (const Segment& segment : polar.segments) {
            for (std::size_t p = 0; p < probe_deg.size(); ++p) {
                const double mu = probe_deg[p] * double(TG_RAD_PER_DEG);
                const double a = double(TG_LN2) / (mu * mu);
                polar.seen[p] += std::exp(-a * segment.from * segment.from) -
                                 std::exp(-a * segment.to * segment.to);
            }
        }
        return polar;
    }

    void trace(std::vector<Polar>& lines) const {
        lines.reserve(2 * first_lines);
        Polar first = line(0);
        Polar left = first;
        for (int k = 1; k <= first_lines; ++k) {
            Polar right;
            if (k == first_lines) {
                right = first;
                right.azimuth = 2 * pi;
            } else {
                right = line(2 * pi * k / first_lines);
            }
            lines.push_back(left);
            divide(lines, left, right, 0);
            left = std::move(right);
        }
    }

  private:
    [[nodiscard]] glm::dvec3 light_at(const glm::dvec3& outwards, double phi) const {
        const glm::dvec3 h = std::cos(phi) * frame_.normal + std::sin(phi) * outwards;
        return 2 * glm::dot(h, pose_.view) * h - pose_.view;
    }
    [[nodiscard]] double inside(const glm::dvec3& outwards, double phi) const {
        const glm::dvec3 light = light_at(outwards, phi);
        if (!(glm::dot(light, frame_.normal) > double(TG_MIN_COS))) return -1;
        return source_.inside(pose_.point_mm, light);
    }
    [[nodiscard]] double find_crossing(const glm::dvec3& outwards, double a, double b,
                                       bool a_inside) const {
        for (int step = 0; step < 22; ++step) {
            const double middle = 0.5 * (a + b);
            ((inside(outwards, middle) > 0) == a_inside ? a : b) = middle;
        }
        return 0.5 * (a + b);
    }
    void add(Polar& polar, const glm::dvec3& outwards, double from, double to) const {
        if (!(to > from)) return;
        const double phi = 0.5 * (from + to);
        const glm::dvec3 h = std::cos(phi) * frame_.normal + std::sin(phi) * outwards;
        const glm::dvec3 light = light_at(outwards, phi);
        auto g =
            f64::light_geometry(frame_.normal, frame_.tangent, frame_.bitangent, pose_.view, light);
        if (g.lit == 0) return;
        // D = 1: the Gaussian is integrated apart.
        g.facet = {0, 0};
        const f64::LobeForm unit{1, 0, 1, 1};
        // dω of L is 4 (V.H) that of H, and that is sin(phi) dphi dazimuth.
        const double area = 4 * glm::dot(h, pose_.view) * (phi > 0 ? std::sin(phi) / phi : 1);
        polar.segments.push_back(
            {from, to, area * fresnel_.at(g.cos_i) * f64::ji_reflection(unit, g, weights_.chi),
             area * fresnel_.at(g.cos_h) * f64::hamon_reflection(unit, g, weights_.beta)});
    }
    void divide(std::vector<Polar>& lines, const Polar& left, const Polar& right, int depth) const {
        if (depth == most_divisions) return;
        double difference = 0;
        for (std::size_t p = 0; p < probe_deg.size(); ++p)
            difference = std::max(difference, std::abs(left.seen[p] - right.seen[p]));
        if (difference * (right.azimuth - left.azimuth) < line_tolerance * 2 * pi) return;
        const Polar middle = line(0.5 * (left.azimuth + right.azimuth));
        divide(lines, left, middle, depth + 1);
        lines.push_back(middle);
        divide(lines, middle, right, depth + 1);
    }

    const DiffuseSource& source_;
    const SurfacePose& pose_;
    const LuminousFresnel& fresnel_;
    LobeWeights weights_;
    f64::TangentFrame frame_;
    std::array<double, bins + 1> edges_{};
};

}  // namespace

std::array<double, 3> stored_lobe(const MaterialLobe& lobe) {
    const double deg = double(TG_RAD_PER_DEG);
    const f64::Lobe stored =
        f64::lobe_from_mu(lobe.mu_t_deg * deg, lobe.mu_b_deg * deg, lobe.rho_deg * deg);
    return {stored.ln_mu_deg, stored.e1, stored.e2};
}

LuminousFresnel::LuminousFresnel(const std::string& metal, const std::string& light) {
    FresnelTableRequest request;
    request.metal = metal;
    request.light = light;
    request.size = 256;
    const std::vector<float> rgb = fresnel_table(request);
    table_.resize(request.size);
    for (std::size_t i = 0; i < request.size; ++i) {
        // Luminance of linear Rec.709, ITU-R BT.709.
        table_[i] = 0.2126390059 * rgb[3 * i] + 0.7151686788 * rgb[3 * i + 1] +
                    0.0721923154 * rgb[3 * i + 2];
    }
}

double LuminousFresnel::at(double cosine) const {
    const double x =
        std::sqrt(std::clamp(cosine, 0.0, 1.0)) * static_cast<double>(table_.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(x), table_.size() - 2);
    const double f = x - static_cast<double>(i);
    return table_[i] + f * (table_[i + 1] - table_[i]);
}

DiffuseResponse::DiffuseResponse(const DiffuseSource& source, const SurfacePose& pose,
                                 const LuminousFresnel& fresnel, const LobeWeights& weights,
                                 double max_phi_rad)
    : normalised_f_(weights.chi < 0), normalised_t_(weights.beta < 0) {
    std::vector<Polar> polars;
    Tracer(source, pose, fresnel, weights, max_phi_rad).trace(polars);
    lines_.reserve(polars.size());
    for (std::size_t j = 0; j < polars.size(); ++j) {
        const double before =
            j > 0 ? polars[j - 1].azimuth : polars[polars.size() - 1].azimuth - 2 * pi;
        const double after = j + 1 < polars.size() ? polars[j + 1].azimuth : 2 * pi;
        lines_.push_back({std::cos(polars[j].azimuth), std::sin(polars[j].azimuth),
                          0.5 * (after - before), from2_.size(), polars[j].segments.size()});
        for (const Segment& segment : polars[j].segments) {
            from2_.push_back(static_cast<float>(segment.from * segment.from));
            to2_.push_back(static_cast<float>(segment.to * segment.to));
            smooth_f_.push_back(static_cast<float>(segment.smooth_f));
            smooth_t_.push_back(static_cast<float>(segment.smooth_t));
        }
    }
}

double DiffuseResponse::sum(const std::array<double, 3>& stored, const std::vector<float>& smooth,
                            bool normalised) const {
    const f64::LobeForm form = f64::lobe_form({stored[0], stored[1], stored[2]});
    double total = 0;
    for (const Line& line : lines_) {
        const double a = form.xx * line.cosine * line.cosine +
                         2 * form.xy * line.cosine * line.sine + form.yy * line.sine * line.sine;
        const auto b = static_cast<float>(-a);
        float part = 0;
        for (std::size_t k = line.first; k < line.first + line.count; ++k) {
            const float near = lanes::exp(std::max(b * from2_[k], -80.0F)),
                        far = lanes::exp(std::max(b * to2_[k], -80.0F));
            part += smooth[k] * (near - far);
        }
        total += line.width * static_cast<double>(part) / (2 * a);
    }
    return normalised ? total * form.scale : total;
}

double DiffuseResponse::ji(const std::array<double, 3>& stored) const {
    return sum(stored, smooth_f_, normalised_f_);
}

double DiffuseResponse::ha(const std::array<double, 3>& stored) const {
    return sum(stored, smooth_t_, normalised_t_);
}

}  // namespace togishi
