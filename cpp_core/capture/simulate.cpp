#include "capture/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random_normal.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180;
/// Half widths from a lobe's middle beyond which it is left out: 2^-20 of its peak.
constexpr double reach = 4.5;
constexpr std::array<double, 3> gauss_x{0.11270166537925831, 0.5, 0.88729833462074169};
constexpr std::array<double, 3> gauss_w{5.0 / 18, 8.0 / 18, 5.0 / 18};

struct LobeWidth {
    double wide_rad, narrow_rad;
};

struct Node {
    glm::dvec3 direction;
    double solid_angle;
};

// The source's pieces as one pixel needs them.
class Pieces {
  public:
    Pieces(const DiffuseSource& source, const glm::dvec3& point, const glm::dvec3& normal,
           const glm::dvec3& view, std::vector<LobeWidth> lobes, double piece)
        : source_(source),
          point_(point),
          normal_(normal),
          view_(view),
          lobes_(std::move(lobes)),
          piece_(piece) {}

    const std::vector<Node>& nodes() {
        // Two by two to begin with: corners and middle of a dome's one piece would coincide.
        for (int i = 0; i < 4; ++i)
            for (int k = 0; k < 4; ++k) divide(0.25 * i, 0.25 * k, 0.25, 2);
        return nodes_;
    }

  private:
    glm::dvec3 half_vector(double a, double b) const {
        return glm::normalize(source_.seen_from(point_, a, b).direction + view_);
    }
    void divide(double a, double b, double size, int depth) {
        const glm::dvec3 middle = half_vector(a + size / 2, b + size / 2);
        double extent = 0;
        for (const double i : {0.0, 1.0}) {
            for (const double k : {0.0, 1.0}) {
                extent = std::max(
                    extent,
                    std::acos(std::clamp(glm::dot(middle, half_vector(a + i * size, b + k * size)),
                                         -1.0, 1.0)));
            }
        }
        const double phi = std::acos(std::clamp(glm::dot(normal_, middle), -1.0, 1.0));
        const double nearest = std::max(phi - 1.2 * extent, 0.0);
        bool wanted = false;
        double largest = 6 * deg;  // for Fresnel's and the shadowing's sake
        for (const LobeWidth& lobe : lobes_) {
            if (nearest > reach * lobe.wide_rad) continue;
            wanted = true;
            largest = std::min(largest, piece_ * lobe.narrow_rad);
        }
        if (!wanted) return;
        constexpr int deepest = 12;
        if (2 * extent > largest && depth < deepest) {
            const double half = size / 2;
            divide(a, b, half, depth + 1);
            divide(a + half, b, half, depth + 1);
            divide(a, b + half, half, depth + 1);
            divide(a + half, b + half, half, depth + 1);
            return;
        }
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto seen =
                    source_.seen_from(point_, a + gauss_x[i] * size, b + gauss_x[k] * size);
                nodes_.push_back(
                    {seen.direction, seen.solid_angle * gauss_w[i] * gauss_w[k] * size * size});
            }
        }
    }

    const DiffuseSource& source_;
    glm::dvec3 point_, normal_, view_;
    std::vector<LobeWidth> lobes_;
    double piece_;
    std::vector<Node> nodes_;
};

StoredLobe stored(const PixelTruth& truth, std::size_t pixel, MapChannel first) {
    const auto c = static_cast<std::size_t>(first);
    const float* v = truth.values.data() + pixel * map_channel_count + c;
    return {v[0], v[1], v[2]};
}

LobeWidth width_of(const StoredLobe& lobe) {
    const auto axes = f64::lobe_axes({lobe[0], lobe[1], lobe[2]});
    return {axes.mu_t_rad, axes.mu_b_rad};
}

struct Lit {
    glm::dvec3 direction;
    double irradiance;
};

Lit light_at(const PointLight& light, const glm::dvec3& point) {
    if (!light.near) return {glm::normalize(light.direction), light.intensity};
    const glm::dvec3 to = light.position_mm - point;
    const double r2 = glm::dot(to, to);
    return {to / std::sqrt(r2), light.intensity * light.reference_mm * light.reference_mm / r2};
}

}  // namespace

