// Scan files: docs/measurement.md is the documentation for their writers.
//
//   # format: togishi-scan 1
//   # part: hamon                       ji | hamon
//   # quantity: radiance                radiance | flux | brdf
//   # calibration: absolute             absolute | relative | per_scan
//   # unit: 1/sr                        needed where absolute
//   # source_aperture_deg: 0.2          full angle
//   # detector_aperture_deg: 0.2
//   # turn_sense: counter-clockwise     seen from outside; needed where turn_deg is not 0
//   throughout # metal: iron_johnson_christy       may be missing: auto # light: D65 may be
//   missing; blade_axis_deg, saturation, name, instrument, date, note too
//   incidence_deg;receive_deg;turn_deg;azimuth_deg;intensity;sigma
//   45;44,8;0;0;1,234;0,006
//
// UTF-8 with or without byte order mark, any line ends, comments, rows in any order. Columns are
// told by their titles; separators are comma, semicolon or tab; with the last two, a decimal comma
// is read.
#pragma once
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scan/scan.hpp"

namespace togishi {

inline constexpr std::size_t scan_file_max_bytes = std::size_t{256} << 20U;
inline constexpr std::size_t scan_file_max_rows = 4'000'000;

/// Header keys given beside the file: they stand in for what it does not say. Keys as in its
/// header.
using ScanSettings = std::map<std::string, std::string, std::less<>>;

/// One file. Throws InputError with line and column for whatever is wrong in it.
[[nodiscard]] ScanSet parse_scans(std::string_view text, const std::string& where,
                                  const ScanSettings& settings = {});

/// Files from disk, joined by part (ji first): each set goes into one fit. Throws InputError, also
/// where files of one part disagree in unit, calibration, channels, metal or light.
[[nodiscard]] std::vector<ScanSet> read_scans(std::span<const std::filesystem::path> files,
                                              const ScanSettings& settings = {});

/// Text that parse_scans reads back as the same scans.
[[nodiscard]] std::string scans_to_text(const ScanSet& scans);

}  // namespace togishi
