#include "steel/steel_pattern.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "steel/hada.hpp"
#include "steel/hadori.hpp"
#include "steel/nie.hpp"
#include "steel/nioiguchi.hpp"
#include "steel/quench.hpp"
#include "steel/strokes.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295;
constexpr double largest_sample_mm = 0.35;  // coarser texels are averaged from samples of this size
constexpr float hada_at_full_strength = 0.15F;
constexpr float ha_share = 0.8F;  // the ha behind the line is not all martensite crystals

f32::Lobe encoded(const char* name, const MaterialLobe& lobe) {
    const auto check = [&](const char* field, double x, bool ok, const char* allowed) {
        if (!ok)
            throw InputError("steel pattern", std::string(name) + "." + field, std::to_string(x),
                             allowed);
    };
    check("mu_t_deg", lobe.mu_t_deg, lobe.mu_t_deg > 0.0 && lobe.mu_t_deg < 90.0,
          "above 0, below 90 degrees");
    check("mu_b_deg", lobe.mu_b_deg, lobe.mu_b_deg > 0.0 && lobe.mu_b_deg < 90.0,
          "above 0, below 90 degrees");
    check("rho_deg", lobe.rho_deg, std::isfinite(lobe.rho_deg), "a finite angle in degrees");
    const f64::Lobe l = f64::lobe_from_mu(lobe.mu_t_deg * rad_per_deg, lobe.mu_b_deg * rad_per_deg,
                                          lobe.rho_deg * rad_per_deg);
    f32::Lobe out;
    out.ln_mu_deg = static_cast<float>(l.ln_mu_deg);
    out.e1 = static_cast<float>(l.e1);
    out.e2 = static_cast<float>(l.e2);
    return out;
}

/// One side of the blade, hardened and polished.
struct Side {
    QuenchedSide steel;
    Hadori hadori;

    Side(const SteelOutline& outline, const SteelParameters& p, bool omote, unsigned threads)
        : steel(make(outline, p, omote, threads)), hadori(outline, p, steel, omote) {}

    static QuenchedSide make(const SteelOutline& outline, const SteelParameters& p, bool omote,
                             unsigned threads) {
        const HamonLine line = draw_hamon(outline, p, omote);
        const Boshi boshi(outline, p, omote, threads);
        return quench(outline, p, lay_clay(outline, p, line, boshi, omote, threads), threads);
    }
};

/// Values of one sample or texel, in the order of MapChannel up to h.
using Sample = std::array<float, 8>;
enum At : std::size_t { ji_ln, ji_e1, ji_e2, ha_ln, ha_e1, ha_e2, at_w, at_h };

/// Evaluates single samples of the pattern.
class Sampler {
  public:
    Sampler(const BladeFrame& frame, const Material& material, const SteelParameters& p,
            unsigned threads)
        : frame_(frame),
          p_(p),
          outline_(frame),
          sides_(make_sides(outline_, p, threads)),
          hada_(p.hada, p.hada_scale, p.seed),
          seed_(static_cast<std::uint32_t>(p.seed * 0x9E3779B1U)),
          ji_(encoded("ji", material.ji)),
          shinogi_ji_(encoded("shinogi_ji", material.shinogi_ji)),
          mune_(encoded("mune", material.mune)),
          kissaki_(encoded("kissaki", material.kissaki)),
          ha_(encoded("ha", material.ha)),
          nakago_(encoded("nakago", material.nakago)) {}

