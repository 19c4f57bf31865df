#include "capture/tile_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <mutex>
#include <numbers>
#include <numeric>
#include <sstream>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/parallel.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr std::size_t channel_count = capture_channels.size();
constexpr double rad_per_deg = 0.017453292519943295769;
constexpr std::size_t blocks_across = cell_pixels / block_pixels;

void check(std::string_view field, double value, double least, double most,
           const std::string& allowed) {
    if (value >= least && value <= most) return;
    std::ostringstream text;
    text << value;
    throw InputError("capture lights", field, text.str(), allowed);
}

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Half vectors at the corners of a cell's 16-pixel squares, where lights or camera are near.
struct CellLights {
    RegionLights region;
    std::vector<RegionLights> nodes;  // (5, 5), empty: far
    [[nodiscard]] const RegionLights& node(std::size_t row, std::size_t column) const {
        return nodes[row * (blocks_across + 1) + column];
    }
};

CellLights cell_lights(const LightStack& stack, const glm::dvec3& normal, std::size_t x,
                       std::size_t y) {
    CellLights c;
    const double half = 0.5 * cell_pixels;
    const auto px = static_cast<double>(x), py = static_cast<double>(y);
    c.region = stack.region(normal, stack.place_mm(px + half, py + half));
    if (!stack.near()) return c;
    for (std::size_t row = 0; row <= blocks_across; ++row) {
        for (std::size_t column = 0; column <= blocks_across; ++column) {
            const double dx = static_cast<double>(column * block_pixels) - 0.5;
            const double dy = static_cast<double>(row * block_pixels) - 0.5;
            c.nodes.push_back(stack.region(normal, stack.place_mm(px + dx, py + dy)));
        }
    }
    return c;
}

// What the pixels of one block see: the cell's lights, or, near, their own.
struct BlockLights {
    std::vector<float> u, v, gain, diffuse;
    PixelLights view;

    void set(const CellLights& cell, std::size_t row, std::size_t block) {
        view = cell.region.view();
        if (cell.nodes.empty()) return;
        const std::size_t count = cell.region.u_deg.size();
        for (auto* plane : {&u, &v, &gain, &diffuse}) plane->resize(count * block_pixels);
        const std::size_t square = row / block_pixels;
        const float ty =
            (static_cast<float>(row % block_pixels) + 0.5F) / static_cast<float>(block_pixels);
        const RegionLights &a = cell.node(square, block), &b = cell.node(square, block + 1),
                           &c = cell.node(square + 1, block), &d = cell.node(square + 1, block + 1);
        for (std::size_t i = 0; i < count; ++i) {
            const bool lit = a.gain[i] > 0 && b.gain[i] > 0 && c.gain[i] > 0 && d.gain[i] > 0;
            for (std::size_t lane = 0; lane < block_pixels; ++lane) {
                const float tx =
                    (static_cast<float>(lane) + 0.5F) / static_cast<float>(block_pixels);
                const auto between = [&](const std::vector<float> RegionLights::*plane) {
                    const float left = (a.*plane)[i] + ty * ((c.*plane)[i] - (a.*plane)[i]);
                    const float right = (b.*plane)[i] + ty * ((d.*plane)[i] - (b.*plane)[i]);
                    return left + tx * (right - left);
                };
                const std::size_t at = i * block_pixels + lane;
                u[at] = lit ? between(&RegionLights::u_deg) : 1e3F;
                v[at] = lit ? between(&RegionLights::v_deg) : 1e3F;
                gain[at] = lit ? between(&RegionLights::gain) : 0.0F;
                diffuse[at] = lit ? between(&RegionLights::diffuse) : 0.0F;
            }
        }
        view.stride = block_pixels;
        view.u_deg = u.data();
        view.v_deg = v.data();
        view.gain = gain.data();
        view.diffuse = diffuse.data();
    }
};

