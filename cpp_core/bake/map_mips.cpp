#include "bake/map_mips.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "bake/lobe_lanes.hpp"
#include "bake/mip_taps.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "blade/part.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

// A lobe that is nowhere present still has a mean; beside any real share this one vanishes.
constexpr float least_share = 1.0e-12F;
// The same for h; larger, because what it is compared with, 1 - w, is no finer than 6e-8.
constexpr float least_rest = 1.0e-6F;
constexpr std::size_t max_size = 65536;

// What averages linearly. "Sums" because each moment is multiplied by its lobe's share.
enum Sum : std::size_t {
    mean_w,
    hadori_share,
    ji_share,
    ji_xx,
    ji_xy,
    ji_yy,
    ha_share,
    ha_xx,
    ha_xy,
    ha_yy,
    sum_count
};

struct LobeChannels {
    MapChannel ln_mu, e1, e2;
    Sum share, xx, xy, yy;
};
constexpr std::array<LobeChannels, 2> lobe_channels{
    {{MapChannel::ji_ln_mu_deg, MapChannel::ji_e1, MapChannel::ji_e2, ji_share, ji_xx, ji_xy,
      ji_yy},
     {MapChannel::ha_ln_mu_deg, MapChannel::ha_e1, MapChannel::ha_e2, ha_share, ha_xx, ha_xy,
      ha_yy}}};

// What of a lobe has to be averaged at all.
enum class LobeKind {
    constant,  // nothing
    sized,     // mu varies, the shape is one: xx stands for the common factor
    shaped,    // all three moments
};

struct Plan {
    std::array<LobeKind, 2> kind{};
    bool w_varies = false;
    bool h_varies = false;
    bool part_varies = false;
    std::array<bool, sum_count> used{};
};

bool varies(const ChannelView& view) {
    return view.present() && !view.constant();
}

Plan plan_of(const MapView& map) {
    Plan plan;
    plan.w_varies = varies(map[MapChannel::w]);
    plan.h_varies = varies(map[MapChannel::h]);
    plan.part_varies = varies(map[MapChannel::part]);
    plan.used[mean_w] = true;
    plan.used[hadori_share] = plan.h_varies;
    for (std::size_t i = 0; i < 2; ++i) {
        const LobeChannels& c = lobe_channels[i];
        const bool shaped = varies(map[c.e1]) || varies(map[c.e2]);
        plan.kind[i] = shaped                 ? LobeKind::shaped
                       : varies(map[c.ln_mu]) ? LobeKind::sized
                                              : LobeKind::constant;
        plan.used[c.share] = plan.used[c.xx] = plan.kind[i] != LobeKind::constant;
        plan.used[c.xy] = plan.used[c.yy] = shaped;
    }
    return plan;
}

// The sums of one level, one plane each.
struct Sums {
    std::size_t width = 0, height = 0;
    std::array<std::vector<float>, sum_count> planes;
    std::vector<float> part;
};

// One row of sums, from the map (level 0) or from the planes of a level.
using Rows = std::array<std::vector<float>, sum_count>;

// A row of one channel without gaps; zeros where the channel is absent.
const float* gather(const ChannelView& view, std::size_t first, std::vector<float>& room) {
    if (view.texel_stride == 1) return view.data + first;
    if (!view.present()) {
        std::fill(room.begin(), room.end(), 0.0F);
    } else {
        const float* from = view.data + view.texel_stride * first;
        for (std::size_t x = 0; x < room.size(); ++x) room[x] = from[view.texel_stride * x];
    }
    return room.data();
}

// The loops below are written for vector code: plain pointers, no calls that are not inlined, no
// branches.
void decode_sized(const float* __restrict ln_mu, const float* __restrict share, std::size_t count,
                  float* __restrict xx) {
    const lanes::LobeShape round = lanes::lobe_shape(0.0F, 0.0F);
    for (std::size_t x = 0; x < count; ++x) {
        xx[x] =
            share[x] * lanes::lobe_moments(lanes::sanitise_lobe({ln_mu[x], 0.0F, 0.0F}), round).xx;
    }
}

