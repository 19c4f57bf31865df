// From goniometer scans to the constants of the model, with what they are worth.
//
// Model of a reading, in the terms of shaders/shared and of scan/scan.hpp:
//   gain(scan) (A[weight F D (1 or G/cos theta_r) q] + pedestal)
// where A averages over source and detector, q makes the quantity (1, cos theta_r or 1/cos
// theta_i), and the sample's normal leans by two tilts that turn with it. ji: weight chi,
// F(theta_i); hamon: weight beta, F(theta_H) G/cos theta_r. A second lobe of the same shape, wider
// and lower, where the data ask for it.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "brdf/fit_record.hpp"
#include "brdf/material.hpp"
#include "scan/scan.hpp"

namespace togishi {

/// Off, on, or decided by an information criterion (BIC).
enum class FitChoice { off, on, automatic };

struct FitOptions {
    std::string metal;  ///< as find_metal takes it; "": as the scans say; "auto": by evidence
    FitChoice anisotropy = FitChoice::automatic;
    FitChoice haze = FitChoice::automatic;
    bool aperture = true;  ///< false: as if source and detector were points
    bool tilt = true;      ///< fit the two tilts and the zero of the receive angle
    bool gain = true;      ///< fit a factor per scan
    bool pedestal = true;
    double gain_prior = 0.01;  ///< standard deviation of ln gain
    double tilt_prior_deg = 1;
    double receive_offset_prior_deg = 0.2;  ///< 0: taken as exact
    double out_of_plane_prior_deg = 0;      ///< 0: taken as exact
    /// Standard deviation of a tilt that no scan shows: across the plane of incidence, where the
    /// sample was not turned. It lowers the peak, so the weight's interval holds it. 0: there is
    /// none. Default: of a lean of up to 0.2 degrees, any direction.
    double unseen_tilt_deg = 0.08;
    double outlier_sigma = 5;  ///< readings further off are left out, and said; 0: none are
    int starts = 6;            ///< 1 to 64
    int max_iterations = 60;   ///< per start
};

/// What became of a reading.
enum class ReadingState : unsigned char { used, outlier, clipped, gap };

/// One scan beside what the fitted model says of it. (N, C) as in Scan.
struct FittedScan {
    std::vector<double> modelled;
    std::vector<double> residual_sigma;  ///< (measured - modelled)/sigma; 0 for gaps
    std::vector<ReadingState> state;
    double gain = 1;
    double gain_sigma = 0;
    double residual_rms_sigma = 0;  ///< of the used readings
    double mu_eff_deg = 0;        ///< half width along the plane of incidence, this scan by itself
    double mu_eff_sigma_deg = 0;  ///< 0 where it cannot be told
};

struct Fit {
    ScanSet scans;
    FitRecord record;                ///< everything that goes into the material
    std::vector<FittedScan> fitted;  ///< one for each scan
    MaterialLobe lobe;               ///< weight in 1/sr, or relative
    int evaluations = 0;
    double seconds = 0;         ///< wall clock
    std::vector<double> state;  ///< what modelled_curve needs: not for reading
};

/// Called with the share done, in [0, 1]; false cancels.
using FitProgress = std::function<bool(double)>;
/// Thrown by fit_scans where the progress callback said so.
struct FitCancelled {};

/// One thread; independent of the order of rows and scans. Never a NaN in the result: what the data
/// cannot determine is in record.parameters with its reason. Throws InputError where nothing can be
/// fitted: fewer readings than parameters, no signal, unknown metal, options out of range.
[[nodiscard]] Fit fit_scans(const ScanSet& scans, const FitOptions& options = {},
                            const FitProgress& progress = {});

/// The fitted model at other receive angles of one scan, in its plane: (N, C). Throws InputError.
[[nodiscard]] std::vector<double> modelled_curve(const Fit& fit, std::size_t scan,
                                                 const std::vector<double>& receive_deg);

/// Half width of the fitted lobe along the plane of incidence at each turn of the sample, in
/// degrees.
[[nodiscard]] std::vector<double> mu_eff_deg(const Fit& fit, const std::vector<double>& turn_deg);

/// The base with the fitted parts put in: ji from a ji fit, ha from a hamon fit, each with its
/// record. An absolute weight makes the material's weights measured; lobes that then lack a
/// constant get that of normalised weights, ln2/(4 pi mu_t mu_b). A relative weight stays in the
/// record only. Throws InputError where two fits are of one part.
[[nodiscard]] Material material_from_fits(const std::vector<const Fit*>& fits, const Material& base,
                                          const std::string& name);

}  // namespace togishi