std::array<float, channel_count> channels_of(const PixelResult& r) {
    return {r.normal.x,
            r.normal.y,
            r.normal.z,
            r.ln_mu_deg,
            r.e1,
            r.e2,
            r.weight,
            r.haze,
            r.diffuse,
            r.pedestal,
            r.sigma_ln_mu,
            r.sigma_rho_deg,
            r.sigma_normal_deg,
            r.sigma_ln_weight,
            r.chi2_reduced,
            r.used,
            r.clipped,
            r.rejected,
            static_cast<float>(r.flags)};
}

}  // namespace

// Pictures of some rows: (image, row, column).
struct StackRun::Band {
    std::size_t begin = 0, end = 0;
    std::vector<float> values;
    std::vector<std::uint8_t> clipped;
};

struct StackRun::Cell {
    std::size_t flagged = 0, inferred = 0, haze = 0, cells = 0;
    std::array<std::size_t, 7> reasons{};
    void add(const Cell& other) {
        flagged += other.flagged;
        inferred += other.inferred;
        haze += other.haze;
        cells += other.cells;
        for (std::size_t i = 0; i < reasons.size(); ++i) reasons[i] += other.reasons[i];
    }
};

StackRun::StackRun(const LightFile& lights, TileReader& reader, const StackRunOptions& options)
    : reader_(reader),
      options_(options),
      stack_(lights, options.stack,
             7 + (options.pedestal ? 1 : 0) + (options.haze_width > 0 ? 1 : 0)),
      sigma_h_deg_(0) {
    check("snr", options.snr, 1, 1e6, "1 to 1000000");
    check("read noise", options.read_noise, 0, 0.5, "0 to 0.5 of full scale");
    check("light error", options.stack.light_error_deg, 0, 20, "0 to 20 degrees");
    if (options.haze_width != 0)
        check("haze width", options.haze_width, 1.2, 20, "1.2 to 20 times the lobe's width");
    for (const double e : options.exposures) check("exposure", e, 1e-6, 1e6, "0.000001 to 1000000");
    if (options.band_rows % cell_pixels != 0) {
        throw InputError("capture lights", "band rows", std::to_string(options.band_rows),
                         "a multiple of " + std::to_string(cell_pixels));
    }
    if (options.prior) {
        const LobePrior& p = *options.prior;
        check("prior's half width", p.mu_b_deg, 0.06, p.mu_t_deg, "0.06 degrees to the wide one");
        check("prior's half width", p.mu_t_deg, p.mu_b_deg, 40, "the narrow one to 40 degrees");
        check("prior's sigma", p.sigma_ln_mu, 1e-3, 2, "0.001 to 2");
    }
    if (!(glm::dot(options.normal, options.normal) > 1e-12) ||
        !(glm::dot(options.normal, stack_.options().view) > 0)) {
        throw InputError("capture lights", "normal", "turned away from the camera",
                         "a direction on the camera's side");
    }
    options_.normal = glm::normalize(options.normal);
    const std::size_t expected = lights.lights.size() * options.exposures.size();
    if (reader.images() != expected) {
        throw InputError("capture lights", "pictures", std::to_string(reader.images()),
                         std::to_string(expected) + ", one a light and exposure");
    }
    // An exact direction would make a narrow lobe's residuals mean what no map between can hold.
    constexpr double least_sigma_deg = 0.003;
    sigma_h_deg_ = std::max(least_sigma_deg, stack_.sigma_h_deg());
    shortest_first_.resize(options.exposures.size());
    std::iota(shortest_first_.begin(), shortest_first_.end(), std::size_t{0});
    std::sort(shortest_first_.begin(), shortest_first_.end(), [&](std::size_t a, std::size_t b) {
        return options.exposures[a] < options.exposures[b];
    });
    std::ostringstream text;
    text.precision(17);
    for (const LightEntry& l : lights.lights) {
        text << l.image.string() << ' ' << l.direction.x << ' ' << l.direction.y << ' '
             << l.direction.z << ' ' << glm::length(l.position_mm) << ' ' << l.intensity << '\n';
    }
    lights_text_ = text.str();
}

