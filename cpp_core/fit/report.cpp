#include "fit/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/error.hpp"
#include "fit/solver.hpp"
#include "fit/start.hpp"
#include "fit/unseen_tilt.hpp"
#include "scan/scan_channel.hpp"

#ifndef TOGISHI_VERSION
#define TOGISHI_VERSION "0"
#endif

namespace togishi {
namespace {

constexpr double deg_per_rad = 57.295779513082320877;
// Relative 1-sigma beyond which a constant counts as not determined.
constexpr double vague = 0.15;

std::string digits(double value, int significant) {
    std::array<char, 40> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*g", significant, value);
    return buffer.data();
}

double finite(double value, double otherwise) {
    return std::isfinite(value) ? value : otherwise;
}

// Values for people, each with its derivatives by the active parameters.
class Table {
  public:
    explicit Table(const FitActive& active) : active_(active) {}

    // An empty gradient: the parameter was not fitted.
    void add(FitParameter parameter, const std::vector<std::pair<int, double>>& gradient) {
        Eigen::RowVectorXd row =
            Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(active_.shared.size()));
        for (const auto& [index, slope] : gradient) {
            const auto at = std::find(active_.shared.begin(), active_.shared.end(), index);
            if (at != active_.shared.end()) row[at - active_.shared.begin()] += slope;
        }
        parameters.push_back(std::move(parameter));
        rows_.push_back(std::move(row));
        unseen_.push_back(0);
    }
    // Of what no reading tells, beside what the covariance holds.
    void widen(std::string_view name, double sigma) {
        for (std::size_t i = 0; i < parameters.size(); ++i) {
            if (parameters[i].name == name) unseen_[i] = sigma;
        }
    }
    // Sigmas and correlations.
    [[nodiscard]] std::vector<std::vector<double>> correlate(const Eigen::MatrixXd& covariance) {
        const std::size_t n = parameters.size();
        std::vector<std::vector<double>> correlations(n, std::vector<double>(n, 0.0));
        std::vector<double> sigma(n);
        for (std::size_t i = 0; i < n; ++i) {
            sigma[i] = std::hypot(
                std::sqrt(std::max((rows_[i] * covariance * rows_[i].transpose())(0, 0), 0.0)),
                unseen_[i]);
            constexpr double as_good_as_unknown = 1e12;
            parameters[i].sigma =
                std::min(finite(sigma[i], as_good_as_unknown), as_good_as_unknown);
        }
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j) {
                const double both = sigma[i] * sigma[j];
                const double c =
                    both > 0 ? (rows_[i] * covariance * rows_[j].transpose())(0, 0) / both : 0;
                correlations[i][j] = i == j ? 1 : std::clamp(finite(c, 0), -1.0, 1.0);
            }
        }
        return correlations;
    }
    std::vector<FitParameter> parameters;

  private:
    const FitActive& active_;
    std::vector<Eigen::RowVectorXd> rows_;
    std::vector<double> unseen_;
};

class Report {
  public:
    Report(Fit& fit, FitProblem& problem, const Solution& solution, const FitOptions& options)
        : fit_(fit), problem_(problem), solution_(solution), options_(options) {}

    void constants(bool stated_sigma) {
        const Eigen::VectorXd& x = solution_.parameters.shared;
        Covariance c = covariance(problem_, solution_.parameters, solution_.active);
        FitRecord& record = fit_.record;
        // Stated sigmas that are too small for the misfit are raised by it, as is the custom.
        const double inflate = stated_sigma ? std::max(1.0, record.chi2_reduced) : 1.0;
        c.shared *= inflate;
        c.gain *= inflate;
        Table table(solution_.active);
        add_weight(table, x, c);
        add_lobe(table, x);
        add_pedestals(table, x);
        add_haze(table, x);
        add_pose(table, x);
        record.correlations = table.correlate(c.shared);
        record.parameters = std::move(table.parameters);
        judge();
        for (std::size_t s = 0; s < fit_.fitted.size(); ++s) {
            const auto at = static_cast<Eigen::Index>(s);
            fit_.fitted[s].gain = std::exp(solution_.parameters.ln_gain[at]);
            fit_.fitted[s].gain_sigma =
                c.gain.size() > 0
                    ? finite(fit_.fitted[s].gain * std::sqrt(std::max(c.gain[at], 0.0)), 0)
                    : 0;
        }
    }