    /// u, v of the sample's middle; footprint in mm. part: set where asked for.
    Sample at(double u, double v, float footprint_x, float footprint_y, Part& part) const {
        const ChartPoint point = frame_.locate(u, v);
        part = point.part;
        Sample out{};
        out[ha_ln] = ha_.ln_mu_deg;
        out[ha_e1] = ha_.e1;
        out[ha_e2] = ha_.e2;
        if (point.s_mm < 0.0 || point.part == Part::nakago) {
            set_ji(out, nakago_);
            return out;
        }
        const double s = point.s_mm;
        // Beside the outline the edge's values go on, so that nothing foreign is filtered in.
        const double r = std::min(point.from_ridge_mm, outline_.edge(s));
        const double q = outline_.straight_edge(s) - r;
        const double x = u * frame_.length_mm();
        const double y = (point.omote ? -1.0 : 1.0) * frame_.chart_y_mm(s, r);
        const bool in_kissaki = s > outline_.kissaki_s() && outline_.has_yokote();
        const bool on_mune = r < outline_.mune(s);
        const bool on_shinogi_ji = !on_mune && r < outline_.shinogi(s);

        const HadaSample hada = hada_.at(x, y, footprint_x, footprint_y);
        const float strength = hada_at_full_strength * static_cast<float>(p_.hada_strength);
        // Lines that run aslant over the texels are blended in, or they would show as stair steps.
        f32::Lobe polish = ji_;
        float hada_share = 1.0F;
        const auto lay_on = [&](const f32::Lobe& other, float hada_of_other, double inside_mm,
                                float footprint_mm) {
            const float share = covered(inside_mm, footprint_mm);
            polish.ln_mu_deg += share * (other.ln_mu_deg - polish.ln_mu_deg);
            polish.e1 += share * (other.e1 - polish.e1);
            polish.e2 += share * (other.e2 - polish.e2);
            hada_share += share * (hada_of_other - hada_share);
        };
        if (outline_.has_yokote()) lay_on(kissaki_, 0.5F, s - outline_.kissaki_s(), footprint_x);
        if (outline_.shinogi(s) > outline_.mune(s))
            lay_on(shinogi_ji_, 0.5F, outline_.shinogi(s) - r, footprint_y);
        lay_on(mune_, 0.35F, outline_.mune(s) - r, footprint_y);
        const float wander =
            stroke_wander_rad(x, y, p_.stroke_wander_deg, footprint_x, footprint_y, seed_ + 31U);
        const float turn =
            wander + 0.04F * static_cast<float>(p_.hada_strength) * hada_share * hada.tone;
        set_ji(out, turned(polish, turn));
        out[ji_ln] += strength * hada_share * hada.tone;

        const Side& side = sides_[point.omote ? 0 : 1];
        const float edge_fade = static_cast<float>(
            smooth_step(0.0, 1.0, point.part == Part::other ? 0.0 : point.from_edge_mm));
        harden(out, side, s, q, x, y, footprint_x, footprint_y, hada, edge_fade, point.omote);
        if (on_mune)
            out[at_w] *=
                static_cast<float>(smooth_step(0.0, 1.0, r / std::max(outline_.mune(s), 1e-3)));
        const f32::Lobe ha = turned(ha_, wander * edge_fade);
        out[ha_e1] = ha.e1;
        out[ha_e2] = ha.e2;

        if (!on_mune && !on_shinogi_ji) {
            out[at_h] = static_cast<float>(p_.hadori) * side.hadori.mask(s, q);
            if (p_.utsuri > 0.0 && !in_kissaki) out[ji_ln] += utsuri(side, s, q, x, y, point.omote);
        }
        if (part == Part::ji || part == Part::ha) part = out[at_w] > 0.5F ? Part::ha : Part::ji;
        if (part == Part::kissaki || part == Part::boshi)
            part = out[at_w] > 0.5F ? Part::boshi : Part::kissaki;
        return out;
    }

  private:
    /// Share of a sample on the inner side of a line that passes `inside_mm` from its middle.
    static float covered(double inside_mm, float footprint_mm) {
        return std::clamp(static_cast<float>(inside_mm) / footprint_mm + 0.5F, 0.0F, 1.0F);
    }