void decode_shaped(const float* __restrict ln_mu, const float* __restrict e1,
                   const float* __restrict e2, const float* __restrict share, std::size_t count,
                   float* __restrict xx, float* __restrict xy, float* __restrict yy) {
    for (std::size_t x = 0; x < count; ++x) {
        const lanes::Lobe valid = lanes::sanitise_lobe({ln_mu[x], e1[x], e2[x]});
        const lanes::LobeMoments m =
            lanes::lobe_moments(valid, lanes::lobe_shape(valid.e1, valid.e2));
        xx[x] = share[x] * m.xx;
        xy[x] = share[x] * m.xy;
        yy[x] = share[x] * m.yy;
    }
}

void decode_shares(const float* __restrict w_row, const float* __restrict h_row, std::size_t count,
                   float* __restrict mean, float* __restrict hadori, float* __restrict ji,
                   float* __restrict ha) {
    for (std::size_t x = 0; x < count; ++x) {
        const float w = f32::sanitise_share(w_row[x]);
        const float h = f32::sanitise_share(h_row[x]);
        mean[x] = w;
        hadori[x] = std::max(1.0F - w, least_rest) * h;
        ji[x] = std::max((1.0F - w) * (1.0F - h), least_share);
        ha[x] = std::max(w, least_share);
    }
}

void add_row(const float* from, float weight, bool first, std::size_t width, float* to) {
    if (first) {
        for (std::size_t x = 0; x < width; ++x) to[x] = weight * from[x];
    } else {
        for (std::size_t x = 0; x < width; ++x) to[x] += weight * from[x];
    }
}

void shrink_row(const std::vector<float>& wide, std::size_t width, float* narrow) {
    const std::size_t half = coarser_size(width);
    if (width > 1 && width % 2 == 0) {
        for (std::size_t x = 0; x < half; ++x) narrow[x] = 0.5F * (wide[2 * x] + wide[2 * x + 1]);
        return;
    }
    for (std::size_t x = 0; x < half; ++x) {
        const MipTaps taps = mip_taps(x, width);
        float sum = 0.0F;
        for (std::size_t k = 0; k < taps.count; ++k) sum += taps.weight[k] * wide[taps.first + k];
        narrow[x] = sum;
    }
}

// The part of most area among the texels below; `part_at` reads one of them.
template <class PartAt>
float majority(const MipTaps& across, const MipTaps& up, PartAt&& part_at) {
    std::array<float, TG_PART_COUNT> area{};
    for (std::size_t j = 0; j < up.count; ++j) {
        for (std::size_t i = 0; i < across.count; ++i) {
            const float part = part_at(across.first + i, up.first + j);
            const bool known = part > 0.0F && part < TG_PART_COUNT;
            area[known ? static_cast<std::size_t>(part) : 0] += across.weight[i] * up.weight[j];
        }
    }
    // A hair more, so that rounding of the weights does not decide between equals.
    std::size_t most = 0;
    for (std::size_t part = 1; part < area.size(); ++part) {
        if (area[part] > area[most] + 1.0e-6F) most = part;
    }
    return static_cast<float>(most);
}

