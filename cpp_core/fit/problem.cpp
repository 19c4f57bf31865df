#include "fit/problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "brdf/model.hpp"
#include "fit/pose_dual.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;
// exp(-40) of a lobe is below any detector's floor.
constexpr double darkest_exponent = 40;

// Sums over the aperture of shares times D, and of the same times what its derivatives need.
struct LobeSums {
    double s = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

struct LobeAt {
    f64::LobeForm form;
    pose::LobeForm by_lobe;  // derivatives by ln_mu_deg, e1, e2 (sample's axes)
};

LobeAt lobe_at(double ln_mu_deg, double e1, double e2) {
    // A circle has no direction in which its axis would turn: the derivatives are those beside it.
    constexpr double circle = 1e-9;
    if (std::hypot(e1, e2) < circle) e1 = circle;
    pose::Lobe lobe;
    lobe.ln_mu_deg = pose::Dual::variable(ln_mu_deg, 0);
    lobe.e1 = pose::Dual::variable(e1, 1);
    lobe.e2 = pose::Dual::variable(e2, 2);
    LobeAt at;
    at.by_lobe = pose::lobe_form(lobe);
    at.form = {at.by_lobe.xx.v, at.by_lobe.xy.v, at.by_lobe.yy.v, at.by_lobe.scale.v};
    return at;
}

LobeSums lobe_sums(const f64::LobeForm& form, const pose::Facet& facet,
                   const std::vector<ApertureNode>& nodes, double reach) {
    LobeSums sums;
    const f64::Facet centre{facet.dx.v, facet.dy.v};
    const double exponent = form.xx * centre.dx * centre.dx + 2 * form.xy * centre.dx * centre.dy +
                            form.yy * centre.dy * centre.dy;
    const double far = std::sqrt(std::max(exponent, 0.0)) - reach;
    if (far > 0 && far * far > darkest_exponent) return sums;
    // The detector's own displacements are the pose's last two parameters.
    const double ax = facet.dx.d[2], ay = facet.dy.d[2], bx = facet.dx.d[3], by = facet.dy.d[3];
    for (const ApertureNode& node : nodes) {
        const f64::Facet at{centre.dx + ax * node.along + bx * node.across,
                            centre.dy + ay * node.along + by * node.across};
        const double v = node.share * f64::lobe_value(form, at);
        sums.s += v;
        sums.x += v * at.dx;
        sums.y += v * at.dy;
        sums.xx += v * at.dx * at.dx;
        sums.xy += v * at.dx * at.dy;
        sums.yy += v * at.dy * at.dy;
    }
    return sums;
}

// Derivative of the average by a parameter of the form.
double by_form(const LobeSums& sums, const pose::LobeForm& form, std::size_t k) {
    return -(form.xx.d[k] * sums.xx + 2 * form.xy.d[k] * sums.xy + form.yy.d[k] * sums.yy);
}

// And by a shift of the facet.
double by_facet(const LobeSums& sums, const f64::LobeForm& form, const pose::Facet& facet,
                std::size_t k) {
    return -2 * ((form.xx * sums.x + form.xy * sums.y) * facet.dx.d[k] +
                 (form.xy * sums.x + form.yy * sums.y) * facet.dy.d[k]);
}

}  // namespace

bool FitActive::has(int index) const {
    return std::binary_search(shared.begin(), shared.end(), index);
}

