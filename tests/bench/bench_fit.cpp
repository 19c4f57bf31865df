// How well simulated scans are recovered, and how fast. Prints one JSON object; tests/bench/fit.py
// runs it and writes the rows.
//
//   bench_fit recovery TRIALS SEED [CASE ...]   as it is, and without aperture, tilt and gain terms
//   bench_fit speed REPEATS                     seconds of full fits, the median
//   bench_fit points TRIALS SEED                error and time against readings and starts
//   bench_fit extremes                          what becomes of stiff and of hopeless data
//
// A trial: the part's lobe at a random azimuth, a random gain per scan (1 %), noise of 0.5 % of the
// signal and 0.02 % of the peak, a pedestal of 0.5 % of the peak, source and detector of 0.2
// degrees, the normal leaning by up to 0.2 degrees. Cases a_*: protocol (a), and b_*: protocol (b),
// any direction of the lean. bp_*: protocol (b), the lean in the plane of incidence, as after a
// sample was set upright across it, and fitted as such. bt_*: protocol (b) with the sample at 0 and
// at 90 degrees, any lean. Truth by the reference evaluation at 550 nm.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random_normal.hpp"
#include "fit/fit.hpp"
#include "scan/simulate_scan.hpp"

namespace {

using namespace togishi;

constexpr double pi = 3.14159265358979323846;
constexpr double ln2 = 0.69314718055994530942;

struct Case {
    const char* name;
    double mu_t_deg, mu_b_deg;
    ScanPart part;
    char protocol;  // a, b, t: b with the sample turned, p: b with the lean in the plane
};
constexpr Case cases[] = {{"a_12_9", 12, 9, ScanPart::hamon, 'a'},
                          {"a_8_5", 8, 5, ScanPart::hamon, 'a'},
                          {"a_4_2.5", 4, 2.5, ScanPart::hamon, 'a'},
                          {"a_2_0.5", 2, 0.5, ScanPart::hamon, 'a'},
                          {"a_0.5_0.3", 0.5, 0.3, ScanPart::hamon, 'a'},
                          {"b_0.3", 0.3, 0.3, ScanPart::ji, 'b'},
                          {"b_0.5", 0.5, 0.5, ScanPart::ji, 'b'},
                          {"b_1", 1, 1, ScanPart::ji, 'b'},
                          {"b_2", 2, 2, ScanPart::ji, 'b'},
                          {"bp_0.3", 0.3, 0.3, ScanPart::ji, 'p'},
                          {"bp_0.5", 0.5, 0.5, ScanPart::ji, 'p'},
                          {"bt_0.3", 0.3, 0.3, ScanPart::ji, 't'},
                          {"bt_0.5", 0.5, 0.5, ScanPart::ji, 't'},
                          {"bt_1", 1, 1, ScanPart::ji, 't'},
                          {"bt_2", 2, 2, ScanPart::ji, 't'}};

struct Truth {
    MaterialLobe lobe;
    SimulationOptions options;
    Material material;
    double pedestal = 0;  // 1/sr
};

Truth truth_of(const Case& c, std::uint64_t seed) {
    RandomNormal random(seed);
    Truth t;
    t.material = default_material();
    t.material.weights = Weights::measured;
    t.lobe.mu_t_deg = c.mu_t_deg;
    t.lobe.mu_b_deg = c.mu_b_deg;
    t.lobe.rho_deg = 180 * random.uniform();
    const double rad = pi / 180;
    t.lobe.weight = ln2 / (4 * pi * c.mu_t_deg * rad * c.mu_b_deg * rad);
    (c.part == ScanPart::ji ? t.material.ji : t.material.ha) = t.lobe;
    t.options.protocol = scan_protocol(c.protocol == 'a' ? "a" : "b");
    if (c.protocol == 't') t.options.protocol.turns_deg = {0, 90};
    t.options.channels = {"intensity_550nm"};
    t.options.pedestal = 0.005;
    const double lean = 0.2 * random.uniform(), towards = 2 * pi * random.uniform();
    if (c.protocol == 'p') {
        t.options.tilt_t_deg = random.uniform() < 0.5 ? lean : -lean;
    } else {
        t.options.tilt_t_deg = lean * std::cos(towards);
        t.options.tilt_b_deg = lean * std::sin(towards);
    }
    t.options.seed = seed ^ 0x5bd1e995U;
    SimulationOptions perfect = t.options;
    perfect.noise_relative = perfect.noise_floor = perfect.gain_error = perfect.pedestal = 0;
    for (const Scan& scan : simulate_scan(t.material, c.part, perfect, 1).scans) {
        for (const double v : scan.intensity)
            t.pedestal = std::max(t.pedestal, t.options.pedestal * v);
    }
    return t;
}

const FitParameter* find(const Fit& fit, const char* name) {
    for (const FitParameter& p : fit.record.parameters) {
        if (p.name == name) return &p;
    }
    return nullptr;
}

// Errors of one quantity over the trials, and how often the interval held the truth.
struct Errors {
    std::vector<double> size;
    std::size_t held = 0, judged = 0;
    void add(double error, double sigma, double unit) {
        size.push_back(std::abs(error) / unit);
        if (sigma > 0) {
            ++judged;
            held += std::abs(error) <= sigma ? 1 : 0;
        }
    }
    [[nodiscard]] double quantile(double q) const {
        if (size.empty()) return -1;
        std::vector<double> sorted = size;
        std::sort(sorted.begin(), sorted.end());
        return sorted[std::min(sorted.size() - 1,
                               static_cast<std::size_t>(q * static_cast<double>(sorted.size())))];
    }
    void print(const char* name, const char* before) const {
        std::printf(
            "%s\"%s\": {\"median\": %.6g, \"p90\": %.6g, \"coverage\": %.5g}", before, name,
            quantile(0.5), quantile(0.9),
            judged > 0 ? 100.0 * static_cast<double>(held) / static_cast<double>(judged) : -1.0);
    }
};

struct Tally {
    Errors mu_t, mu_b, rho, weight, pedestal, tilt_t, tilt_b, receive;
    std::vector<double> rho_sigmas;  // what the readings tell of it at best
    std::size_t haze = 0, round = 0, failed = 0;
    double seconds = 0, chi2 = 0;