StackReach StackRun::reach() const {
    return stack_.reach(options_.normal);
}

std::string StackRun::fingerprint() const {
    std::ostringstream t;
    t.precision(17);
    const StackRunOptions& o = options_;
    t << "lights 1 " << pixel_kernel().name << '\n'
      << lights_text_ << reader_.fingerprint() << '\n'
      << static_cast<int>(o.stack.model) << ' ' << o.stack.metal << ' ' << o.stack.light << ' '
      << o.stack.view.x << ' ' << o.stack.view.y << ' ' << o.stack.view.z << ' '
      << o.stack.camera_distance_mm << ' ' << o.stack.mm_per_pixel << ' ' << o.stack.origin_px.x
      << ' ' << o.stack.origin_px.y << ' ' << o.stack.light_error_deg << ' ' << o.normal.x << ' '
      << o.normal.y << ' ' << o.normal.z << ' ' << o.snr << ' ' << o.read_noise << ' ' << o.pedestal
      << ' ' << o.haze_width << ' ' << o.self_calibration << ' ' << static_cast<int>(o.effort);
    for (const double e : o.exposures) t << " e" << e;
    if (o.white) {
        t << " w" << o.white->left << ' ' << o.white->top << ' ' << o.white->width << ' '
          << o.white->height << ' ' << o.white->reflectance;
    }
    if (o.prior) {
        t << " p" << o.prior->mu_t_deg << ' ' << o.prior->mu_b_deg << ' ' << o.prior->rho_deg << ' '
          << o.prior->sigma_ln_mu;
    }
    return t.str();
}

std::size_t StackRun::rows_per_band() const {
    if (options_.band_rows > 0) return options_.band_rows;
    const std::size_t row = reader_.images() * reader_.width() * (sizeof(float) + 1);
    // Two at once: one is read while the other is fitted.
    const std::size_t cells =
        options_.memory_bytes / std::max<std::size_t>(1, 2 * row * cell_pixels);
    // Not fewer than one row of cells, and not so many that progress stands still.
    return cell_pixels * std::clamp<std::size_t>(cells, 1, 4);
}

PixelKernelOptions StackRun::kernel_options() const {
    PixelKernelOptions o;
    o.effort = options_.effort;
    o.pedestal = options_.pedestal;
    o.haze_width = static_cast<float>(options_.haze_width > 0 ? options_.haze_width : 3);
    o.noise_gain = static_cast<float>(1 / (options_.snr * options_.snr));
    o.noise_floor2 = static_cast<float>(std::max(
        1e-14, options_.read_noise * options_.read_noise + reader_.quantisation_variance()));
    o.sigma_h_deg = static_cast<float>(sigma_h_deg_);
    return o;
}

void StackRun::read_band(Band& band, std::size_t begin, std::size_t end) {
    const std::size_t width = reader_.width(), area = (end - begin) * width;
    band.begin = begin;
    band.end = end;
    band.values.resize(reader_.images() * area);
    band.clipped.resize(reader_.images() * area);
    parallel_for(
        reader_.images(), 1,
        [&](std::size_t image, std::size_t) {
            reader_.read(image, begin, end, band.values.data() + image * area,
                         band.clipped.data() + image * area);
        },
        options_.threads);
}

