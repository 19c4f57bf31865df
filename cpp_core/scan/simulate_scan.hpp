// Scans of a known material, made with the reference evaluation: for testing a fit, and for
// planning a measurement. Shares no code with the fit but the model's formulas.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "brdf/material.hpp"
#include "scan/scan.hpp"

namespace togishi {

/// Which angles are measured.
struct ScanProtocol {
    std::vector<double> incidences_deg;
    std::vector<double> turns_deg;           ///< counter-clockwise
    std::vector<double> azimuths_deg = {0};  ///< of the detector, out of the plane of incidence
    double receive_first_deg = 25;
    double receive_last_deg = 65;
    double step_deg = 0.2;
    double dense_within_deg = 90;  ///< of the mirror direction; beyond it coarse_step_deg
    double coarse_step_deg = 2;
};

/// "a": incidence 45, receive 25 to 65 at 0.2, turned 0, 45, 135 and 180 degrees.
/// "b": incidences 15 to 65 by 10, receive 10 to 80, 0.2 within 20 of the mirror direction, else 2;
/// not turned. Throws InputError for another name.
[[nodiscard]] ScanProtocol scan_protocol(const std::string& name);

struct SimulationOptions {
    ScanProtocol protocol = scan_protocol("a");
    ScanQuantity quantity = ScanQuantity::radiance;
    ScanCalibration calibration = ScanCalibration::absolute;
    std::vector<std::string> channels{
        "intensity"};  ///< titles: intensity[_x|_y|_z|_r|_g|_b|_550nm]
    std::string light = "D65";
    double noise_relative = 0.005;  ///< standard deviation, share of the signal
    double noise_floor = 0.0002;    ///< and share of the set's peak; both add in squares
    double gain_error = 0.01;       ///< standard deviation of each scan's factor
    double source_aperture_deg = 0.2;
    double detector_aperture_deg = 0.2;
    double pedestal = 0;    ///< stray light, share of the set's peak
    double tilt_t_deg = 0;  ///< the sample's normal leans towards its T, and turns with it
    double tilt_b_deg = 0;  ///< and towards its B
    double receive_offset_deg =
        0;  ///< the detector truly stands at the stated receive angle plus this
    double out_of_plane_deg = 0;  ///< and this far beside the plane of incidence
    double saturation = 0;        ///< share of the set's peak where readings clip; 0: none
    double haze_share = 0;        ///< a second lobe of the same shape: its height over the first's
    double haze_width = 3;        ///< and its width over the first's
    double outlier_share = 0;     ///< readings that are wrong by up to the whole peak
    bool state_sigma = false;     ///< write the noise into the file as sigma
    std::uint64_t seed = 1;
};

/// The part's lobe of the material (ji, or ha for hamon) as a goniometer would see it. Every option
/// is checked. Cost: a tenth of a second for protocol (b) with one wavelength, seconds with whole
/// spectra. Throws InputError.
[[nodiscard]] ScanSet simulate_scan(const Material& material, ScanPart part,
                                    const SimulationOptions& options, unsigned threads = 0);

}  // namespace togishi