PixelTruth maps_in_view(const SurfaceView& view, const PropertyMaps& maps) {
    PixelTruth truth;
    truth.values.assign(view.pixels() * map_channel_count, 0.0F);
    const auto w = static_cast<double>(maps.width), h = static_cast<double>(maps.height);
    parallel_for(view.pixels(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (view.seen[i] == 0) continue;
            const double x = std::clamp(view.uv[i].x * w - 0.5, 0.0, w - 1),
                         y = std::clamp(view.uv[i].y * h - 0.5, 0.0, h - 1);
            const auto x0 = static_cast<std::size_t>(x), y0 = static_cast<std::size_t>(y),
                       x1 = std::min(x0 + 1, maps.width - 1),
                       y1 = std::min(y0 + 1, maps.height - 1);
            const auto fx = static_cast<float>(x - static_cast<double>(x0)),
                       fy = static_cast<float>(y - static_cast<double>(y0));
            for (std::size_t c = 0; c < map_channel_count; ++c) {
                const auto channel = static_cast<MapChannel>(c);
                if (maps.channels[c].empty()) continue;
                float& out = truth.values[i * map_channel_count + c];
                if (channel == MapChannel::part) {
                    out = maps.at(channel, fx < 0.5F ? x0 : x1, fy < 0.5F ? y0 : y1);
                    continue;
                }
                out = (1 - fy) *
                          ((1 - fx) * maps.at(channel, x0, y0) + fx * maps.at(channel, x1, y0)) +
                      fy * ((1 - fx) * maps.at(channel, x0, y1) + fx * maps.at(channel, x1, y1));
            }
        }
    });
    return truth;
}

std::vector<double> reference_radiance(const SurfaceView& view, const PixelTruth& truth,
                                       const Illumination& illumination,
                                       const RadianceOptions& options) {
    if (truth.values.size() != view.pixels() * map_channel_count)
        throw InputError("reference_radiance", "truth", std::to_string(truth.values.size()),
                         "one value for each pixel and channel");
    std::vector<std::size_t> seen;
    for (std::size_t i = 0; i < view.pixels(); ++i)
        if (view.seen[i] != 0) seen.push_back(i);
    std::vector<double> radiance(view.pixels(), 0.0);
    const auto* source = std::get_if<DiffuseSource>(&illumination);
    if (source != nullptr) check_source(*source, "illumination");
    constexpr std::size_t chunk = 64;
    parallel_for(
        seen.size(), chunk,
        [&](std::size_t begin, std::size_t end) {
            const std::size_t n = end - begin;
            std::vector<std::vector<Node>> nodes(n);
            std::vector<glm::dvec3> normal(n), tangent(n), eye(n);
            std::vector<StoredLobe> ji(n), ha(n);
            std::vector<double> w(n), h(n);
            std::size_t most = 0;
            for (std::size_t k = 0; k < n; ++k) {
                const std::size_t i = seen[begin + k];
                normal[k] = glm::normalize(glm::dvec3(view.normal[i]));
                tangent[k] = glm::dvec3(view.tangent[i]);
                eye[k] = view.camera.view(view.position_mm[i]);
                ji[k] = stored(truth, i, MapChannel::ji_ln_mu_deg);
                ha[k] = stored(truth, i, MapChannel::ha_ln_mu_deg);
                w[k] = truth.at(i, MapChannel::w);
                h[k] = truth.at(i, MapChannel::h);
                if (source == nullptr) {
                    const Lit lit =
                        light_at(std::get<PointLight>(illumination), view.position_mm[i]);
                    nodes[k] = {{lit.direction, lit.irradiance}};
                } else {
                    std::vector<LobeWidth> lobes;
                    if ((1 - w[k]) * (1 - h[k]) > 0) lobes.push_back(width_of(ji[k]));
                    if ((1 - w[k]) * h[k] > 0) lobes.push_back(width_of(options.hadori));
                    if (w[k] > 0) lobes.push_back(width_of(ha[k]));
                    Pieces pieces(*source, view.position_mm[i], normal[k], eye[k], std::move(lobes),
                                  options.piece);
                    nodes[k] = pieces.nodes();
                }
                most = std::max(most, nodes[k].size());
            }
            if (most == 0) return;
            std::vector<glm::dvec3> direction(n * most, glm::dvec3(0, 1, 0));
            std::vector<double> irradiance(n * most, 0.0);
            for (std::size_t k = 0; k < n; ++k) {
                for (std::size_t j = 0; j < nodes[k].size(); ++j) {
                    direction[k * most + j] = nodes[k][j].direction;
                    irradiance[k * most + j] = nodes[k][j].solid_angle;
                }
            }
            const std::vector<std::int32_t> light_of(most, 0);
            ReferenceScene scene;
            scene.metal = options.metal;
            scene.lights = {options.light};
            scene.light_of = light_of;
            scene.normal = normal;
            scene.tangent = tangent;
            scene.view = eye;
            scene.light_direction = direction;
            scene.irradiance = irradiance;
            const std::array<StoredLobe, 1> hadori{options.hadori};
            scene.lobe_ji = {ji};
            scene.lobe_hadori = {hadori};
            scene.lobe_ha = {ha};
            scene.w = {w};
            scene.h = {h};
            const std::vector<glm::dvec3> xyz = reference_xyz(scene, 1);
            const double strength = source != nullptr ? source->radiance : 1;
            for (std::size_t k = 0; k < n; ++k) radiance[seen[begin + k]] = strength * xyz[k].y;
        },
        options.threads);
    return radiance;
}