    // Errors of a parameter that the scans can tell.
    static void judge(Errors& errors, const FitParameter* p, double truth, double unit) {
        if (p != nullptr && p->determined) errors.add(p->value - truth, p->sigma, unit);
    }

    void add(const Case& c, const Truth& truth, const Fit& fit) {
        const MaterialLobe& lobe = truth.lobe;
        const FitParameter *t = find(fit, "mu_t_deg"), *b = find(fit, "mu_b_deg"),
                           *w = find(fit, c.part == ScanPart::ji ? "chi" : "beta"),
                           *r = find(fit, "rho_deg");
        mu_t.add(t->value - lobe.mu_t_deg, t->sigma, 0.01 * lobe.mu_t_deg);
        weight.add(w->value - lobe.weight, w->sigma, 0.01 * lobe.weight);
        if (c.mu_t_deg > 1.1 * c.mu_b_deg) {
            mu_b.add(b->value - lobe.mu_b_deg, b->sigma, 0.01 * lobe.mu_b_deg);
            rho.add(std::remainder(r->value - lobe.rho_deg, 180.0), r->sigma, 1);
            rho_sigmas.push_back(r->sigma);
        }
        judge(pedestal, find(fit, "pedestal_550nm"), truth.pedestal, 0.01 * truth.pedestal);
        judge(tilt_t, find(fit, "tilt_t_deg"), truth.options.tilt_t_deg, 1);
        judge(tilt_b, find(fit, "tilt_b_deg"), truth.options.tilt_b_deg, 1);
        judge(receive, find(fit, "receive_offset_deg"), 0, 1);
        haze += find(fit, "haze_share") != nullptr ? 1 : 0;
        seconds += fit.seconds;
        chi2 += fit.record.chi2_reduced;
    }
    void print(const char* name, std::size_t trials) const {
        const auto n = static_cast<double>(trials);
        std::printf("\"%s\": {", name);
        mu_t.print("mu_t_pct", "");
        if (!mu_b.size.empty()) {
            mu_b.print("mu_b_pct", ", ");
            rho.print("rho_deg", ", ");
        }
        weight.print("weight_pct", ", ");
        const std::pair<const char*, const Errors*> others[] = {{"pedestal_pct", &pedestal},
                                                                {"tilt_t_deg", &tilt_t},
                                                                {"tilt_b_deg", &tilt_b},
                                                                {"receive_offset_deg", &receive}};
        for (const auto& [title, errors] : others) {
            if (!errors->size.empty()) errors->print(title, ", ");
        }
        std::printf(
            ", \"haze_chosen\": %zu, \"failed\": %zu, \"seconds\": %.5g, \"chi2_reduced\": %.5g}",
            haze, failed, seconds / n, chi2 / n);
    }
};

// The median size of errors that have these standard deviations.
double median_of_normals(const std::vector<double>& sigmas) {
    double low = 0, high = 10 * *std::max_element(sigmas.begin(), sigmas.end());
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        double below = 0;
        for (const double sigma : sigmas) below += std::erf(middle / (sigma * std::sqrt(2.0)));
        (below < 0.5 * static_cast<double>(sigmas.size()) ? low : high) = middle;
    }
    return low;
}

