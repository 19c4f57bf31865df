// A blade's outline as the steel pattern needs it: widths at any s, and an edge line that goes
// straight on where the fukura turns away, so that the hamon has one height axis over the whole
// blade.
#pragma once
#include "blade/frame.hpp"

namespace togishi {

/// All lengths in mm. s from the mune-machi; r: developed distance from the mune ridge;
/// q = straight_edge(s) - r: height over the straight edge line.
class SteelOutline {
  public:
    /// Throws InputError for a frame without length, or with fewer than two samples, or with NaN.
    explicit SteelOutline(const BladeFrame& frame);

    [[nodiscard]] double edge(double s) const { return frame_->at(frame_->edge_mm, s); }
    [[nodiscard]] double shinogi(double s) const { return frame_->at(frame_->shinogi_mm, s); }
    [[nodiscard]] double mune(double s) const { return frame_->at(frame_->mune_mm, s); }
    /// The edge line, continued beyond the kissaki's start by its own slope.
    [[nodiscard]] double straight_edge(double s) const;
    /// Width of a face at s against the width at the machi.
    [[nodiscard]] double relative_width(double s) const;
    /// Where the boshi begins: the yokote, or where a blade without one begins to narrow to its
    /// point.
    [[nodiscard]] double kissaki_s() const { return kissaki_s_; }
    [[nodiscard]] bool has_yokote() const { return has_yokote_; }
    [[nodiscard]] double nagasa() const { return frame_->nagasa_mm; }
    [[nodiscard]] const BladeFrame& frame() const { return *frame_; }

  private:
    const BladeFrame* frame_;
    double kissaki_s_ = 0;
    bool has_yokote_ = false;
    double edge_at_kissaki_ = 0;
    double edge_slope_ = 0;
};

}  // namespace togishi