    // What every reading became, scan by scan.
    void readings() {
        const std::vector<double> modelled = problem_.modelled(solution_.parameters);
        const std::size_t channels = problem_.channels();
        fit_.fitted.assign(fit_.scans.scans.size(), {});
        double chi2 = 0;
        std::size_t used = 0, outliers = 0, clipped = 0, at = 0;
        for (std::size_t s = 0; s < fit_.fitted.size(); ++s) {
            FittedScan& out = fit_.fitted[s];
            const std::size_t n = fit_.scans.scans[s].rows.size() * channels;
            double own = 0;
            std::size_t own_used = 0;
            for (std::size_t i = 0; i < n; ++i, ++at) {
                const ReadingState state = solution_.state[at];
                const double z =
                    state == ReadingState::gap
                        ? 0
                        : finite((problem_.measured()[at] - modelled[at]) / solution_.sigma[at], 0);
                out.modelled.push_back(modelled[at] * problem_.scale());
                out.residual_sigma.push_back(z);
                out.state.push_back(state);
                outliers += state == ReadingState::outlier ? 1 : 0;
                clipped += state == ReadingState::clipped ? 1 : 0;
                if (state != ReadingState::used) continue;
                own += z * z;
                ++own_used;
            }
            out.residual_rms_sigma =
                own_used > 0 ? std::sqrt(own / static_cast<double>(own_used)) : 0;
            chi2 += own;
            used += own_used;
        }
        const std::size_t parameters = solution_.active.shared.size();
        FitRecord& record = fit_.record;
        record.readings = static_cast<std::int64_t>(used);
        record.outliers = static_cast<std::int64_t>(outliers);
        record.clipped = static_cast<std::int64_t>(clipped);
        record.chi2_reduced =
            used > parameters ? finite(chi2 / static_cast<double>(used - parameters), 0) : 0;
    }

    // The half width that each scan by itself would give along its plane.
    void single_scans(const std::function<void()>& after_step) {
        std::vector<double> turns;
        for (const Scan& scan : fit_.scans.scans) turns.push_back(scan.turn_deg);
        const std::vector<double> joint = mu_eff_deg(fit_, turns);
        FitActive active;
        active.shared = {index_ln_weight, index_ln_mu_deg, index_receive};
        SolverOptions solver;
        solver.max_iterations = 8;
        solver.cost_tolerance = 1e-4;
        const FitPriors priors = problem_.priors;
        problem_.priors.shared.setConstant(std::numeric_limits<double>::infinity());
        constexpr double loosely = 0.05;  // rad: a scan whose peak lies outside must not run away
        problem_.priors.shared[index_receive] = loosely;
        for (std::size_t s = 0; s < fit_.fitted.size(); ++s) {
            std::fill(problem_.scan_used.begin(), problem_.scan_used.end(), char{0});
            problem_.scan_used[s] = 1;
            const auto enough = std::count(fit_.fitted[s].state.begin(), fit_.fitted[s].state.end(),
                                           ReadingState::used);
            fit_.fitted[s].mu_eff_deg = joint[s];
            if (enough < 6) continue;
            const SolverResult r =
                solve(problem_, solution_.parameters, active, solver, after_step);
            const Covariance c = covariance(problem_, r.parameters, active);
            const double ln_ratio =
                r.parameters.shared[index_ln_mu_deg] - solution_.parameters.shared[index_ln_mu_deg];
            const double sigma = std::sqrt(std::max(c.shared(1, 1), 0.0));
            if (!r.converged || !std::isfinite(sigma) || sigma > 0.5 || std::abs(ln_ratio) > 2)
                continue;
            fit_.fitted[s].mu_eff_deg = joint[s] * std::exp(ln_ratio);
            fit_.fitted[s].mu_eff_sigma_deg = fit_.fitted[s].mu_eff_deg * sigma;
        }
        std::fill(problem_.scan_used.begin(), problem_.scan_used.end(), char{1});
        problem_.priors = priors;
    }

