#include "steel/hada.hpp"

#include <algorithm>
#include <cmath>

#include "steel/noise.hpp"

namespace togishi {

Hada::Hada(HadaStyle style, double scale, std::uint64_t seed)
    : style_(style), scale_(scale), seed_(static_cast<std::uint32_t>(seed * 0x27D4EB2FU) + 4000U) {
    switch (style) {
        case HadaStyle::itame:
            cut_ = 0.6;
            warps_[0] = {1.0, 30.0, 5.5};
            warps_[1] = {0.36, 9.0, 2.1};
            warps_[2] = {0.1, 2.6, 0.8};
            layers_per_mm_ = 1.5;
            break;
        case HadaStyle::masame:
            cut_ = 1.0;
            warps_[0] = {0.8, 90.0, 12.0};
            warps_[1] = {0.14, 22.0, 4.0};
            warps_[2] = {0.03, 6.0, 1.0};
            layers_per_mm_ = 1.3;
            break;
        case HadaStyle::mokume:
            cut_ = 0.34;
            warps_[0] = {1.1, 24.0, 6.5};
            warps_[1] = {0.55, 6.5, 3.0};
            warps_[2] = {0.1, 2.4, 1.0};
            layers_per_mm_ = 1.6;
            break;
        case HadaStyle::ayasugi:
            cut_ = 1.0;
            warps_[0] = {0.6, 60.0, 10.0};
            warps_[1] = {0.15, 12.0, 3.0};
            warps_[2] = {0.04, 4.0, 1.0};
            wave_mm_ = 3.2;
            wave_length_mm_ = 55.0;
            layers_per_mm_ = 1.2;
            break;
        case HadaStyle::nashiji:
            cut_ = 0.35;
            warps_[0] = {0.9, 14.0, 4.5};
            warps_[1] = {0.4, 4.0, 1.6};
            warps_[2] = {0.16, 1.3, 0.6};
            layers_per_mm_ = 3.0;
            break;
        case HadaStyle::muji:
            layers_per_mm_ = 0;
            break;
    }
}

HadaSample Hada::at(double s, double y, float footprint_s, float footprint_y) const {
    HadaSample out;
    const double x = s / scale_;
    const double z = y / scale_;
    const auto fs = footprint_s / static_cast<float>(scale_);
    const auto fy = footprint_y / static_cast<float>(scale_);
    double layer = cut_ * z;
    float ds = 0;
    auto dy = static_cast<float>(cut_);
    for (std::uint32_t k = 0; k < 3; ++k) {
        const Warp& warp = warps_[k];
        if (warp.amplitude_mm <= 0.0) continue;
        const NoiseSample n = noise_2d(x / warp.length_mm, z / warp.height_mm, seed_ + k);
        layer += warp.amplitude_mm * n.value;
        ds += static_cast<float>(warp.amplitude_mm / warp.length_mm) * n.dx;
        dy += static_cast<float>(warp.amplitude_mm / warp.height_mm) * n.dy;
    }
    if (wave_mm_ > 0.0) {
        const double turn = 6.283185307179586 / wave_length_mm_;
        layer += wave_mm_ * std::sin(turn * x);
        ds += static_cast<float>(wave_mm_ * turn * std::cos(turn * x));
    }
    out.layer = static_cast<float>(layer);
    out.ds = ds / static_cast<float>(scale_);
    out.dq = dy / static_cast<float>(scale_);
    if (style_ == HadaStyle::muji) return out;

    // How many layers the footprint spans, per layer frequency.
    const float span = hypotenuse(ds * fs, dy * fy);
    const auto per_mm = static_cast<float>(layers_per_mm_);
    float tone = 0;
    // Bold layers are few, fine ones many; how visible each is changes over the blade.
    const float visible = 0.75F + 0.32F * noise_value(x / 9.0, z / 3.4, seed_ + 11);
    const float fine_visible = 0.7F + 0.35F * noise_value(x / 4.0, z / 2.0, seed_ + 12);
    tone += 0.55F * visible * footprint_fade(span * per_mm) *
            noise_1d(layer * layers_per_mm_, seed_ + 13);
    tone += 0.5F * fine_visible * footprint_fade(span * per_mm * 2.7F) *
            noise_1d(layer * layers_per_mm_ * 2.7 + 0.4 * x / 9.0, seed_ + 14);
    tone += 0.42F * footprint_fade(span * per_mm * 6.1F) *
            noise_1d(layer * layers_per_mm_ * 6.1 + x / 5.0, seed_ + 15);
    // Weld lines: narrow, dark, broken.
    const float weld = noise_1d(layer * layers_per_mm_ * 1.9, seed_ + 16) / 0.16F;
    tone += 1.1F * std::max(visible - 0.55F, 0.0F) * footprint_fade(span * per_mm * 6.0F) *
            (std::exp(-weld * weld) - 0.11F);
    // The steel's own fine texture, drawn out along the blade.
    tone += 0.3F * footprint_fade(hypotenuse(fs / 0.9F, fy / 0.16F)) *
            noise_value(x / 0.9, z / 0.16, seed_ + 17);
    out.tone = std::clamp(tone, -3.0F, 3.0F);
    return out;
}

}  // namespace togishi