// 16 pixels from (x, row): each light by its longest exposure that is not clipped.
void StackRun::gather(const Band& band, std::size_t x, std::size_t row, float* value,
                      float* scale) const {
    const std::size_t width = reader_.width(), count = stack_.count();
    const std::size_t area = (band.end - band.begin) * width;
    const std::size_t at = (row - band.begin) * width + x;
    const std::size_t lanes = x < width ? std::min<std::size_t>(block_pixels, width - x) : 0;
    std::fill_n(value, count * block_pixels, 0.0F);
    std::fill_n(scale, count * block_pixels, 0.0F);
    for (const std::size_t e : shortest_first_) {
        const auto relative = static_cast<float>(options_.exposures[e]);
        const float to_first = 1 / relative;
        for (std::size_t i = 0; i < count; ++i) {
            const float* const found = &band.values[(e * count + i) * area + at];
            const std::uint8_t* const clipped = &band.clipped[(e * count + i) * area + at];
            float* const v = value + i * block_pixels;
            float* const s = scale + i * block_pixels;
            // No branch: the compiler takes the lanes side by side.
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const bool take =
                    (std::abs(found[lane]) < 1e30F) & ((clipped[lane] == 0) | (s[lane] == 0.0F));
                v[lane] = take ? found[lane] * to_first : v[lane];
                s[lane] = take ? (clipped[lane] == 0 ? to_first : -to_first) : s[lane];
            }
        }
    }
}

void StackRun::measure_white() {
    const WhitePatch& w = *options_.white;
    const std::size_t width = reader_.width(), height = reader_.height();
    if (w.width < 2 || w.height < 2 || w.left + w.width > width || w.top + w.height > height) {
        throw InputError("capture lights", "white patch",
                         std::to_string(w.left) + "," + std::to_string(w.top) + "," +
                             std::to_string(w.width) + "," + std::to_string(w.height),
                         "left,top,width,height of at least 2 x 2 pixels within " +
                             std::to_string(width) + " x " + std::to_string(height));
    }
    check("white patch's reflectance", w.reflectance, 0.01, 1, "0.01 to 1");
    Band band;
    read_band(band, w.top, w.top + w.height);
    const glm::dvec3 place =
        stack_.place_mm(static_cast<double>(w.left) + 0.5 * static_cast<double>(w.width),
                        static_cast<double>(w.top) + 0.5 * static_cast<double>(w.height));
    std::vector<float> value(stack_.count() * block_pixels), scale(value);
    std::vector<double> sum(stack_.count(), 0.0), good(sum), bad(sum);
    for (std::size_t row = w.top; row < w.top + w.height; ++row) {
        for (std::size_t x = w.left; x < w.left + w.width; x += block_pixels) {
            gather(band, x, row, value.data(), scale.data());
            const std::size_t lanes = std::min<std::size_t>(block_pixels, w.left + w.width - x);
            for (std::size_t i = 0; i < stack_.count(); ++i) {
                for (std::size_t lane = 0; lane < lanes; ++lane) {
                    const std::size_t at = i * block_pixels + lane;
                    (scale[at] > 0 ? good : bad)[i] += 1;
                    sum[i] += scale[at] > 0 ? double{value[at]} : 0.0;
                }
            }
        }
    }
    for (std::size_t i = 0; i < stack_.count(); ++i) {
        const std::string picture = stack_.light(i).image.string();
        constexpr double most_bad = 0.02;
        if (bad[i] > most_bad * (good[i] + bad[i])) {
            throw InputError(picture, "white patch", "clipped",
                             "a white reference below full scale in one of the exposures");
        }
        const double mean = sum[i] / good[i];
        if (!(mean > 1e-6)) {
            throw InputError(picture, "white patch", std::to_string(mean),
                             "a lit white reference, brighter than 0.000001 of full scale");
        }
        // It lies in the picture's plane.
        const double cosine = stack_.towards(i, place).z;
        stack_.set_irradiance(
            i, std::numbers::pi * mean / (w.reflectance * cosine * stack_.falloff(i, place)));
    }
}