FitProblem::FitProblem(const ScanSet& scans, bool use_aperture, std::size_t stride)
    : part_(scans.part),
      scan_count_(scans.scans.size()),
      channels_(scans.channels.size()),
      use_aperture_(use_aperture) {
    peaks_.assign(channels_, 0.0);
    for (std::size_t s = 0; s < scan_count_; ++s) {
        const Scan& scan = scans.scans[s];
        setups_.push_back({scan.incidence_deg * rad_per_deg, scan.turn_deg * rad_per_deg,
                           scan.quantity, scan.source_aperture_deg, scan.detector_aperture_deg, 0});
        for (std::size_t i = 0; i < scan.rows.size(); i += stride) {
            rows_.push_back({s, scan.rows[i].receive_deg * rad_per_deg,
                             scan.rows[i].azimuth_deg * rad_per_deg});
            for (std::size_t c = 0; c < channels_; ++c) {
                const double value = scan.intensity[i * channels_ + c];
                measured_.push_back(value);
                const bool gap = !std::isfinite(value);
                const bool clipped = !gap && value >= scan.saturation;
                at_saturation_.push_back(clipped ? 1 : 0);
                state.push_back(gap       ? ReadingState::gap
                                : clipped ? ReadingState::clipped
                                          : ReadingState::used);
                sigma.push_back(scan.sigma.empty() ? 0 : scan.sigma[i * channels_ + c]);
                if (!gap) peaks_[c] = std::max(peaks_[c], std::abs(value));
            }
        }
    }
    const double largest = *std::max_element(peaks_.begin(), peaks_.end());
    scale_ = largest > 0 ? largest : 1;
    for (double& v : measured_) v /= scale_;
    for (double& v : sigma) v /= scale_;
    for (double& v : peaks_) v /= scale_;
    scan_used.assign(scan_count_, 1);
    axis_ = -setups_.front().turn_rad;
    priors.shared = Eigen::VectorXd::Constant(index_pedestal + static_cast<Eigen::Index>(channels_),
                                              std::numeric_limits<double>::infinity());
    set_aperture_rings(1);
}

void FitProblem::make_nodes() {
    node_sets_.clear();
    std::map<std::pair<double, double>, std::size_t> known;
    for (Setup& setup : setups_) {
        const std::pair key(use_aperture_ ? setup.source_deg : 0.0,
                            use_aperture_ ? setup.detector_deg : 0.0);
        const auto [found, fresh] = known.try_emplace(key, node_sets_.size());
        if (fresh) node_sets_.push_back(aperture_nodes(key.first, key.second, rings_));
        setup.nodes = found->second;
    }
}

void FitProblem::set_aperture_rings(int rings) {
    if (rings == rings_) return;
    rings_ = rings;
    make_nodes();
}

void FitProblem::set_aperture_for(const FitParameters& p) {
    double reach = 0;
    const double r = std::hypot(p.shared[index_e_along], p.shared[index_e_across]);
    const double mu_b = std::exp(p.shared[index_ln_mu_deg] - r) * rad_per_deg;
    for (const Setup& setup : setups_) {
        const double radius = 0.5 * (setup.source_deg + setup.detector_deg) * rad_per_deg;
        // Across the plane the half vector moves 1/cos(theta_H) as far; theta_H is the incidence at
        // the peak.
        reach = std::max(reach, 0.5 * radius / std::max(std::cos(setup.incidence_rad), 0.1) / mu_b);
    }
    set_aperture_rings(use_aperture_ ? aperture_rings(reach) : 1);
}

FitParameters FitProblem::start() const {
    FitParameters p;
    p.shared = Eigen::VectorXd::Zero(index_pedestal + static_cast<Eigen::Index>(channels_));
    p.ln_gain = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(scan_count_));
    p.shared[index_ln_haze_share] = std::log(0.03);
    p.shared[index_ln_haze_width] = std::log(3.0);
    return p;
}