std::vector<double> card_radiance(const SurfaceView& view, const Illumination& illumination) {
    std::vector<double> radiance(view.pixels(), 0.0);
    parallel_for(view.pixels(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (view.seen[i] == 0) continue;
            const glm::dvec3 n(view.normal[i]);
            if (const auto* source = std::get_if<DiffuseSource>(&illumination)) {
                radiance[i] =
                    source->radiance * source_irradiance(*source, view.position_mm[i], n) / pi;
            } else {
                const Lit lit = light_at(std::get<PointLight>(illumination), view.position_mm[i]);
                radiance[i] = lit.irradiance * std::max(glm::dot(lit.direction, n), 0.0) / pi;
            }
        }
    });
    return radiance;
}

std::vector<double> picture_against_light(const BladeMesh& mesh, const Camera& camera) {
    constexpr std::size_t rays = 3;
    Camera fine = camera;
    fine.width_px *= static_cast<int>(rays);
    fine.height_px *= static_cast<int>(rays);
    fine.scale *= static_cast<double>(rays);
    fine.centre_px *= static_cast<double>(rays);
    const std::vector<std::uint8_t> seen = view_of_mesh(mesh, fine).seen;
    const auto width = static_cast<std::size_t>(camera.width_px);
    std::vector<double> picture(width * static_cast<std::size_t>(camera.height_px), 0.0);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const std::size_t y = i / (rays * width), x = i - y * rays * width;
        if (seen[i] == 0) picture[y / rays * width + x / rays] += 1.0 / (rays * rays);
    }
    return picture;
}

void blur_picture(std::vector<double>& picture, int width, int height, double sigma_px) {
    if (!(sigma_px > 0)) return;
    const int radius = std::max(1, static_cast<int>(std::ceil(4 * sigma_px)));
    std::vector<double> weight(2 * static_cast<std::size_t>(radius) + 1);
    double sum = 0;
    for (std::size_t i = 0; i < weight.size(); ++i) {
        const double x = (static_cast<double>(i) - radius) / sigma_px;
        sum += weight[i] = std::exp(-0.5 * x * x);
    }
    for (double& v : weight) v /= sum;
    std::vector<double> turned(picture.size());
    // Twice the same: along the rows, written as columns.
    const auto pass = [&](const std::vector<double>& from, std::vector<double>& to, int w, int h) {
        for (int y = 0; y < h; ++y) {
            for (int x = 0; x < w; ++x) {
                double v = 0;
                int beside = x - radius;
                for (const double share : weight) {
                    const int at = std::clamp(beside++, 0, w - 1);
                    v += share * from[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) +
                                      static_cast<std::size_t>(at)];
                }
                to[static_cast<std::size_t>(x) * static_cast<std::size_t>(h) +
                   static_cast<std::size_t>(y)] = v;
            }
        }
    };
    pass(picture, turned, width, height);
    pass(turned, picture, height, width);
}