    static std::vector<Side> make_sides(const SteelOutline& outline, const SteelParameters& p,
                                        unsigned threads) {
        std::array<std::optional<Side>, 2> made;
        parallel_for(
            2, 1,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    made[i].emplace(outline, p, i == 0, threads);
            },
            threads);
        std::vector<Side> sides;
        sides.reserve(made.size());
        for (auto& side : made) sides.push_back(std::move(*side));
        return sides;
    }
    static void set_ji(Sample& out, const f32::Lobe& lobe) {
        out[ji_ln] = lobe.ln_mu_deg;
        out[ji_e1] = lobe.e1;
        out[ji_e2] = lobe.e2;
    }

    void harden(Sample& out, const Side& side, double s, double q, double x, double y,
                float footprint_x, float footprint_y, const HadaSample& hada, float edge_fade,
                bool omote) const {
        const FieldSample depth_field = side.steel.depth_mm.sample(s, q);
        if (depth_field.value < -3.9F) return;
        const auto seed = seed_ + (omote ? 100U : 200U);
        const auto nie = static_cast<float>(p_.nie);
        float depth = depth_field.value;
        // The line's own roughness: nie make it grainy, nioi leave it smooth.
        const float larger = std::max(footprint_x, footprint_y);
        depth += (0.05F + 0.05F * nie) * footprint_fade(larger / 1.6F) *
                 noise_value(x / 1.6, y / 1.1, seed);
        depth += (0.02F + 0.06F * nie) * footprint_fade(larger / 0.5F) *
                 noise_value(x / 0.5, y / 0.4, seed + 1);
        const float softness = std::max(0.5F, side.steel.softness.sample(s, q).value);
        const float slow = 1.0F + 0.16F * noise_value(x / 17.0, y / 6.0, seed + 2);
        float width = static_cast<float>(p_.nioiguchi_mm) * std::min(softness, 2.2F) * slow;
        // A line narrower than the footprint widens to it.
        const float span_s = depth_field.ds * footprint_x;
        const float span_q = depth_field.dq * footprint_y;
        width = std::sqrt(width * width + 0.3F * (span_s * span_s + span_q * span_q));
        Nioiguchi line = nioiguchi_at(depth, width, ha_share);
        line.glow *= edge_fade;

        const auto bright = static_cast<float>(p_.nioiguchi);
        const float inside = smooth_step(-0.1F, 0.3F, depth);
        float ln_mu = ha_.ln_mu_deg;
        ln_mu += hada_at_full_strength * static_cast<float>(p_.hada_strength) * 0.45F * edge_fade *
                 hada.tone;
        ln_mu += 0.05F * edge_fade * noise_value(x / 7.0, y / 2.6, seed + 3);
        // The line is finer than the material's ha, the ha behind it a little rougher.
        ln_mu += bright * (0.16F - 0.56F * line.glow);
        // Off the mirror direction roughness hardly shows (the lobe is at its widest there): the
        // grain and the
        // clouds within the ha are seen as more or less hardened steel.
        const float cloud = 0.05F * noise_value(x / 5.5, y / 1.9, seed + 8);
        const float grain_tone = 0.09F * static_cast<float>(p_.hada_strength) * hada.tone;
        float w = line.w * (1.0F - edge_fade * inside * (1.0F - line.glow) *
                                       std::clamp(0.04F + cloud + grain_tone, -0.2F, 0.3F));

        if (p_.sunagashi > 0.0 && depth > 0.05F && edge_fade > 0.0F) {
            // Swept sand: bundles of lines along the grain, in patches behind the line.
            const float span = hypotenuse(hada.ds * footprint_x, hada.dq * footprint_y);
            const float patch = smooth_step(0.3F, 1.4F, noise_value(x / 13.0, y / 1.7, seed + 4));
            const float zone = inside * edge_fade * std::exp(-std::max(depth - 0.5F, 0.0F) / 2.0F);
            const float amount = static_cast<float>(p_.sunagashi) * zone * patch;
            if (amount > 0.01F) {
                const float sand =
                    noise_1d(static_cast<double>(hada.layer) * 4.5 + y * 0.9, seed + 5) / 0.4F;
                const float grain = footprint_fade(span * 9.0F) * std::exp(-sand * sand);
                ln_mu -= 0.25F * amount * grain;
                w *= 1.0F - 0.22F * amount * (1.0F - grain);
                const float gold =
                    noise_1d(static_cast<double>(hada.layer) * 2.1 + 0.3 * y, seed + 6) / 0.09F;
                const float thread = footprint_fade(span * 12.0F) * std::exp(-gold * gold);
                ln_mu -= 0.4F * amount * thread;
                w += (1.0F - w) * amount * thread;
            }
        }
        if (p_.nie > 0.0) {
            const float t =
                (depth - 0.8F * width) / (depth < 0.8F * width ? 0.7F * width : 2.2F * width);
            const float band = 0.42F * std::exp(-t * t);
            const float within = 0.05F * inside * std::exp(-std::max(depth, 0.0F) / 2.5F);
            const float outside = depth < 0.0F ? 0.015F * std::exp(depth / 1.2F) : 0.0F;
            const float patch = 0.65F + 0.45F * noise_value(x / 5.0, y / 1.8, seed + 7);
            const float amount =
                nie * (band + within + outside) * std::clamp(patch, 0.1F, 1.8F) * edge_fade;
            if (amount > 0.002F) {
                const NieSample grains =
                    nie_grains(x, y, std::min(amount, 0.5F), footprint_x, footprint_y, seed + 50U);
                w += (1.0F - w) * grains.cover * (depth > 0.0F ? 0.5F : 0.75F);
                ln_mu += grains.ln_mu;
            }
        }
        out[at_w] = std::clamp(w, 0.0F, 1.0F);
        out[ha_ln] = ln_mu;
    }

    float utsuri(const Side& side, double s, double q, double x, double y, bool omote) const {
        const bool straight = p_.hamon == HamonStyle::suguha || p_.hamon == HamonStyle::notare;
        const auto seed = seed_ + (omote ? 300U : 400U);
        const double over = q - side.hadori.outline_q(s);
        const double ragged = straight ? 0.25 : 1.0;
        const double line = 2.4 + ragged * static_cast<double>(noise_value(
                                               x / (straight ? 25.0 : 6.5), y / 5.0, seed));
        const double start = smooth_step(15.0, 60.0, s);
        const double body =
            smooth_step(-0.7, 0.9, over - line) * std::exp(-std::max(over - line, 0.0) / 4.5);
        const float mist = std::max(0.0F, 0.75F + 0.3F * noise_value(x / 6.0, y / 2.2, seed + 1));
        return 0.4F * static_cast<float>(p_.utsuri * body * start) * mist;
    }

    const BladeFrame& frame_;
    const SteelParameters& p_;
    SteelOutline outline_;
    std::vector<Side> sides_;  // omote, ura
    Hada hada_;
    std::uint32_t seed_;
    f32::Lobe ji_;
    f32::Lobe shinogi_ji_;
    f32::Lobe mune_;
    f32::Lobe kissaki_;
    f32::Lobe ha_;
    f32::Lobe nakago_;
};