void recover(const Case& c, std::size_t trials, std::uint64_t seed) {
    Tally with, without;
    std::mutex lock;
    parallel_for(trials, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Truth t = truth_of(c, seed * 1'000'003U + i);
            const ScanSet scans = simulate_scan(t.material, c.part, t.options, 1);
            FitOptions full, bare;
            if (c.protocol == 'p') full.unseen_tilt_deg = 0;
            bare.aperture = bare.tilt = bare.gain = false;
            for (const bool all_terms : {true, false}) {
                Tally& tally = all_terms ? with : without;
                try {
                    const Fit fit = fit_scans(scans, all_terms ? full : bare);
                    const std::scoped_lock hold(lock);
                    tally.add(c, t, fit);
                } catch (const InputError& error) {
                    const std::scoped_lock hold(lock);
                    std::fprintf(stderr, "%s: %s\n", c.name, error.what());
                    ++tally.failed;
                }
            }
        }
    });
    std::printf("\"%s\": {\"trials\": %zu, ", c.name, trials);
    with.print("fit", trials);
    std::printf(", ");
    without.print("without_terms", trials);
    if (!with.rho_sigmas.empty())
        std::printf(", \"rho_deg_at_best\": %.6g", median_of_normals(with.rho_sigmas));
    std::printf("}");
    std::fflush(stdout);
}

void recovery(std::size_t trials, std::uint64_t seed, const std::vector<std::string>& names) {
    std::printf("{\"seed\": %llu, \"cases\": {", static_cast<unsigned long long>(seed));
    bool first = true;
    for (const Case& c : cases) {
        if (!names.empty() && std::find(names.begin(), names.end(), c.name) == names.end())
            continue;
        std::printf(first ? "\n" : ",\n");
        first = false;
        recover(c, trials, seed);
    }
    std::printf("\n}}\n");
}

double median_seconds(const ScanSet& scans, const FitOptions& options, int repeats,
                      int* evaluations) {
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) {
        const Fit fit = fit_scans(scans, options);
        seconds.push_back(fit.seconds);
        *evaluations = fit.evaluations;
    }
    std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
    return seconds[static_cast<std::size_t>(repeats / 2)];
}

void speed(int repeats) {
    std::printf("{\"cases\": {");
    bool first = true;
    for (const char* name : {"a_8_5", "a_0.5_0.3", "b_0.3", "b_2"}) {
        for (const Case& c : cases) {
            if (std::strcmp(c.name, name) != 0) continue;
            Truth t = truth_of(c, 7);
            const ScanSet one = simulate_scan(t.material, c.part, t.options);
            FitOptions options;
            int evaluations = 0;
            const double known = median_seconds(one, options, repeats, &evaluations);
            const int known_evaluations = evaluations;
            options.metal = "auto";
            const double chosen = median_seconds(one, options, repeats, &evaluations);
            std::printf(
                "%s\n\"%s\": {\"readings\": %zu, \"seconds\": %.5g, \"evaluations\": %d, "
                "\"seconds_metal_auto\": %.5g, \"evaluations_metal_auto\": %d}",
                first ? "" : ",", name, one.readings(), known, known_evaluations, chosen,
                evaluations);
            first = false;
        }
    }
    std::printf("\n}}\n");
}

void points(std::size_t trials, std::uint64_t seed) {
    std::printf("{\"rows\": [");
    bool first = true;
    const Case c = cases[1];
    for (const double step : {4.0, 2.0, 1.0, 0.4, 0.2, 0.1, 0.04}) {
        for (const int starts : {1, 2, 6, 16}) {
            Tally tally;
            std::size_t readings = 0;
            for (std::size_t i = 0; i < trials; ++i) {
                Truth t = truth_of(c, seed * 1'000'003U + i);
                t.options.protocol.step_deg = step;
                const ScanSet scans = simulate_scan(t.material, c.part, t.options);
                FitOptions options;
                options.starts = starts;
                const Fit fit = fit_scans(scans, options);
                tally.add(c, t, fit);
                readings = scans.readings();
            }
            std::printf("%s\n{\"readings\": %zu, \"starts\": %d, ", first ? "" : ",", readings,
                        starts);
            tally.print("fit", trials);
            std::printf("}");
            first = false;
        }
    }
    std::printf("\n]}\n");
}