void StackRun::calibrate(StackRunReport& report) {
    const std::size_t width = reader_.width(), height = reader_.height(), count = stack_.count();
    constexpr std::size_t most_rows = 32, most_across = 12;
    const std::size_t rows = std::min(most_rows, height);
    const std::size_t across =
        std::min(most_across, std::max<std::size_t>(1, width / block_pixels));
    SampleBlocks samples;
    samples.blocks = rows * across;
    samples.value.resize(samples.blocks * count * block_pixels);
    samples.scale.resize(samples.value.size());
    Band band;
    std::size_t b = 0;
    for (std::size_t r = 0; r < rows; ++r) {
        const std::size_t row = (2 * r + 1) * height / (2 * rows);
        read_band(band, row, row + 1);
        for (std::size_t k = 0; k < across; ++k, ++b) {
            const std::size_t x = (2 * k + 1) * width / (2 * across) / block_pixels * block_pixels;
            const std::size_t at = b * count * block_pixels;
            gather(band, x, row, samples.value.data() + at, samples.scale.data() + at);
        }
    }
    RegionLights region = stack_.region(options_.normal);
    const Calibration found =
        self_calibrate(region, samples, kernel_options(), 5, options_.threads);
    constexpr std::size_t least = 64;
    if (found.pixels < least) {
        throw InputError("capture lights", "self-calibration",
                         std::to_string(found.pixels) + " of " +
                             std::to_string(samples.blocks * block_pixels) +
                             " sampled pixels show a lobe",
                         "64 or more; without it, or with lights nearer to the mirror direction");
    }
    stack_.correct(options_.normal, found.offset_deg);
    sigma_h_deg_ = found.sigma_h_deg;
    shared_ = found.shared;
    report.calibration = found;
}