void report(const SteelProgress& progress, double done) {
    if (progress && !progress(done)) throw SteelCancelled();
}

/// A channel that holds one value everywhere is stored as that value.
void collapse(std::vector<float>& channel) {
    const float first = channel.front();
    if (std::all_of(channel.begin(), channel.end(), [&](float x) { return x == first; })) {
        channel.assign(1, first);
        channel.shrink_to_fit();
    }
}

}  // namespace

PropertyMaps steel_pattern(const BladeFrame& frame, const Material& material,
                           const SteelParameters& parameters, std::size_t width, std::size_t height,
                           const SteelProgress& progress, unsigned threads) {
    check_steel_parameters(parameters);
    constexpr std::size_t largest = 65536;
    if (width < 1 || width > largest) {
        throw InputError("steel pattern", "width", std::to_string(width), "1 to 65536 texels");
    }
    if (height < 1 || height > largest) {
        throw InputError("steel pattern", "height", std::to_string(height), "1 to 65536 texels");
    }
    report(progress, 0.0);
    const Sampler sampler(frame, material, parameters, threads);
    constexpr double quench_share = 0.3;
    report(progress, quench_share);

    PropertyMaps maps;
    maps.width = width;
    maps.height = height;
    for (auto& channel : maps.channels) channel.resize(width * height);

    const double texel_x = frame.length_mm() / static_cast<double>(width);
    const double texel_y = frame.chart_height_mm / static_cast<double>(height);
    const auto along = static_cast<std::size_t>(std::ceil(texel_x / largest_sample_mm));
    const auto up = static_cast<std::size_t>(std::ceil(texel_y / largest_sample_mm));
    const auto footprint_x = static_cast<float>(texel_x / static_cast<double>(along));
    const auto footprint_y = static_cast<float>(texel_y / static_cast<double>(up));
    const float per_sample = 1.0F / static_cast<float>(along * up);
    const auto row = [&](std::size_t y) {
        for (std::size_t x = 0; x < width; ++x) {
            Sample sum{};
            Part part = Part::other;
            for (std::size_t j = 0; j < up; ++j) {
                const double v = (static_cast<double>(y) +
                                  (static_cast<double>(j) + 0.5) / static_cast<double>(up)) /
                                 static_cast<double>(height);
                for (std::size_t i = 0; i < along; ++i) {
                    const double u = (static_cast<double>(x) +
                                      (static_cast<double>(i) + 0.5) / static_cast<double>(along)) /
                                     static_cast<double>(width);
                    Part here = Part::other;
                    const Sample sample = sampler.at(u, v, footprint_x, footprint_y, here);
                    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += sample[k];
                    if (j == up / 2 && i == along / 2) part = here;
                }
            }
            const std::size_t at = y * width + x;
            for (std::size_t k = 0; k < sum.size(); ++k) maps.channels[k][at] = sum[k] * per_sample;
            maps[MapChannel::part][at] = static_cast<float>(part);
        }
    };
    // Blocks of rows, so that progress is told from the caller's thread.
    const std::size_t block = std::max<std::size_t>(8, height / 32);
    for (std::size_t begin = 0; begin < height; begin += block) {
        const std::size_t rows = std::min(block, height - begin);
        parallel_for(
            rows, 1,
            [&](std::size_t first, std::size_t last) {
                for (std::size_t y = first; y < last; ++y) row(begin + y);
            },
            threads);
        report(progress, quench_share + (1.0 - quench_share) * static_cast<double>(begin + rows) /
                                            static_cast<double>(height));
    }
    for (auto& channel : maps.channels) collapse(channel);
    return maps;
}

}  // namespace togishi