// Calls visit(row, channel, value, gradient) for every reading that is no gap; gradient (shared,
// then ln gain) is null where no derivatives are asked for.
template <class Visit>
void FitProblem::visit_rows(const FitParameters& p, const FitActive* active, Visit&& visit) const {
    ++evaluations;
    const bool derivatives = active != nullptr;
    const auto& x = p.shared;
    // Along and across turned into the sample's own axes.
    const double c1 = std::cos(axis_), s1 = std::sin(axis_);
    const double c2 = std::cos(2 * axis_), s2 = std::sin(2 * axis_);
    const double e1 = c2 * x[index_e_along] - s2 * x[index_e_across];
    const double e2 = s2 * x[index_e_along] + c2 * x[index_e_across];
    const LobeAt lobe = lobe_at(x[index_ln_mu_deg], e1, e2);
    LobeAt wide{};
    double share = 0;
    if (haze) {
        wide = lobe_at(x[index_ln_mu_deg] + x[index_ln_haze_width], e1, e2);
        share = std::exp(x[index_ln_haze_share]);
    }
    const double weight = std::exp(x[index_ln_weight]);
    const double tilt_t = c1 * x[index_tilt_along] - s1 * x[index_tilt_across];
    const double tilt_b = s1 * x[index_tilt_along] + c1 * x[index_tilt_across];
    // At the top of a lobe D is 1: what reflects around it.
    pose::LobeForm any;
    any.xx = any.yy = any.scale = 1.0;
    const auto all = static_cast<std::size_t>(x.size());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(x.size() + 1);

    std::size_t scan_now = scan_count_;
    pose::TangentFrame frame;
    pose::Vec3 light;
    double narrowest_reach = 0, gain = 1, constant = 1;
    const std::vector<ApertureNode>* nodes = nullptr;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const Row& row = rows_[i];
        if (scan_used[row.scan] == 0) continue;
        if (row.scan != scan_now || nodes == nullptr) {
            scan_now = row.scan;
            const Setup& setup = setups_[row.scan];
            const double ct = std::cos(setup.turn_rad), st = std::sin(setup.turn_rad);
            const pose::Vec3 t(ct, st, 0.0), b(-st, ct, 0.0);
            const pose::Vec3 n = pose::Vec3(0.0, 0.0, 1.0) +
                                 t * tan(pose::Dual::variable(tilt_t, 0)) +
                                 b * tan(pose::Dual::variable(tilt_b, 1));
            frame = pose::tangent_frame(n, t);
            light = {-std::sin(setup.incidence_rad), 0.0, std::cos(setup.incidence_rad)};
            nodes = &node_sets_[setup.nodes];
            double furthest = 0;
            for (const ApertureNode& node : *nodes)
                furthest = std::max(furthest, std::hypot(node.along, node.across));
            const double cos_least = std::max(0.1, 0.5 * std::cos(setup.incidence_rad));
            narrowest_reach = 0.5 * furthest / cos_least *
                              std::sqrt(lobe.form.xx + lobe.form.yy);  // at least the narrow axis'
            gain = std::exp(p.ln_gain[static_cast<Eigen::Index>(row.scan)]);
            constant = setup.quantity == ScanQuantity::brdf ? 1 / std::cos(setup.incidence_rad) : 1;
        }
        // The detector: the stated direction, turned by the receive offset, then led out of the
        // plane.
        const pose::Dual receive = pose::Dual::variable(row.receive_rad + x[index_receive], 2);
        const double ca = std::cos(row.azimuth_rad), sa = std::sin(row.azimuth_rad);
        const pose::Dual sr = sin(receive), cr = cos(receive);
        const pose::Vec3 stated(sr * ca, sr * sa, cr);
        // beside = (y - stated (stated.y)) / length
        const pose::Dual sy = stated.y;
        const pose::Dual inverse = 1.0 / sqrt(1.0 - sy * sy);
        const pose::Dual out = tan(pose::Dual::variable(x[index_out_of_plane], 3)) * inverse;
        pose::Vec3 view = stated * (1.0 - sy * out) + pose::Vec3(0.0, out, 0.0);
        view = view * (1.0 / sqrt(dot(view, view)));

        const pose::LightGeometry g =
            pose::light_geometry(frame.normal, frame.tangent, frame.bitangent, view, light);
        const bool hamon = part_ == ScanPart::hamon;
        pose::LightGeometry top = g;
        top.facet = {};
        pose::Dual around =
            hamon ? pose::hamon_reflection(any, top, 1.0) : pose::ji_reflection(any, top, 1.0);
        around = around * constant;
        if (setups_[row.scan].quantity == ScanQuantity::flux)
            around = around * dot(frame.normal, view);
        const pose::Dual& cosine = hamon ? g.cos_h : g.cos_i;

        const LobeSums narrow = lobe_sums(lobe.form, g.facet, *nodes, narrowest_reach);
        LobeSums broad;
        if (haze) broad = lobe_sums(wide.form, g.facet, *nodes, narrowest_reach);
        const double average = narrow.s + share * broad.s;
        double by_lobe[3] = {0, 0, 0}, by_pose[4] = {0, 0, 0, 0};
        if (derivatives) {
            for (std::size_t k = 0; k < 3; ++k) {
                by_lobe[k] = by_form(narrow, lobe.by_lobe, k);
                if (haze) by_lobe[k] += share * by_form(broad, wide.by_lobe, k);
            }
            for (std::size_t k = 0; k < 4; ++k) {
                by_pose[k] = by_facet(narrow, lobe.form, g.facet, k);
                if (haze) by_pose[k] += share * by_facet(broad, wide.form, g.facet, k);
            }
        }
        for (std::size_t c = 0; c < channels_; ++c) {
            if (state[i * channels_ + c] == ReadingState::gap) continue;
            const Reflectance f = reflectance->at(c, cosine.v);
            const double pedestal = x[index_pedestal + static_cast<int>(c)];
            const double height = gain * weight * f.value * around.v;
            const double value = height * average + gain * pedestal;
            if (!derivatives) {
                visit(i, c, value, nullptr);
                continue;
            }
            gradient.setZero();
            gradient[index_ln_weight] = height * average;
            gradient[index_ln_mu_deg] = height * by_lobe[0];
            gradient[index_e_along] = height * (c2 * by_lobe[1] + s2 * by_lobe[2]);
            gradient[index_e_across] = height * (c2 * by_lobe[2] - s2 * by_lobe[1]);
            double pose_gradient[4];
            for (std::size_t k = 0; k < 4; ++k) {
                pose_gradient[k] =
                    gain * weight * average *
                        (f.by_cosine * cosine.d[k] * around.v + f.value * around.d[k]) +
                    height * by_pose[k];
            }
            gradient[index_tilt_along] = c1 * pose_gradient[0] + s1 * pose_gradient[1];
            gradient[index_tilt_across] = c1 * pose_gradient[1] - s1 * pose_gradient[0];
            gradient[index_receive] = pose_gradient[2];
            gradient[index_out_of_plane] = pose_gradient[3];
            if (haze) {
                gradient[index_ln_haze_share] = height * share * broad.s;
                gradient[index_ln_haze_width] = height * share * by_form(broad, wide.by_lobe, 0);
            }
            gradient[index_pedestal + static_cast<int>(c)] = gain;
            gradient[static_cast<Eigen::Index>(all)] = value;
            visit(i, c, value, &gradient);
        }
    }
}

