#include "fit/fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "base/error.hpp"
#include "fit/report.hpp"
#include "fit/solution.hpp"
#include "fit/start.hpp"
#include "scan/scan_channel.hpp"
#include "spectral/metal.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;
// More rows than the search needs: it then takes every n-th, and the end takes all.
constexpr std::size_t rows_of_search = 20'000;
constexpr std::size_t rows_of_starts = 500;
// A metal must explain the data this much better than the default one to be chosen over it.
constexpr double bic_of_evidence = 6;

void check(std::string_view field, double value, double least, double most) {
    if (!(value >= least && value <= most)) {
        throw InputError("fit", field, format_number(value),
                         format_number(least) + " to " + format_number(most));
    }
}

void check(const FitOptions& o) {
    check("gain_prior", o.gain_prior, 1e-6, 100);
    check("tilt_prior_deg", o.tilt_prior_deg, 1e-6, 20);
    check("receive_offset_prior_deg", o.receive_offset_prior_deg, 0, 20);
    check("out_of_plane_prior_deg", o.out_of_plane_prior_deg, 0, 20);
    check("unseen_tilt_deg", o.unseen_tilt_deg, 0, 5);
    check("outlier_sigma", o.outlier_sigma, 0, 1e6);
    check("starts", o.starts, 1, 64);
    check("max_iterations", o.max_iterations, 1, 10'000);
}

// Tells the caller how far it is, in stages of a known share of the whole.
class Progress {
  public:
    explicit Progress(const FitProgress& report) : report_(report) {}
    void stage(double end) {
        begin_ = end_;
        end_ = end;
        steps_ = 0;
    }
    void operator()() {
        if (!report_) return;
        // How many steps a stage takes nobody knows: each goes a tenth of what is left.
        ++steps_;
        const double done = begin_ + (end_ - begin_) * (1 - std::pow(0.9, steps_));
        if (!report_(std::min(done, 1.0))) throw FitCancelled{};
    }
    void finish() const {
        if (report_) (void)report_(1.0);
    }

  private:
    const FitProgress& report_;
    double begin_ = 0, end_ = 0;
    int steps_ = 0;
};

class Search {
  public:
    Search(const ScanSet& scans, const FitOptions& options, const FitProgress& progress)
        : scans_(scans), options_(options), progress_(progress) {
        directions_ = lobe_directions(scans);
        turned_ = turned(scans);
        both_tilts_ = shows_both_tilts(scans);
        stated_sigma_ = std::all_of(scans.scans.begin(), scans.scans.end(),
                                    [](const Scan& s) { return !s.sigma.empty(); });
    }

    [[nodiscard]] FitProblem problem(std::size_t rows) const {
        const std::size_t all = scans_.rows();
        FitProblem p(scans_, options_.aperture, std::max<std::size_t>(1, (all + rows - 1) / rows));

        p.priors.shared[index_tilt_along] = options_.tilt_prior_deg * rad_per_deg;
        p.priors.shared[index_tilt_across] = options_.tilt_prior_deg * rad_per_deg;
        if (options_.receive_offset_prior_deg > 0)
            p.priors.shared[index_receive] = options_.receive_offset_prior_deg * rad_per_deg;
        if (options_.out_of_plane_prior_deg > 0)
            p.priors.shared[index_out_of_plane] = options_.out_of_plane_prior_deg * rad_per_deg;
        constexpr double own_scale = 10;  // of ln gain, where each scan has a scale of its own
        p.priors.ln_gain =
            scans_.calibration == ScanCalibration::per_scan ? own_scale : options_.gain_prior;
        return p;
    }

    [[nodiscard]] FitActive active(LobeFreedom lobe, bool haze) const {
        FitActive a;
        a.shared = {index_ln_weight, index_ln_mu_deg};
        if (lobe != LobeFreedom::round) a.shared.push_back(index_e_along);
        if (lobe == LobeFreedom::full) a.shared.push_back(index_e_across);
        if (options_.tilt) {
            a.shared.push_back(index_tilt_along);
            if (both_tilts_) a.shared.push_back(index_tilt_across);
            if (turned_ && options_.receive_offset_prior_deg > 0) a.shared.push_back(index_receive);
            if (options_.out_of_plane_prior_deg > 0) a.shared.push_back(index_out_of_plane);
        }
        if (haze) {
            a.shared.push_back(index_ln_haze_share);
            a.shared.push_back(index_ln_haze_width);
        }
        if (options_.pedestal) {
            for (std::size_t c = 0; c < scans_.channels.size(); ++c)
                a.shared.push_back(index_pedestal + static_cast<int>(c));
        }
        a.gain = options_.gain;
        return a;
    }

    [[nodiscard]] LobeFreedom freedom() const {
        if (options_.anisotropy == FitChoice::off || directions_ < 2) return LobeFreedom::round;
        return directions_ == 2 ? LobeFreedom::aligned : LobeFreedom::full;
    }

    [[nodiscard]] std::shared_ptr<const ReflectanceTable> table(const std::string& metal) {
        auto& found = tables_[metal];
        if (!found)
            found = std::make_shared<const ReflectanceTable>(metal, scans_.light, scans_.channels);
        return found;
    }

    // Solves, estimates the noise, marks outliers, until none of it changes any more.
    void settle(FitProblem& p, Solution& s, int passes, bool from_rough) {
        SolverOptions solver;
        solver.max_iterations = options_.max_iterations;
        p.haze = s.haze;
        p.reflectance = table(s.metal);
        if (from_rough) {
            if (!stated_sigma_) set_sigma(p, s.noise, p.modelled(s.parameters));
            constexpr double robust = 3;
            p.huber = robust;
        }
        for (int pass = 0; pass < passes; ++pass) {
            p.set_aperture_for(s.parameters);
            const SolverResult r = solve(p, s.parameters, s.active, solver, [&] { progress_(); });
            s.parameters = r.parameters;
            s.converged = r.converged;
            const std::vector<double> modelled = p.modelled(s.parameters);
            const NoiseModel before = s.noise;
            if (!stated_sigma_) {
                s.noise = estimate_noise(p, modelled, s.noise, s.active.shared.size());
                set_sigma(p, s.noise, modelled);
            }
            const std::vector<ReadingState> states = p.state;
            (void)mark_outliers(p, modelled, options_.outlier_sigma);
            const bool same_noise =
                std::abs(s.noise.relative - before.relative) <= 0.01 * before.relative &&
                std::abs(s.noise.floor - before.floor) <= 0.01 * before.floor;
            const bool settled = pass > 0 && same_noise && states == p.state;
            // From the second pass on wrong readings are out, and squares are right for the rest.
            p.huber = std::numeric_limits<double>::infinity();
            if (settled) break;
        }
        keep(p, s);
    }

    void keep(const FitProblem& p, Solution& s) const {
        s.state = p.state;
        s.sigma = p.sigma;
        const double n = static_cast<double>(std::max<std::size_t>(scans_.readings(), 2));
        const double all =
            static_cast<double>(s.active.shared.size() + (s.active.gain ? scans_.scans.size() : 0));
        const double thinned = static_cast<double>(p.rows()) / static_cast<double>(scans_.rows());
        s.bic = deviance(p, p.modelled(s.parameters)) + all * std::log(n * thinned);
    }

    // Puts a solution's readings back into the problem.
    static void restore(FitProblem& p, const Solution& s) {
        p.state = s.state;
        p.sigma = s.sigma;
        p.haze = s.haze;
        p.huber = std::numeric_limits<double>::infinity();
    }

    [[nodiscard]] Solution best_start(const std::string& metal) {
        FitProblem few = problem(rows_of_starts);
        few.reflectance = table(metal);
        few.set_aperture_rings(1);
        Solution best;
        best.lobe = freedom();
        best.metal = metal;
        best.active = active(best.lobe, false);
        double least = std::numeric_limits<double>::infinity();
        SolverOptions solver;
        solver.max_iterations = 25;
        solver.cost_tolerance = 1e-4;
        for (FitParameters& start : starting_points(scans_, few, options_.starts)) {
            if (best.lobe == LobeFreedom::round)
                start.shared[index_e_along] = start.shared[index_e_across] = 0;
            if (best.lobe == LobeFreedom::aligned) start.shared[index_e_across] = 0;
            hold_inactive(start, best.active);
            set_height(few, start);
            if (!options_.pedestal)
                start.shared.tail(static_cast<Eigen::Index>(few.channels())).setZero();
            if (!stated_sigma_) {
                // One rough noise for all starts, so that their costs compare: a share of what was
                // measured.
                set_sigma(few, {0.05, 0.01}, few.measured());
            }
            constexpr double robust = 3;
            few.huber = robust;
            const SolverResult r = solve(few, start, best.active, solver, [&] { progress_(); });
            if (r.cost < least) {
                least = r.cost;
                best.parameters = r.parameters;
            }
        }
        evaluations_ += few.evaluations;
        return best;
    }

    // What is not fitted is taken as exact.
    static void hold_inactive(FitParameters& p, const FitActive& active) {
        for (const int k :
             {index_tilt_along, index_tilt_across, index_receive, index_out_of_plane}) {
            if (!active.has(k)) p.shared[k] = 0;
        }
    }

    Solution run(FitProblem& p) {
        std::string metal = options_.metal.empty() ? scans_.metal : options_.metal;
        const bool choose_metal = metal == "auto" || metal.empty();
        if (choose_metal) metal = std::string(default_metal);
        progress_.stage(0.3);
        Solution best = best_start(metal);
        p.reflectance = table(metal);
        progress_.stage(0.6);
        settle(p, best, 6, true);
        const auto n = scans_.readings();
        const bool enough = n >= 3 * (best.active.shared.size() + 2);
        if (best.lobe != LobeFreedom::round && options_.anisotropy == FitChoice::automatic &&
            !clearly_two(p, best)) {
            Solution round = best;
            round.lobe = LobeFreedom::round;
            round.active = active(round.lobe, false);
            round.parameters.shared[index_e_along] = round.parameters.shared[index_e_across] = 0;
            restore(p, best);
            settle(p, round, 4, false);
            if (round.bic < best.bic) best = round;
        }
        progress_.stage(0.8);
        if (options_.haze == FitChoice::on || (options_.haze == FitChoice::automatic && enough))
            best = with_haze(p, best);
        progress_.stage(0.9);
        metals_ = {{best.metal, 0}};
        if (choose_metal) best = with_metal(p, best);
        evaluations_ += p.evaluations;
        return best;
    }

    // Whether the half widths differ by so many sigma that a round lobe need not be tried.
    static bool clearly_two(const FitProblem& p, const Solution& s) {
        const Covariance c = covariance(p, s.parameters, s.active);
        double variance = 0;
        for (std::size_t a = 0; a < s.active.shared.size(); ++a) {
            const auto at = static_cast<Eigen::Index>(a);
            if (s.active.shared[a] == index_e_along || s.active.shared[a] == index_e_across)
                variance = std::max(variance, c.shared(at, at));
        }
        const double r =
            std::hypot(s.parameters.shared[index_e_along], s.parameters.shared[index_e_across]);
        constexpr double clearly = 20;
        return r > clearly * std::sqrt(variance);
    }

    Solution with_haze(FitProblem& p, const Solution& plain) {
        Solution best = plain;
        bool first = true;
        constexpr std::pair<double, double> starts[] = {{0.05, 3.0}, {0.01, 6.0}};
        for (const auto& [share, width] : starts) {
            Solution hazy = plain;
            hazy.haze = true;
            hazy.active = active(plain.lobe, true);
            hazy.parameters.shared[index_ln_haze_share] = std::log(share);
            hazy.parameters.shared[index_ln_haze_width] = std::log(width);
            restore(p, plain);
            // A quick look first: as the noise was estimated without it, a second lobe must already
            // pay.
            p.haze = true;
            SolverOptions look;
            look.max_iterations = 12;
            look.cost_tolerance = 1e-5;
            const SolverResult r =
                solve(p, hazy.parameters, hazy.active, look, [&] { progress_(); });
            p.haze = false;
            constexpr double worth = 10;
            if (options_.haze != FitChoice::on && p.cost(plain.parameters) - r.cost < worth)
                continue;
            hazy.parameters = r.parameters;
            settle(p, hazy, 5, false);
            if (hazy.bic < best.bic || (options_.haze == FitChoice::on && first)) best = hazy;
            first = false;
        }
        return best;
    }

    Solution with_metal(FitProblem& p, const Solution& plain) {
        std::vector<Solution> all{plain};
        for (const auto& metal : builtin_metals()) {
            const std::string name(metal->name());
            if (name == plain.metal) continue;
            Solution other = plain;
            other.metal = name;
            restore(p, plain);
            settle(p, other, 2, false);
            all.push_back(std::move(other));
        }
        std::sort(all.begin(), all.end(),
                  [](const Solution& a, const Solution& b) { return a.bic < b.bic; });
        metals_.clear();
        for (const Solution& s : all) metals_.emplace_back(s.metal, s.bic - all.front().bic);
        const bool clear = plain.bic - all.front().bic > bic_of_evidence;
        return clear ? all.front() : plain;
    }

    void settle_on_all(FitProblem& p, Solution& s) {
        p.reflectance = table(s.metal);
        p.set_aperture_for(s.parameters);
        p.haze = s.haze;
        if (!stated_sigma_) set_sigma(p, s.noise, p.modelled(s.parameters));
        (void)mark_outliers(p, p.modelled(s.parameters), options_.outlier_sigma);
        settle(p, s, 3, false);
        evaluations_ += p.evaluations;
    }

    int evaluations_ = 0;
    std::vector<std::pair<std::string, double>> metals_;
    [[nodiscard]] bool stated_sigma() const { return stated_sigma_; }
    [[nodiscard]] int directions() const { return directions_; }
    [[nodiscard]] bool is_turned() const { return turned_; }
    Progress& progress() { return progress_; }

  private:
    const ScanSet& scans_;
    const FitOptions& options_;
    Progress progress_;
    int directions_ = 1;
    bool turned_ = false, both_tilts_ = false, stated_sigma_ = false;
    std::map<std::string, std::shared_ptr<const ReflectanceTable>> tables_;
};

// Readings at the top of the range, many times the very same: a detector that clipped and nobody
// said so.
void find_clipping(ScanSet& scans) {
    const std::size_t channels = scans.channels.size();
    for (Scan& scan : scans.scans) {
        if (std::isfinite(scan.saturation)) continue;
        double top = 0;
        for (const double v : scan.intensity) top = std::max(top, std::isfinite(v) ? v : 0.0);
        if (!(top > 0)) continue;
        std::size_t longest = 0, same = 0, all = 0;
        for (std::size_t i = 0; i < scan.rows.size(); ++i) {
            const bool at_top = scan.intensity[i * channels] == top;
            same = at_top ? same + 1 : 0;
            all += at_top ? 1 : 0;
            longest = std::max(longest, same);
        }
        constexpr std::size_t plateau = 4;
        // A constant scan has a plateau, too, but no flanks.
        if (longest < plateau || all == scan.rows.size()) continue;
        scan.saturation = top;
        scans.notes.push_back("incidence " + format_number(scan.incidence_deg) + ", turn " +
                              format_number(scan.turn_deg) + ": " + std::to_string(all) +
                              " readings share the top value and were taken as clipped");
    }
}

void check_signal(const ScanSet& scans) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Scan& scan : scans.scans) {
        for (const double v : scan.intensity) {
            if (!std::isfinite(v)) continue;
            low = std::min(low, v);
            high = std::max(high, v);
        }
    }
    const std::string where = scans.inputs.empty() ? "scans" : scans.inputs.front().file;
    if (!(high > 0)) throw InputError(where, "intensity", "nowhere above 0", "scans with a signal");
    if (!(high - low > 1e-9 * high)) {
        throw InputError(where, "intensity", "the same everywhere (" + format_number(high) + ")",
                         "scans with a peak");
    }
}