void StackRun::fit_cell(const Band& band, std::size_t x, std::size_t y, std::vector<float>& out,
                        Cell& counted) const {
    const std::size_t width = reader_.width(), count = stack_.count();
    const std::size_t right = std::min(x + cell_pixels, width);
    const std::size_t bottom = std::min(y + cell_pixels, band.end);
    const PixelKernel& kernel = pixel_kernel();
    PixelKernelOptions o = kernel_options();
    std::vector<float> value(count * block_pixels), scale(value), scratch(2 * value.size());
    BlockLights lights;
    PixelBlock block;

    // The cell's own normal: the middle one of a few of its pixels.
    CellLights cell = cell_lights(stack_, options_.normal, x, y);
    constexpr std::size_t sample_step = 16;
    const auto sampled = [&](const PixelKernelOptions& with, const auto& take) {
        for (std::size_t row = y + sample_step / 2; row < bottom; row += sample_step) {
            for (std::size_t left = x + (row / sample_step) % 2 * block_pixels; left < right;
                 left += 2 * block_pixels) {
                gather(band, left, row, value.data(), scale.data());
                lights.set(cell, row - y, (left - x) / block_pixels);
                kernel.fit(lights.view, {value.data(), scale.data()}, with, scratch.data(), block);
                for (std::size_t lane = 0; lane < block_pixels; ++lane)
                    take(pixel_result(block, lane, cell.region, with, shared_), lane);
            }
        }
    };
    constexpr std::size_t least_pixels = 8;
    std::vector<float> tilt_x, tilt_y;
    sampled(o, [&](const PixelResult& r, std::size_t lane) {
        if ((r.flags & unusable_flags) != 0) return;
        tilt_x.push_back(block.x[tilt_u][lane]);
        tilt_y.push_back(block.x[tilt_v][lane]);
    });
    if (tilt_x.size() >= least_pixels) {
        const double p = median(tilt_x) * rad_per_deg, q = median(tilt_y) * rad_per_deg;
        const double phi = std::hypot(p, q);
        if (phi > 1e-6) {
            const glm::dvec3 along = (p * cell.region.tangent + q * cell.region.bitangent) / phi;
            cell = cell_lights(
                stack_, glm::normalize(std::cos(phi) * cell.region.normal + std::sin(phi) * along),
                x, y);
        }
    }
    if (options_.haze_width > 0) {
        // By the cell, not by the pixel: without haze a pixel confuses the two lobes.
        std::vector<float> without, gained;
        sampled(o,
                [&](const PixelResult&, std::size_t lane) { without.push_back(block.chi2[lane]); });
        PixelKernelOptions hazy = o;
        hazy.haze = true;
        std::size_t i = 0;
        sampled(hazy, [&](const PixelResult& r, std::size_t lane) {
            const float before = without[i++];
            if (r.used > 0) gained.push_back(before - block.chi2[lane]);
        });
        constexpr float least_gain =
            4;  // chi^2, of the middle pixel: as ln(60) asks of one unknown
        o.haze = gained.size() >= least_pixels && median(gained) > least_gain;
        counted.haze += o.haze ? 1 : 0;
    }
    ++counted.cells;

    const std::size_t blocks = (right - x + block_pixels - 1) / block_pixels;
    std::vector<PixelResult> results((bottom - y) * blocks * block_pixels);
    std::size_t good = 0, pixels = 0;
    for (std::size_t row = y; row < bottom; ++row) {
        for (std::size_t b = 0; b < blocks; ++b) {
            gather(band, x + b * block_pixels, row, value.data(), scale.data());
            lights.set(cell, row - y, b);
            kernel.fit(lights.view, {value.data(), scale.data()}, o, scratch.data(), block);
            const std::size_t lanes =
                std::min<std::size_t>(block_pixels, right - x - b * block_pixels);
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                PixelResult& r = results[((row - y) * blocks + b) * block_pixels + lane];
                r = pixel_result(block, lane, cell.region, o, shared_);
                good += (r.flags & unusable_flags) == 0 ? 1 : 0;
                ++pixels;
            }
        }
    }
    // A prior helps where some of the region's pixels are good; elsewhere it would invent.
    if (options_.prior && 10 * good >= pixels) {
        const LobePrior& p = *options_.prior;
        const f64::Lobe lobe = f64::lobe_from_mu(p.mu_t_deg * rad_per_deg, p.mu_b_deg * rad_per_deg,
                                                 p.rho_deg * rad_per_deg);
        PixelKernelOptions known = o;
        known.prior_mean = {static_cast<float>(lobe.ln_mu_deg), static_cast<float>(lobe.e1),
                            static_cast<float>(lobe.e2)};
        known.prior_weight.fill(static_cast<float>(1 / (p.sigma_ln_mu * p.sigma_ln_mu)));
        for (std::size_t row = y; row < bottom; ++row) {
            for (std::size_t b = 0; b < blocks; ++b) {
                PixelResult* const r = &results[((row - y) * blocks + b) * block_pixels];
                constexpr int open = flag_uncertain | flag_few | flag_bounded;
                const std::size_t lanes =
                    std::min<std::size_t>(block_pixels, right - x - b * block_pixels);
                bool any = false;
                for (std::size_t lane = 0; lane < lanes; ++lane) any |= (r[lane].flags & open) != 0;
                if (!any) continue;
                gather(band, x + b * block_pixels, row, value.data(), scale.data());
                lights.set(cell, row - y, b);
                kernel.fit(lights.view, {value.data(), scale.data()}, known, scratch.data(), block);
                for (std::size_t lane = 0; lane < lanes; ++lane) {
                    if ((r[lane].flags & open) == 0 || (r[lane].flags & flag_missing) != 0)
                        continue;
                    PixelResult filled = pixel_result(block, lane, cell.region, known, shared_);
                    filled.flags &= ~flag_few;
                    if ((filled.flags & (unusable_flags | flag_inferred)) == flag_inferred)
                        r[lane] = filled;
                }
            }
        }
    }
    for (std::size_t row = y; row < bottom; ++row) {
        for (std::size_t column = x; column < right; ++column) {
            const PixelResult& r = results[(row - y) * blocks * block_pixels + column - x];
            counted.flagged += (r.flags & unusable_flags) != 0 ? 1 : 0;
            counted.inferred += (r.flags & flag_inferred) != 0 ? 1 : 0;
            for (std::size_t k = 0; k < counted.reasons.size(); ++k)
                counted.reasons[k] += (static_cast<unsigned>(r.flags) >> k) & 1U;
            auto values = channels_of(r);
            if ((r.flags & flag_missing) != 0) {
                // Nothing there: numbers that a reader can take, and the flag that says so.
                values.fill(0);
                values[2] = 1;
                values[channel_count - 1] = static_cast<float>(r.flags);
            }
            std::copy(values.begin(), values.end(),
                      out.begin() + static_cast<std::ptrdiff_t>(
                                        ((row - band.begin) * width + column) * channel_count));
        }
    }
}

