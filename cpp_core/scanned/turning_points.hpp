// Where a blade begins, ends and changes: machi, tip, yokote, nakago's end.
#pragma once
#include <span>

#include "scanned/blade_fit.hpp"

namespace togishi {

/// Arc length of the blade's middle.
[[nodiscard]] double body_middle(const BladeFit& fit);

/// fit.machi_s_mm: where the wall of the notch in the mune ends, blade side. `points`: about it, by
/// s. Without tang nothing is searched.
void find_machi(std::span<const BladePoint> points, BladeFit& fit);
/// fit.tip_s_mm: where the point's edge, in which the two sides meet, runs into the mune line.
void find_tip(std::span<const BladePoint> points, BladeFit& fit);
/// fit.begin_s_mm: the end of the nakago, or of the scan.
void find_begin(std::span<const BladePoint> points, BladeFit& fit);
/// fit.nakago_mm.
void find_nakago_length(std::span<const ScanPoint> points, BladeFit& fit);
/// fit.yokote_s_mm: where the shinogi breaks before the point.
void find_yokote(BladeFit& fit);

}  // namespace togishi