// Scans that a joint fit must not see: all others' light is missing there.
std::vector<std::string> leave_out_dark(ScanSet& scans) {
    std::vector<std::string> notes;
    std::vector<double> tops;
    for (const Scan& scan : scans.scans) {
        double top = 0;
        for (const double v : scan.intensity) top = std::max(top, std::isfinite(v) ? v : 0.0);
        tops.push_back(top);
    }
    const double most = *std::max_element(tops.begin(), tops.end());
    constexpr double dark = 1e-4;
    for (std::size_t s = 0; s < tops.size(); ++s) {
        Scan& scan = scans.scans[s];
        // Another calibration of each scan may make any of them small.
        if (tops[s] > dark * most ||
            (scans.calibration == ScanCalibration::per_scan && tops[s] > 0))
            continue;
        std::fill(scan.intensity.begin(), scan.intensity.end(),
                  std::numeric_limits<double>::quiet_NaN());
        notes.push_back("incidence " + format_number(scan.incidence_deg) + ", turn " +
                        format_number(scan.turn_deg) + ": no signal; the scan was left out");
    }
    return notes;
}

// Infinite and NaN readings from outside a file are gaps.
void drop_non_finite(ScanSet& scans) {
    std::size_t dropped = 0;
    for (Scan& scan : scans.scans) {
        for (std::size_t i = 0; i < scan.intensity.size(); ++i) {
            double& v = scan.intensity[i];
            const bool no_sigma =
                !scan.sigma.empty() && !(scan.sigma[i] > 0 && std::isfinite(scan.sigma[i]));
            if (std::isnan(v) || (std::isfinite(v) && !no_sigma)) continue;
            v = std::numeric_limits<double>::quiet_NaN();
            ++dropped;
        }
    }
    if (dropped > 0)
        scans.notes.push_back(std::to_string(dropped) + " infinite readings were left out");
}

}  // namespace