// What was found and said of data at the ends of what can be measured.
void extreme(const char* name, const ScanSet& scans, bool* first) {
    std::printf("%s\n\"%s\": {\"readings\": %zu, ", *first ? "" : ",", name, scans.readings());
    *first = false;
    try {
        const Fit fit = fit_scans(scans);
        std::printf("\"seconds\": %.4g, \"chi2_reduced\": %.4g, \"parameters\": {", fit.seconds,
                    fit.record.chi2_reduced);
        const char* before = "";
        for (const FitParameter& p : fit.record.parameters) {
            std::printf(
                "%s\"%s\": {\"value\": %.8g, \"sigma\": %.3g, \"determined\": %s, \"reason\": "
                "\"%s\"}",
                before, p.name.c_str(), p.value, p.sigma, p.determined ? "true" : "false",
                p.reason.c_str());
            before = ", ";
        }
        std::printf("}}");
    } catch (const InputError& error) {
        std::printf("\"refused\": \"%s\"}", error.what());
    }
}

void extremes() {
    std::printf("{\"cases\": {");
    bool first = true;
    for (const double mu : {0.05, 0.1, 5.0, 20.0}) {
        for (const double aspect : {1.0, 4.0, 20.0}) {
            if (mu / aspect < 0.04) continue;
            const Case c{"", mu, mu / aspect, ScanPart::hamon, 'a'};
            const std::string name = "mu_" + std::to_string(mu).substr(0, 5) + "_aspect_" +
                                     std::to_string(aspect).substr(0, 4);
            const Truth t = truth_of(c, 3);
            extreme(name.c_str(), simulate_scan(t.material, c.part, t.options), &first);
        }
    }
    const Case c = cases[1];
    Truth t = truth_of(c, 5);
    t.options.saturation = 0.6;
    extreme("clipped", simulate_scan(t.material, c.part, t.options), &first);
    t = truth_of(c, 5);
    t.options.protocol.turns_deg = {0};
    t.options.protocol.step_deg = 10;
    extreme("five_points", simulate_scan(t.material, c.part, t.options), &first);
    t = truth_of(c, 5);
    ScanSet scans = simulate_scan(t.material, c.part, t.options);
    for (Scan& scan : scans.scans) std::fill(scan.intensity.begin(), scan.intensity.end(), 1.0);
    extreme("constant", scans, &first);
    scans = simulate_scan(t.material, c.part, t.options);
    std::fill(scans.scans[1].intensity.begin(), scans.scans[1].intensity.end(), 0.0);
    extreme("one_scan_of_zeros", scans, &first);
    for (Scan& scan : scans.scans) std::fill(scan.intensity.begin(), scan.intensity.end(), 0.0);
    extreme("all_zeros", scans, &first);
    scans = simulate_scan(t.material, c.part, t.options);
    scans.scans[2].intensity[100] = std::nan("");
    extreme("one_nan", scans, &first);
    t.options.protocol.step_deg = 40.0 / 250'000;
    extreme("million", simulate_scan(t.material, c.part, t.options), &first);
    std::printf("\n}}\n");
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const auto number = [&](std::size_t i, long otherwise) {
        return i < arguments.size() ? std::strtol(arguments[i].c_str(), nullptr, 10) : otherwise;
    };
    const std::string what = arguments.empty() ? "" : arguments[0];
    if (what == "recovery") {
        recovery(static_cast<std::size_t>(std::max(1L, number(1, 1000))),
                 static_cast<std::uint64_t>(number(2, 1)),
                 {arguments.begin() +
                      std::min<std::ptrdiff_t>(3, static_cast<std::ptrdiff_t>(arguments.size())),
                  arguments.end()});
    } else if (what == "speed") {
        speed(static_cast<int>(std::max(1L, number(1, 21))));
    } else if (what == "points") {
        points(static_cast<std::size_t>(std::max(1L, number(1, 50))),
               static_cast<std::uint64_t>(number(2, 1)));
    } else if (what == "extremes") {
        extremes();
    } else {
        std::fprintf(stderr,
                     "bench_fit recovery TRIALS SEED [CASE ...] | speed REPEATS | points TRIALS "
                     "SEED | extremes\n");
        return 2;
    }
    return 0;
}