// One level from the one below. `row_of(y, rows, plane)` gives the row of a sum, decoding where
// needed.
template <class RowsOf, class PartAt>
Sums shrink(const Plan& plan, std::size_t width, std::size_t height, unsigned threads,
            RowsOf&& rows_of, PartAt&& part_at) {
    Sums sums;
    sums.width = coarser_size(width);
    sums.height = coarser_size(height);
    for (std::size_t s = 0; s < sum_count; ++s) {
        if (plan.used[s]) sums.planes[s].resize(sums.width * sums.height);
    }
    if (plan.part_varies) sums.part.resize(sums.width * sums.height);
    const std::size_t rows_per_range = std::max<std::size_t>(1, 32768 / width);
    parallel_for(
        sums.height, rows_per_range,
        [&](std::size_t begin, std::size_t end) {
            Rows added;
            for (auto& row : added) row.resize(width);
            auto source = rows_of();
            for (std::size_t y = begin; y < end; ++y) {
                const MipTaps up = mip_taps(y, height);
                for (std::size_t k = 0; k < up.count; ++k) {
                    source.read(up.first + k);
                    for (std::size_t s = 0; s < sum_count; ++s) {
                        if (!plan.used[s]) continue;
                        add_row(source.row(s), up.weight[k], k == 0, width, added[s].data());
                    }
                }
                for (std::size_t s = 0; s < sum_count; ++s) {
                    if (plan.used[s])
                        shrink_row(added[s], width, sums.planes[s].data() + y * sums.width);
                }
                for (std::size_t x = 0; plan.part_varies && x < sums.width; ++x) {
                    sums.part[y * sums.width + x] = majority(mip_taps(x, width), up, part_at);
                }
            }
        },
        threads);
    return sums;
}

struct MapRows {
    const MapView& map;
    const Plan& plan;
    Rows rows;
    std::array<std::vector<float>, 3> room;

    MapRows(const MapView& m, const Plan& p) : map(m), plan(p) {
        for (auto& row : rows) row.resize(map.width);
        for (auto& row : room) row.resize(map.width);
    }
    void read(std::size_t y) {
        const std::size_t first = y * map.width;
        decode_shares(gather(map[MapChannel::w], first, room[0]),
                      gather(map[MapChannel::h], first, room[1]), map.width, rows[mean_w].data(),
                      rows[hadori_share].data(), rows[ji_share].data(), rows[ha_share].data());
        for (std::size_t lobe = 0; lobe < 2; ++lobe) {
            if (plan.kind[lobe] == LobeKind::constant) continue;
            const LobeChannels& c = lobe_channels[lobe];
            const float* ln_mu = gather(map[c.ln_mu], first, room[0]);
            const float* share = rows[c.share].data();
            if (plan.kind[lobe] == LobeKind::sized) {
                decode_sized(ln_mu, share, map.width, rows[c.xx].data());
            } else {
                decode_shaped(ln_mu, gather(map[c.e1], first, room[1]),
                              gather(map[c.e2], first, room[2]), share, map.width,
                              rows[c.xx].data(), rows[c.xy].data(), rows[c.yy].data());
            }
        }
    }
    [[nodiscard]] const float* row(std::size_t s) const { return rows[s].data(); }
};

struct SumRows {
    const Sums& sums;
    std::size_t y = 0;
    void read(std::size_t row) { y = row; }
    [[nodiscard]] const float* row(std::size_t s) const {
        return sums.planes[s].data() + y * sums.width;
    }
};

void encode_sized(const float* __restrict share, const float* __restrict xx, std::size_t count,
                  float* __restrict ln_mu) {
    for (std::size_t i = 0; i < count; ++i) {
        const float mu2 = xx[i] / share[i];
        ln_mu[i] = lanes::lobe_from_moments({mu2, 0.0F, mu2}).ln_mu_deg;
    }
}

void encode_shaped(const float* __restrict share, const float* __restrict xx,
                   const float* __restrict xy, const float* __restrict yy, std::size_t count,
                   float* __restrict ln_mu, float* __restrict e1, float* __restrict e2) {
    for (std::size_t i = 0; i < count; ++i) {
        const float scale = 1.0F / share[i];
        const lanes::Lobe mixed =
            lanes::lobe_from_moments({scale * xx[i], scale * xy[i], scale * yy[i]});
        ln_mu[i] = mixed.ln_mu_deg;
        e1[i] = mixed.e1;
        e2[i] = mixed.e2;
    }
}

