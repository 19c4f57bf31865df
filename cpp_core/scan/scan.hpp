// What a goniometer measured: intensity against receive angle, at some incidences and sample turns.
//
// Laboratory frame: z along the nominal normal of the sample, x in the plane of incidence. The
// light comes from (-sin theta_i, 0, cos theta_i), the detector stands at (sin theta_r cos a, sin
// theta_r sin a, cos theta_r): a receive angle is positive on the mirror's side, the azimuth a (0
// in the plane) leads out of it. The sample's T (machi to tip) lies at the azimuth turn,
// counter-clockwise seen from outside.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace togishi {

/// Which formula the part follows: ji (smooth, Fresnel of theta_i) or hamon (Torrance-Sparrow).
enum class ScanPart { ji, hamon };
/// What an intensity is, relative to the irradiance on a surface that faces the light.
enum class ScanQuantity {
    radiance,  ///< L/E
    flux,      ///< into a detector that sees the whole spot: L cos(theta_r)/E
    brdf       ///< L/(E cos(theta_i))
};
/// absolute: in 1/sr. relative: one unknown factor for all scans. per_scan: one for each.
enum class ScanCalibration { absolute, relative, per_scan };

inline constexpr std::array<std::string_view, 2> scan_part_names{"ji", "hamon"};
inline constexpr std::array<std::string_view, 3> scan_quantity_names{"radiance", "flux", "brdf"};
inline constexpr std::array<std::string_view, 3> scan_calibration_names{"absolute", "relative",
                                                                        "per_scan"};

/// What a column of intensities saw: the whole spectrum of the light through one of the eye's
/// functions (y: photopic; r, g, b: linear Rec.709), or one wavelength. Every channel is 1 for the
/// light itself.
struct ScanChannel {
    enum class Kind { y, x, z, r, g, b, wavelength };
    Kind kind = Kind::y;
    double wavelength_nm = 0;  ///< of Kind::wavelength
    std::string name;          ///< title of the column, e.g. "intensity_550nm"
    friend bool operator==(const ScanChannel&, const ScanChannel&) = default;
};

/// One row, all channels; NaN where a channel has no value there (a gap).
struct ScanRow {
    double receive_deg = 0;
    double azimuth_deg = 0;
    std::size_t line = 0;  ///< of the file, from 1; 0 where there is none
};

/// Rows that share an incidence and a turn, sorted by azimuth, then by receive angle.
struct Scan {
    std::string file;
    double incidence_deg = 0;
    double turn_deg = 0;            ///< counter-clockwise, blade axis included
    std::vector<ScanRow> rows;      ///< (N)
    std::vector<double> intensity;  ///< (N, C) row-major
    std::vector<double> sigma;      ///< (N, C), or empty: not stated
    ScanQuantity quantity = ScanQuantity::radiance;
    double source_aperture_deg = 0;  ///< full angle of a round source
    double detector_aperture_deg = 0;
    double saturation =
        std::numeric_limits<double>::infinity();  ///< readings from here on are clipped
};

struct ScanInput {
    std::string file;
    std::string sha256;  ///< of its bytes, hexadecimal
};

/// All scans of one part, to be fitted together.
struct ScanSet {
    ScanPart part = ScanPart::ji;
    ScanCalibration calibration = ScanCalibration::relative;
    std::string unit;   ///< "1/sr" where absolute, else as the file names it
    std::string metal;  ///< as find_metal takes it; "auto": to be chosen by the fit
    std::string light = "D65";
    std::string name;  ///< of the sample
    std::vector<ScanChannel> channels;
    std::vector<Scan> scans;
    std::vector<ScanInput> inputs;
    std::vector<std::string> notes;  ///< what a reader should know: gaps, repeated rows
    [[nodiscard]] std::size_t rows() const;
    /// Readings that are not gaps.
    [[nodiscard]] std::size_t readings() const;
};

}  // namespace togishi