std::vector<float> expose(const std::vector<double>& radiance, int width, int height,
                          const SensorOptions& options, std::uint64_t frame) {
    if (radiance.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        throw InputError("expose", "radiance", std::to_string(radiance.size()), "width x height");
    std::vector<double> picture = radiance;
    blur_picture(picture, width, height, options.blur_px);
    std::vector<float> out(picture.size());
    RandomNormal random(options.seed * 0x2545f4914f6cdd1dU + frame);
    const double shot = options.snr > 0 ? 1 / options.snr : 0;
    const double levels = options.bits > 0 ? std::exp2(options.bits) - 1 : 0;
    const double diagonal2 =
        0.25 * (static_cast<double>(width) * width + static_cast<double>(height) * height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x);
            const double dx = x + 0.5 - width / 2.0, dy = y + 0.5 - height / 2.0;
            const double fall = 1 - options.vignetting * (dx * dx + dy * dy) / diagonal2;
            const double signal = picture[i] * options.scale * fall;
            double v = signal + options.dark;
            v += random.normal() *
                 std::sqrt(shot * shot * std::max(signal, 0.0) + options.read * options.read);
            v = std::clamp(v, 0.0, 1.0);
            if (levels > 0) v = std::round(v * levels) / levels;
            out[i] = static_cast<float>(v);
        }
    }
    return out;
}

PropertyMaps plate_maps(std::size_t width, std::size_t height, double mu_ji_deg, double mu_ha_deg,
                        double variation, std::uint64_t seed) {
    PropertyMaps maps;
    maps.width = width;
    maps.height = height;
    for (const MapChannel c :
         {MapChannel::ji_ln_mu_deg, MapChannel::ha_ln_mu_deg, MapChannel::w, MapChannel::part})
        maps[c].resize(width * height);
    // Smooth patches: a few waves of random direction, so that they are the same at any size.
    RandomNormal random(seed);
    constexpr int waves = 12;
    std::array<std::array<double, 4>, 2 * waves> wave{};
    for (auto& one : wave)
        one = {12 * (random.uniform() - 0.5), 12 * (random.uniform() - 0.5),
               2 * pi * random.uniform(), 0};
    const auto field = [&](std::size_t first, double u, double v) {
        double sum = 0;
        for (std::size_t k = first; k < first + waves; ++k)
            sum += std::sin(2 * pi * (wave[k][0] * u + wave[k][1] * v) + wave[k][2]);
        return sum * std::sqrt(2.0 / waves);
    };
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const double u = (static_cast<double>(x) + 0.5) / static_cast<double>(width),
                         v = (static_cast<double>(y) + 0.5) / static_cast<double>(height);
            const std::size_t i = y * width + x;
            // Ji for u < .3, ha from .45 to .65, then back by a slow slope.
            const double up = std::clamp((u - 0.3) / 0.15, 0.0, 1.0),
                         down = std::clamp((0.95 - u) / 0.3, 0.0, 1.0);
            const double w = std::min(up, down);
            maps[MapChannel::w][i] = static_cast<float>(w * w * (3 - 2 * w));
            maps[MapChannel::ji_ln_mu_deg][i] =
                static_cast<float>(std::log(mu_ji_deg) + variation * field(0, u, v));
            maps[MapChannel::ha_ln_mu_deg][i] =
                static_cast<float>(std::log(mu_ha_deg) + variation * field(waves, u, v));
            maps[MapChannel::part][i] = w > 0.5 ? TG_PART_HA : TG_PART_JI;
        }
    }
    return maps;
}

}  // namespace togishi