    void notes(const std::vector<std::pair<std::string, double>>& metals) {
        FitRecord& record = fit_.record;
        record.notes = fit_.scans.notes;
        if (!solution_.converged) record.notes.emplace_back("the search ended before it converged");
        if (record.outliers > 0) {
            record.notes.push_back(std::to_string(record.outliers) + " readings lie more than " +
                                   digits(options_.outlier_sigma, 3) +
                                   " sigma off and were left out");
        }
        if (metals.size() > 1) {
            const double gain = metals[1].second;
            const bool told = metals.front().first == solution_.metal && gain > 6;
            record.notes.push_back(
                told ? "metal: the data tell " + solution_.metal + " from the next, " +
                           metals[1].first + ", by a BIC of " + digits(gain, 3)
                     : "metal: the data cannot tell " + metals.front().first + " from " +
                           metals[1].first + "; " + solution_.metal + " was taken");
        }
        if (solution_.haze) {
            record.notes.emplace_back(
                "the data ask for a second, wider lobe (haze_share, haze_width); the material's "
                "part has the first");
        }
    }

  private:
    // By how much ln weight would have to rise had the sample leant by unseen_tilt_deg across the
    // plane of incidence, where no scan shows it.
    [[nodiscard]] double drop_by_unseen_tilt() {
        if (!options_.tilt || options_.unseen_tilt_deg <= 0 ||
            solution_.active.has(index_tilt_across))
            return 0;
        FitParameters upright = solution_.parameters;
        upright.shared.tail(upright.shared.size() - index_pedestal).setZero();
        FitParameters leaning = upright;
        leaning.shared[index_tilt_across] = options_.unseen_tilt_deg / deg_per_rad;
        const std::vector<double> a = problem_.modelled(upright), b = problem_.modelled(leaning);
        double ab = 0, aa = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            if (solution_.state[i] != ReadingState::used) continue;
            const double w = 1 / (solution_.sigma[i] * solution_.sigma[i]);
            ab += w * a[i] * b[i];
            aa += w * a[i] * a[i];
        }
        constexpr double most = 40;
        return aa > 0 && ab > 0 ? std::clamp(-std::log(ab / aa), 0.0, most) : 0;
    }

    void add_weight(Table& table, const Eigen::VectorXd& x, const Covariance& c) {
        double value = std::exp(x[index_ln_weight]) * problem_.scale();
        const bool absolute = fit_.scans.calibration == ScanCalibration::absolute;
        FitParameter p;
        p.name = fit_.scans.part == ScanPart::ji ? "chi" : "beta";
        p.value = value;
        p.unit = absolute ? "1/sr" : "relative";
        // A relative weight has no scale that a tilt could falsify.
        const double drop = absolute ? drop_by_unseen_tilt() : 0;
        const double sigma = std::sqrt(std::max(c.shared(0, 0), 0.0));
        const Interval ln = interval_with_drop(std::max(sigma, 1e-12), drop);
        if (drop > sigma) {
            p.reason = "not_turned";
            p.text = "a tilt of " + digits(options_.unseen_tilt_deg, 3) +
                     " degrees across the plane of incidence, which only a turned sample shows, "
                     "would lower the peak by " +
                     digits(-100 * std::expm1(-drop), 2) + " %: the interval holds it";
        }
        if (drop > 0) {
            value *= std::exp(ln.middle);
            p.value = value;
        }
        table.add(p, {{index_ln_weight, value}});
        if (drop > 0)
            table.widen(p.name,
                        value * std::sqrt(std::max(ln.half * ln.half - sigma * sigma, 0.0)));
        fit_.lobe.weight = value;
    }

    void add_lobe(Table& table, const Eigen::VectorXd& x) {
        const double ea = x[index_e_along], ex = x[index_e_across];
        const double r = std::hypot(ea, ex);
        const double mu_t = std::exp(x[index_ln_mu_deg] + r),
                     mu_b = std::exp(x[index_ln_mu_deg] - r);
        const double ca = r > 0 ? ea / r : 0, cx = r > 0 ? ex / r : 0;
        double rho = r > 0 ? (0.5 * std::atan2(ex, ea) + problem_.axis_rad()) * deg_per_rad : 0;
        rho = std::fmod(std::fmod(rho, 180.0) + 180.0, 180.0);
        FitParameter wide{"mu_t_deg", mu_t, 0, "deg", true, "", ""};
        FitParameter narrow{"mu_b_deg", mu_b, 0, "deg", true, "", ""};
        FitParameter azimuth{"rho_deg", rho, 0, "deg", true, "", ""};
        const auto undetermined = [](FitParameter& p, const std::string& reason,
                                     const std::string& text) {
            p.determined = false;
            p.reason = reason;
            p.text = text;
        };
        if (solution_.lobe == LobeFreedom::round) {
            if (lobe_directions(fit_.scans) >= 2) {
                undetermined(azimuth, "isotropic",
                             "the data show no difference between the half widths: aspect 1");
            } else {
                const std::string text =
                    "every scan cuts the lobe in one direction; turn the sample to see the others";
                undetermined(narrow, "no_azimuth_coverage", text + " (taken to be the same)");
                undetermined(azimuth, "no_azimuth_coverage", text);
            }
        } else if (solution_.lobe == LobeFreedom::aligned) {
            // Two cuts make three numbers only where the axes are known to lie along them.
            for (FitParameter* p : {&wide, &narrow, &azimuth}) {
                undetermined(
                    *p, "no_azimuth_coverage",
                    "the scans cut the lobe in two directions only; its axes were taken to "
                    "lie along and across the first");
            }
        }
        table.add(
            wide,
            {{index_ln_mu_deg, mu_t}, {index_e_along, mu_t * ca}, {index_e_across, mu_t * cx}});
        table.add(
            narrow,
            {{index_ln_mu_deg, mu_b}, {index_e_along, -mu_b * ca}, {index_e_across, -mu_b * cx}});
        const double slope = r > 0 ? 0.5 * deg_per_rad / r : 0;
        table.add(azimuth, solution_.lobe == LobeFreedom::full
                               ? std::vector<std::pair<int, double>>{{index_e_along, -slope * cx},
                                                                     {index_e_across, slope * ca}}
                               : std::vector<std::pair<int, double>>{});
        fit_.lobe.mu_t_deg = std::clamp(mu_t, 0.001, 80.0);
        fit_.lobe.mu_b_deg =
            std::clamp(mu_b, std::max(0.001, fit_.lobe.mu_t_deg / 100), fit_.lobe.mu_t_deg);
        fit_.lobe.rho_deg = rho;
    }

    void add_pedestals(Table& table, const Eigen::VectorXd& x) {
        if (!options_.pedestal) return;
        const bool absolute = fit_.scans.calibration == ScanCalibration::absolute;
        for (std::size_t c = 0; c < fit_.scans.channels.size(); ++c) {
            const int k = index_pedestal + static_cast<int>(c);
            FitParameter p;
            p.name = "pedestal" +
                     fit_.scans.channels[c].name.substr(std::string_view("intensity").size());
            p.value = x[k] * problem_.scale();
            p.unit = absolute ? "1/sr" : "relative";
            table.add(p, {{k, problem_.scale()}});
        }
    }

    void add_haze(Table& table, const Eigen::VectorXd& x) {
        if (!solution_.haze) return;
        const double share = std::exp(x[index_ln_haze_share]),
                     width = std::exp(x[index_ln_haze_width]);
        table.add({"haze_share", share, 0, "1", true, "", ""}, {{index_ln_haze_share, share}});
        table.add({"haze_width", width, 0, "1", true, "", ""}, {{index_ln_haze_width, width}});
    }

    void add_pose(Table& table, const Eigen::VectorXd& x) {
        if (!options_.tilt) return;
        const double c = std::cos(problem_.axis_rad()), s = std::sin(problem_.axis_rad());
        const double along = x[index_tilt_along], across = x[index_tilt_across];
        FitParameter t{
            "tilt_t_deg", (c * along - s * across) * deg_per_rad, 0, "deg", true, "", ""};
        FitParameter b{
            "tilt_b_deg", (s * along + c * across) * deg_per_rad, 0, "deg", true, "", ""};
        if (!solution_.active.has(index_tilt_across)) {
            FitParameter& hidden = std::abs(c) >= std::abs(s) ? b : t;
            hidden.determined = false;
            hidden.reason = "not_turned";
            hidden.text =
                "a tilt across the plane of incidence shows only when the sample is turned; it was "
                "taken as 0, give or take unseen_tilt_deg";
        } else if (solution_.lobe == LobeFreedom::aligned) {
            // A lobe whose axes lie otherwise moves the peak as a tilt does.
            FitParameter& mixed = std::abs(c) >= std::abs(s) ? b : t;
            mixed.determined = false;
            mixed.reason = "no_azimuth_coverage";
            mixed.text = "two directions of the lobe cannot tell this tilt from a turned axis";
        }
        table.add(t, {{index_tilt_along, c * deg_per_rad}, {index_tilt_across, -s * deg_per_rad}});
        table.add(b, {{index_tilt_along, s * deg_per_rad}, {index_tilt_across, c * deg_per_rad}});
        if (!solution_.active.has(index_tilt_across)) {
            table.widen("tilt_t_deg", std::abs(s) * options_.unseen_tilt_deg);
            table.widen("tilt_b_deg", std::abs(c) * options_.unseen_tilt_deg);
        }
        const bool zero = solution_.active.has(index_receive);
        FitParameter offset{"receive_offset_deg",
                            zero ? x[index_receive] * deg_per_rad : 0.0,
                            0,
                            "deg",
                            zero,
                            "",
                            ""};
        if (!zero) {
            offset.reason = "not_turned";
            offset.text =
                "the zero of the receive angle was taken as exact; only scans of the turned sample "
                "tell "
                "it from a tilt";
        }
        table.add(offset, {{index_receive, deg_per_rad}});
        if (solution_.active.has(index_out_of_plane)) {
            table.add(
                {"out_of_plane_deg", x[index_out_of_plane] * deg_per_rad, 0, "deg", true, "", ""},
                {{index_out_of_plane, deg_per_rad}});
        }
    }

    // Marks what the data leave open, and says why as well as can be told.
    void judge() {
        double blur_deg = 0, step_deg = 0;
        for (const Scan& scan : fit_.scans.scans) {
            // 1-sigma of the aperture's average, as a facet angle, as a half width.
            blur_deg = std::max(
                blur_deg,
                1.1774 * std::hypot(scan.source_aperture_deg, scan.detector_aperture_deg) / 8);
            for (std::size_t i = 1; i < scan.rows.size(); ++i) {
                const double step = scan.rows[i].receive_deg - scan.rows[i - 1].receive_deg;
                if (step > 0 && (step_deg == 0 || step < step_deg)) step_deg = step;
            }
        }
        const bool clipped = fit_.record.clipped > 0;
        for (FitParameter& p : fit_.record.parameters) {
            if (!p.determined) continue;
            const bool width = p.name == "mu_t_deg" || p.name == "mu_b_deg";
            const bool weight = p.name == "chi" || p.name == "beta";
            const double points = step_deg > 0 ? 4 * p.value / step_deg : 0;
            const bool narrow =
                width && options_.aperture && (blur_deg > 0.5 * p.value || points < 4);
            if (narrow) {
                p.reason = "aperture_limited";
                p.text = "source and detector alone look " + digits(blur_deg, 2) +
                         " degrees wide, and " + digits(points, 2) +
                         " readings lie within the lobe's full width";
            } else if ((weight || width) && clipped) {
                p.reason = "clipped_peak";
                p.text = std::to_string(fit_.record.clipped) +
                         " readings clipped; the value rests on the flanks of the peak";
            }
            const bool at_bound = width && (p.value <= 0.0021 || p.value >= 74);
            if (at_bound) {
                p.determined = false;
                p.reason = "at_bound";
                p.text = "the data would have it beyond what the model can describe";
                continue;
            }
            const bool share = p.name == "haze_share" || p.name == "haze_width";
            const double limit = width || weight       ? vague * std::abs(p.value)
                                 : share               ? 0.5 * std::abs(p.value)
                                 : p.name == "rho_deg" ? 15.0
                                 : p.unit == "deg"     ? 2.0
                                                       : std::numeric_limits<double>::infinity();
            if (p.sigma <= limit) continue;
            p.determined = false;
            if (weight && fit_.scans.calibration == ScanCalibration::per_scan && p.reason.empty()) {
                p.reason = "unresolved";
                p.text = "every scan has a scale of its own";
            }
            if (!p.reason.empty()) continue;
            p.reason = "unresolved";
            p.text = "its standard deviation is " + digits(p.sigma, 2) + " " + p.unit;
        }
    }

    Fit& fit_;
    FitProblem& problem_;
    const Solution& solution_;
    const FitOptions& options_;
};