std::vector<double> FitProblem::modelled(const FitParameters& p) const {
    std::vector<double> values(measured_.size(), 0.0);
    visit_rows(p, nullptr, [&](std::size_t i, std::size_t c, double value, const Eigen::VectorXd*) {
        values[i * channels_ + c] = value;
    });
    return values;
}

namespace {

struct Residual {
    double r = 0;       // whitened
    double weight = 0;  // of its square in the normal equations
    double cost = 0;
};

Residual residual_of(ReadingState state, double measured, double value, double sigma,
                     double huber) {
    if (state == ReadingState::outlier) return {};
    // A clipped reading says only that there was at least so much.
    if (state == ReadingState::clipped && value >= measured) return {};
    const double r = (measured - value) / sigma;
    const double size = std::abs(r);
    if (size <= huber) return {r, 1, r * r};
    return {r, huber / size, huber * (2 * size - huber)};
}

}  // namespace

double FitProblem::cost(const FitParameters& p) const {
    double sum = 0;
    visit_rows(p, nullptr, [&](std::size_t i, std::size_t c, double value, const Eigen::VectorXd*) {
        const std::size_t at = i * channels_ + c;
        sum += residual_of(state[at], measured_[at], value, sigma[at], huber).cost;
    });
    for (Eigen::Index k = 0; k < p.shared.size(); ++k) {
        const double z = p.shared[k] / priors.shared[k];
        sum += z * z;
    }
    sum += p.ln_gain.squaredNorm() / (priors.ln_gain * priors.ln_gain);
    return sum;
}