Fit fit_scans(const ScanSet& scans, const FitOptions& options, const FitProgress& progress) {
    const auto begin = std::chrono::steady_clock::now();
    check(options);
    if (scans.scans.empty() || scans.rows() == 0)
        throw InputError("scans", "rows", "none", "scans with rows");
    if (!options.metal.empty() && options.metal != "auto") (void)find_metal(options.metal);
    Fit fit;
    fit.scans = scans;
    drop_non_finite(fit.scans);
    if (fit.scans.readings() == 0)
        throw InputError("scans", "intensity", "no reading", "scans with readings");
    check_signal(fit.scans);
    for (std::string& note : leave_out_dark(fit.scans)) fit.scans.notes.push_back(std::move(note));
    find_clipping(fit.scans);

    Search search(fit.scans, options, progress);
    LobeFreedom least = options.anisotropy == FitChoice::on ? search.freedom() : LobeFreedom::round;
    const std::size_t parameters =
        search.active(least, options.haze == FitChoice::on).shared.size();
    if (fit.scans.readings() < parameters) {
        const std::string where = scans.inputs.empty() ? "scans" : scans.inputs.front().file;
        throw InputError(where, "readings", std::to_string(fit.scans.readings()),
                         "at least " + std::to_string(parameters) + ", as many as parameters");
    }
    FitProblem thinned = search.problem(rows_of_search);
    Solution solution = search.run(thinned);
    search.progress().stage(0.97);
    if (thinned.rows() < fit.scans.rows()) {
        FitProblem all = search.problem(fit.scans.rows());
        search.settle_on_all(all, solution);
        write_report(fit, all, solution, options, search.metals_, search.stated_sigma(),
                     [&] { search.progress()(); });
    } else {
        Search::restore(thinned, solution);
        thinned.reflectance = search.table(solution.metal);
        thinned.set_aperture_for(solution.parameters);
        write_report(fit, thinned, solution, options, search.metals_, search.stated_sigma(),
                     [&] { search.progress()(); });
    }
    fit.evaluations = search.evaluations_;
    fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    search.progress().finish();
    return fit;
}

}  // namespace togishi