void encode_lobe(const MapView& map, const Plan& plan, const Sums& sums, std::size_t lobe,
                 std::size_t begin, std::size_t end, PropertyMaps& level) {
    if (plan.kind[lobe] == LobeKind::constant) return;
    const LobeChannels& c = lobe_channels[lobe];
    const auto from = [&](Sum s) { return sums.planes[s].data() + begin; };
    float* ln_mu = level[c.ln_mu].data() + begin;
    const std::size_t count = end - begin;
    if (plan.kind[lobe] == LobeKind::sized) {
        encode_sized(from(c.share), from(c.xx), count, ln_mu);
        return;
    }
    std::vector<float> unwanted;  // of two shape channels a map may have one
    const auto to = [&](MapChannel channel) {
        if (map.present(channel)) return level[channel].data() + begin;
        unwanted.resize(count);
        return unwanted.data();
    };
    encode_shaped(from(c.share), from(c.xx), from(c.xy), from(c.yy), count, ln_mu, to(c.e1),
                  to(c.e2));
}

PropertyMaps encode(const MapView& map, const Plan& plan, const Sums& sums, unsigned threads) {
    PropertyMaps level;
    level.width = sums.width;
    level.height = sums.height;
    const std::size_t count = sums.width * sums.height;
    const auto prepare = [&](MapChannel c, bool plane) {
        if (map.present(c)) level[c].assign(plane ? count : 1, plane ? 0.0F : map.at(c, 0, 0));
    };
    prepare(MapChannel::w, plan.w_varies);
    prepare(MapChannel::h, plan.h_varies);
    prepare(MapChannel::part, plan.part_varies);
    for (std::size_t lobe = 0; lobe < 2; ++lobe) {
        const LobeChannels& c = lobe_channels[lobe];
        prepare(c.ln_mu, plan.kind[lobe] != LobeKind::constant);
        prepare(c.e1, plan.kind[lobe] == LobeKind::shaped);
        prepare(c.e2, plan.kind[lobe] == LobeKind::shaped);
    }
    parallel_for(
        count, 16384,
        [&](std::size_t begin, std::size_t end) {
            const float* w = sums.planes[mean_w].data();
            if (plan.w_varies) std::copy(w + begin, w + end, level[MapChannel::w].data() + begin);
            if (plan.h_varies) {
                const float* hadori = sums.planes[hadori_share].data();
                float* h = level[MapChannel::h].data();
                for (std::size_t i = begin; i < end; ++i) {
                    h[i] = std::min(hadori[i] / std::max(1.0F - w[i], least_rest), 1.0F);
                }
            }
            for (std::size_t lobe = 0; lobe < 2; ++lobe)
                encode_lobe(map, plan, sums, lobe, begin, end, level);
        },
        threads);
    if (plan.part_varies) level[MapChannel::part] = sums.part;
    return level;
}

void check(const MapView& map) {
    const std::string size = std::to_string(map.width) + " x " + std::to_string(map.height);
    if (map.width == 0 || map.height == 0 || map.width > max_size || map.height > max_size) {
        throw InputError("property maps", "size", size, "1 to 65536 texels either way");
    }
    for (const MapChannel c : {MapChannel::ji_ln_mu_deg, MapChannel::ha_ln_mu_deg, MapChannel::w}) {
        if (!map.present(c)) {
            throw InputError("property maps",
                             std::string(map_channel_names[static_cast<std::size_t>(c)]), "missing",
                             "at least ji.ln_mu_deg, ha.ln_mu_deg and w");
        }
    }
}

}  // namespace

std::vector<PropertyMaps> coarser_levels(const MapView& map, unsigned threads) {
    check(map);
    std::vector<PropertyMaps> levels;
    if (map.width == 1 && map.height == 1) return levels;
    const Plan plan = plan_of(map);
    Sums sums = shrink(
        plan, map.width, map.height, threads, [&] { return MapRows(map, plan); },
        [&](std::size_t x, std::size_t y) { return map.at(MapChannel::part, x, y); });
    levels.push_back(encode(map, plan, sums, threads));
    while (sums.width > 1 || sums.height > 1) {
        sums = shrink(
            plan, sums.width, sums.height, threads, [&] { return SumRows{sums}; },
            [&](std::size_t x, std::size_t y) { return sums.part[y * sums.width + x]; });
        levels.push_back(encode(map, plan, sums, threads));
    }
    return levels;
}

}  // namespace togishi