NormalEquations FitProblem::linearised(const FitParameters& p, const FitActive& active) const {
    const auto n = static_cast<Eigen::Index>(active.shared.size());
    const auto scans = static_cast<Eigen::Index>(scan_count_);
    NormalEquations e;
    e.shared = Eigen::MatrixXd::Zero(n, n);
    e.mixed = Eigen::MatrixXd::Zero(n, active.gain ? scans : 0);
    e.gain = Eigen::VectorXd::Zero(active.gain ? scans : 0);
    e.shared_gradient = Eigen::VectorXd::Zero(n);
    e.gain_gradient = Eigen::VectorXd::Zero(active.gain ? scans : 0);
    std::vector<double> j(static_cast<std::size_t>(n));
    visit_rows(p, &active,
               [&](std::size_t i, std::size_t c, double value, const Eigen::VectorXd* gradient) {
                   const std::size_t at = i * channels_ + c;
                   const Residual res =
                       residual_of(state[at], measured_[at], value, sigma[at], huber);
                   e.cost += res.cost;
                   if (res.weight == 0) return;
                   const double scale = 1 / sigma[at];
                   for (Eigen::Index a = 0; a < n; ++a)
                       j[static_cast<std::size_t>(a)] =
                           (*gradient)[active.shared[static_cast<std::size_t>(a)]] * scale;
                   for (Eigen::Index a = 0; a < n; ++a) {
                       const double ja = res.weight * j[static_cast<std::size_t>(a)];
                       if (ja == 0) continue;
                       e.shared_gradient[a] += ja * res.r;
                       for (Eigen::Index b = a; b < n; ++b)
                           e.shared(b, a) += ja * j[static_cast<std::size_t>(b)];
                   }
                   if (!active.gain) return;
                   const auto s = static_cast<Eigen::Index>(rows_[i].scan);
                   const double jg = (*gradient)[gradient->size() - 1] * scale;
                   e.gain[s] += res.weight * jg * jg;
                   e.gain_gradient[s] += res.weight * jg * res.r;
                   for (Eigen::Index a = 0; a < n; ++a)
                       e.mixed(a, s) += res.weight * jg * j[static_cast<std::size_t>(a)];
               });
    e.shared.triangularView<Eigen::StrictlyUpper>() = e.shared.transpose();
    // Priors: residuals of their own.
    for (Eigen::Index a = 0; a < n; ++a) {
        const int k = active.shared[static_cast<std::size_t>(a)];
        const double w = 1 / (priors.shared[k] * priors.shared[k]);
        e.shared(a, a) += w;
        e.shared_gradient[a] -= w * p.shared[k];
    }
    for (Eigen::Index k = 0; k < p.shared.size(); ++k) {
        const double z = p.shared[k] / priors.shared[k];
        e.cost += z * z;
    }
    const double w = 1 / (priors.ln_gain * priors.ln_gain);
    e.cost += w * p.ln_gain.squaredNorm();
    if (active.gain) {
        e.gain.array() += w;
        e.gain_gradient -= w * p.ln_gain;
    }
    return e;
}

Eigen::VectorXd FitProblem::derivatives(const FitParameters& p, std::size_t row,
                                        std::size_t channel) const {
    Eigen::VectorXd found = Eigen::VectorXd::Zero(p.shared.size() + 1);
    const FitActive all;
    visit_rows(p, &all, [&](std::size_t i, std::size_t c, double, const Eigen::VectorXd* gradient) {
        if (i == row && c == channel) found = *gradient;
    });
    return found;
}

}  // namespace togishi