TileStore StackRun::run(const std::filesystem::path& target, StackRunReport& report,
                        const StackProgress& progress) {
    const std::size_t width = reader_.width(), height = reader_.height();
    report.reach = reach();
    report.width = width;
    report.height = height;
    report.lights = stack_.count();
    report.pictures = reader_.images();
    report.instruction_set = pixel_kernel().name;
    TileStore store(target, fingerprint(), width, height, channel_count, rows_per_band());
    report.bands = store.bands();
    const std::size_t resumed = store.finished_bands();
    report.bands_resumed = resumed;
    Cell all;
    try {
        if (resumed < store.bands()) {
            if (options_.white) measure_white();
            if (options_.self_calibration) calibrate(report);
        }
        std::vector<std::size_t> open;
        for (std::size_t b = 0; b < store.bands(); ++b)
            if (!store.finished(b)) open.push_back(b);
        std::array<Band, 2> bands;
        std::array<std::vector<float>, 2> outs;
        // The next band is read and the last one written while one is fitted; in turns, where one
        // thread was asked for.
        const auto how = options_.threads == 1 ? std::launch::deferred : std::launch::async;
        std::future<double> reading;
        std::future<void> writing;
        const auto read_ahead = [&](std::size_t k) {
            if (k >= open.size()) return;
            const std::size_t begin = open[k] * store.band_rows();
            const std::size_t end = begin + store.rows_of(open[k]);
            reading = std::async(how, [this, begin, end, &band = bands[k % 2]] {
                const double start = seconds();
                read_band(band, begin, end);
                return seconds() - start;
            });
        };
        read_ahead(0);
        for (std::size_t k = 0; k < open.size(); ++k) {
            const Band& band = bands[k % 2];
            std::vector<float>& out = outs[k % 2];
            report.seconds_reading += reading.get();
            read_ahead(k + 1);
            const double start = seconds();
            out.resize((band.end - band.begin) * width * channel_count);
            const std::size_t across = (width + cell_pixels - 1) / cell_pixels;
            const std::size_t down = (band.end - band.begin + cell_pixels - 1) / cell_pixels;
            std::mutex lock;
            parallel_for(
                across * down, 1,
                [&](std::size_t i, std::size_t) {
                    if (options_.stop != nullptr && options_.stop->load()) throw StackStopped{};
                    Cell counted;
                    fit_cell(band, i % across * cell_pixels, band.begin + i / across * cell_pixels,
                             out, counted);
                    const std::scoped_lock hold(lock);
                    all.add(counted);
                },
                options_.threads);
            report.seconds_fitting += seconds() - start;
            if (writing.valid()) writing.get();
            writing = std::async(how, [&store, &out, b = open[k]] { store.write(b, out); });
            const std::size_t done = resumed + k + 1;
            if (progress && !progress(done, store.bands()) && done < store.bands())
                throw StackStopped{};
        }
        if (writing.valid()) writing.get();
    } catch (const StackStopped&) {
        const StackStopped stopped{store.finished_bands(), store.bands()};
        if (stopped.bands_done == 0) store.remove();  // nothing to go on from
        throw stopped;
    } catch (...) {
        if (store.finished_bands() == 0) store.remove();
        throw;
    }
    report.flagged = all.flagged;
    report.inferred = all.inferred;
    report.haze_cells = all.haze;
    report.cells = all.cells;
    report.reasons = all.reasons;
    return store;
}

}  // namespace togishi
