// How a part of a material was fitted to a measurement: what an archivist must be able to read
// years later.
//
// TOML: a table [fit.<part>] with format, model, software, metal, quantity, calibration, light,
// noise_relative, noise_floor, noise_estimated, chi2_reduced, bic, readings, outliers, clipped,
// metals = [[name, delta_bic], ...], notes = [...], correlations = [[...], ...] in the order of the
// parameters, and the arrays of tables input (file, sha256), parameter (name, value, sigma, unit,
// determined, reason, text) and scan (file, incidence_deg, turn_deg, readings, rms_sigma, gain,
// gain_sigma, mu_eff_deg, mu_eff_sigma_deg).
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace togishi {

/// One fitted constant. reason: "" or one of "aperture_limited", "no_azimuth_coverage",
/// "clipped_peak", "isotropic", "not_turned", "at_bound", "no_signal", "unresolved"; text says it
/// in a sentence.
struct FitParameter {
    std::string name;  ///< chi | beta, mu_t_deg, mu_b_deg, rho_deg, pedestal, haze_share,
                       ///< haze_width, tilt_t_deg, tilt_b_deg, receive_offset_deg, out_of_plane_deg
    double value = 0;
    double sigma = 0;  ///< one standard deviation; 0 where the parameter was not fitted
    std::string unit;  ///< "1/sr", "deg", "relative", "1"
    bool determined = true;
    std::string reason;
    std::string text;
    friend bool operator==(const FitParameter&, const FitParameter&) = default;
};

struct FitScanRecord {
    std::string file;
    double incidence_deg = 0;
    double turn_deg = 0;
    std::int64_t readings = 0;
    double rms_sigma = 0;
    double gain = 1;
    double gain_sigma = 0;
    double mu_eff_deg = 0;
    double mu_eff_sigma_deg = 0;
    friend bool operator==(const FitScanRecord&, const FitScanRecord&) = default;
};

struct FitRecord {
    std::string part;   ///< of the material: ji or ha
    std::string model;  ///< ji or hamon
    std::string software;
    std::string metal;
    std::string quantity;     ///< "mixed" where the files differ
    std::string calibration;  ///< relative and per_scan: the weight is relative, too
    std::string light;
    double noise_relative = 0;  ///< share of the signal; both 0 where the file states sigma
    double noise_floor = 0;     ///< share of the peak
    bool noise_estimated = true;
    double chi2_reduced = 0;
    double bic = 0;
    std::int64_t readings = 0;  ///< used ones
    std::int64_t outliers = 0;
    std::int64_t clipped = 0;
    /// Metals that were compared, the best first, with what their BIC has more than the best's.
    std::vector<std::pair<std::string, double>> metals;
    std::vector<FitParameter> parameters;
    std::vector<std::vector<double>> correlations;  ///< square, in the order of parameters
    std::vector<FitScanRecord> scans;
    std::vector<std::pair<std::string, std::string>> inputs;  ///< file, SHA-256
    std::vector<std::string> notes;
    friend bool operator==(const FitRecord&, const FitRecord&) = default;
};

}  // namespace togishi