std::string quantity_of(const ScanSet& scans) {
    for (const Scan& scan : scans.scans) {
        if (scan.quantity != scans.scans.front().quantity) return "mixed";
    }
    return std::string(scan_quantity_names[static_cast<std::size_t>(scans.scans.front().quantity)]);
}

}  // namespace

void write_report(Fit& fit, FitProblem& problem, const Solution& solution,
                  const FitOptions& options,
                  const std::vector<std::pair<std::string, double>>& metals, bool stated_sigma,
                  const std::function<void()>& after_step) {
    FitRecord& record = fit.record;
    const ScanSet& scans = fit.scans;
    record.part = scans.part == ScanPart::ji ? "ji" : "ha";
    record.model = scan_part_names[static_cast<std::size_t>(scans.part)];
    record.software = "togishi " TOGISHI_VERSION;
    record.metal = solution.metal;
    record.quantity = quantity_of(scans);
    record.calibration = scan_calibration_names[static_cast<std::size_t>(scans.calibration)];
    record.light = scans.light;
    record.noise_estimated = !stated_sigma;
    record.noise_relative = stated_sigma ? 0 : solution.noise.relative;
    record.noise_floor = stated_sigma ? 0 : solution.noise.floor;
    record.bic = finite(solution.bic, 0);
    record.metals = metals;
    Report report(fit, problem, solution, options);
    report.readings();
    report.constants(stated_sigma);
    // What modelled_curve and mu_eff_deg evaluate.
    fit.state = {problem.scale(), problem.axis_rad(), solution.haze ? 1.0 : 0.0,
                 options.aperture ? 1.0 : 0.0, static_cast<double>(problem.aperture_rings_used())};
    const auto append = [&](const Eigen::VectorXd& v) {
        fit.state.insert(fit.state.end(), v.begin(), v.end());
    };
    append(solution.parameters.shared);
    append(solution.parameters.ln_gain);
    report.single_scans(after_step);
    for (std::size_t s = 0; s < scans.scans.size(); ++s) {
        const Scan& scan = scans.scans[s];
        const FittedScan& fitted = fit.fitted[s];
        FitScanRecord r;
        r.file = scan.file;
        r.incidence_deg = scan.incidence_deg;
        r.turn_deg = scan.turn_deg;
        r.readings = std::count(fitted.state.begin(), fitted.state.end(), ReadingState::used);
        r.rms_sigma = fitted.residual_rms_sigma;
        r.gain = fitted.gain;
        r.gain_sigma = fitted.gain_sigma;
        r.mu_eff_deg = fitted.mu_eff_deg;
        r.mu_eff_sigma_deg = fitted.mu_eff_sigma_deg;
        record.scans.push_back(std::move(r));
    }
    for (const ScanInput& input : scans.inputs)
        record.inputs.emplace_back(input.file, input.sha256);
    report.notes(metals);
}

namespace {

constexpr std::size_t state_head = 5;

FitParameters parameters_of(const Fit& fit) {
    const std::size_t shared = index_pedestal + fit.scans.channels.size();
    if (fit.state.size() != state_head + shared + fit.scans.scans.size())
        throw InputError("fit", "state", "incomplete", "what fit_scans returned");
    FitParameters p;
    const double* at = fit.state.data() + state_head;
    p.shared = Eigen::Map<const Eigen::VectorXd>(at, static_cast<Eigen::Index>(shared));
    p.ln_gain = Eigen::Map<const Eigen::VectorXd>(
        at + shared, static_cast<Eigen::Index>(fit.scans.scans.size()));
    return p;
}

}  // namespace

std::vector<double> modelled_curve(const Fit& fit, std::size_t scan,
                                   const std::vector<double>& receive_deg) {
    if (scan >= fit.scans.scans.size()) {
        throw InputError("fit", "scan", std::to_string(scan),
                         "0 to " + std::to_string(fit.scans.scans.size()) + " - 1");
    }
    FitParameters p = parameters_of(fit);
    ScanSet one = fit.scans;
    one.scans = {fit.scans.scans[scan]};
    Scan& rows = one.scans.front();
    rows.rows.clear();
    rows.sigma.clear();
    for (const double angle : receive_deg) {
        if (!(std::abs(angle) <= 90)) {
            throw InputError("fit", "receive_deg", format_number(angle), "-90 to 90 degrees");
        }
        rows.rows.push_back({angle, 0, 0});
    }
    // No readings: their scale is then 1, as the model's own has to be multiplied in.
    rows.intensity.assign(receive_deg.size() * one.channels.size(), 1.0);
    rows.saturation = std::numeric_limits<double>::infinity();
    FitProblem problem(one, fit.state[3] != 0);
    problem.set_axis_rad(fit.state[1]);
    problem.haze = fit.state[2] != 0;
    problem.set_aperture_rings(static_cast<int>(fit.state[4]));
    problem.reflectance =
        std::make_shared<const ReflectanceTable>(fit.record.metal, one.light, one.channels);
    const double gain = p.ln_gain[static_cast<Eigen::Index>(scan)];
    p.ln_gain = Eigen::VectorXd::Constant(1, gain);
    std::vector<double> values = problem.modelled(p);
    for (double& v : values) v *= fit.state[0];
    return values;
}

std::vector<double> mu_eff_deg(const Fit& fit, const std::vector<double>& turn_deg) {
    const MaterialLobe& lobe = fit.lobe;
    std::vector<double> widths;
    for (const double turn : turn_deg) {
        // The plane of incidence lies at the azimuth -turn of the sample.
        const double psi = (-turn - lobe.rho_deg) / deg_per_rad;
        widths.push_back(1 /
                         std::hypot(std::cos(psi) / lobe.mu_t_deg, std::sin(psi) / lobe.mu_b_deg));
    }
    return widths;
}

}  // namespace togishi
