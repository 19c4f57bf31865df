#include "capture/project.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "bake/map_repair.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "brdf/model.hpp"

namespace togishi {
namespace {

// The blade's surface at each texel of its chart.
struct ChartSurface {
    std::vector<std::uint8_t> on;
    std::vector<glm::dvec3> position_mm;
    std::vector<glm::vec3> normal, tangent;
    std::vector<float> part;
};

ChartSurface chart_surface(const BladeMesh& mesh, std::size_t width, std::size_t height) {
    ChartSurface chart;
    const std::size_t n = width * height;
    chart.on.assign(n, 0);
    chart.position_mm.assign(n, glm::dvec3(0));
    chart.normal.assign(n, glm::vec3(0));
    chart.tangent.assign(n, glm::vec3(0));
    chart.part.assign(n, float(TG_PART_OTHER));
    const glm::dvec2 size(static_cast<double>(width), static_cast<double>(height));
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto first = static_cast<std::size_t>(mesh.face_start[f]);
        const auto end = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = first + 1; c + 1 < end; ++c) {
            const std::array<std::size_t, 3> corner{first, c, c + 1};
            std::array<glm::dvec2, 3> p{};
            for (std::size_t k = 0; k < 3; ++k)
                p[k] = glm::dvec2(mesh.corner_uv[corner[k]]) * size - 0.5;
            const glm::dvec2 low = glm::min(p[0], glm::min(p[1], p[2])),
                             high = glm::max(p[0], glm::max(p[1], p[2]));
            const auto bounded = [](double v, std::size_t most) {
                return static_cast<std::size_t>(std::clamp(v, 0.0, static_cast<double>(most) - 1));
            };
            const glm::dvec2 e1 = p[1] - p[0], e2 = p[2] - p[0];
            const double area = e1.x * e2.y - e1.y * e2.x;
            if (std::abs(area) < 1e-12) continue;
            for (std::size_t y = bounded(std::ceil(low.y), height);
                 y <= bounded(std::floor(high.y), height); ++y) {
                for (std::size_t x = bounded(std::ceil(low.x), width);
                     x <= bounded(std::floor(high.x), width); ++x) {
                    const glm::dvec2 d(static_cast<double>(x) - p[0].x,
                                       static_cast<double>(y) - p[0].y);
                    const double b1 = (d.x * e2.y - d.y * e2.x) / area,
                                 b2 = (e1.x * d.y - e1.y * d.x) / area, b0 = 1 - b1 - b2;
                    constexpr double slack = -1e-9;
                    if (!(b0 >= slack && b1 >= slack && b2 >= slack)) continue;
                    const std::size_t i = y * width + x;
                    const std::array<double, 3> b{b0, b1, b2};
                    glm::dvec3 position(0);
                    glm::vec3 normal(0), tangent(0);
                    for (std::size_t k = 0; k < 3; ++k) {
                        position += b[k] * mesh.positions_mm[static_cast<std::size_t>(
                                               mesh.corner_vertex[corner[k]])];
                        normal += static_cast<float>(b[k]) * mesh.corner_normal[corner[k]];
                        tangent += static_cast<float>(b[k]) * mesh.corner_tangent[corner[k]];
                    }
                    chart.on[i] = 1;
                    chart.position_mm[i] = position;
                    chart.normal[i] = glm::normalize(normal);
                    chart.tangent[i] = glm::normalize(
                        tangent - chart.normal[i] * glm::dot(chart.normal[i], tangent));
                    chart.part[i] = static_cast<float>(mesh.face_part[f]);
                }
            }
        }
    }
    return chart;
}

// Distance in pixels from each pixel to the nearest of `from`, by steps along rows, columns and
// diagonals, up to `most`.
std::vector<float> distance_from(const std::vector<std::uint8_t>& from, std::size_t width,
                                 std::size_t height, double most) {
    constexpr float diagonal = 1.41421356F;
    std::vector<float> distance(width * height);
    const auto at = [&](std::size_t x, std::size_t y) -> float& { return distance[y * width + x]; };
    for (std::size_t i = 0; i < distance.size(); ++i)
        distance[i] = from[i] != 0 ? 0.0F : static_cast<float>(most);
    const auto lower = [](float& v, float to) { v = std::min(v, to); };
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            float& v = at(x, y);
            if (x > 0) lower(v, at(x - 1, y) + 1);
            if (y > 0) lower(v, at(x, y - 1) + 1);
            if (x > 0 && y > 0) lower(v, at(x - 1, y - 1) + diagonal);
            if (x + 1 < width && y > 0) lower(v, at(x + 1, y - 1) + diagonal);
        }
    }
    for (std::size_t y = height; y-- > 0;) {
        for (std::size_t x = width; x-- > 0;) {
            float& v = at(x, y);
            if (x + 1 < width) lower(v, at(x + 1, y) + 1);
            if (y + 1 < height) lower(v, at(x, y + 1) + 1);
            if (x + 1 < width && y + 1 < height) lower(v, at(x + 1, y + 1) + diagonal);
            if (x > 0 && y + 1 < height) lower(v, at(x - 1, y + 1) + diagonal);
        }
    }
    return distance;
}

// Weight of each pixel, 0 where it cannot be used. Three fades, each by a distance of its own and
// multiplied: towards where the picture cuts the blade off, towards masked pixels, and a short one
// towards the outline. What all photographs share (the outline, what it masks) then leaves their
// ratio alone; by the least of the distances, a blade's narrowness would end every slow transition.
std::vector<float> fade_of(const SurfaceView& view, const std::vector<std::uint8_t>& masked_out,
                           double feather_px) {
    const auto width = static_cast<std::size_t>(view.camera.width_px),
               height = static_cast<std::size_t>(view.camera.height_px);
    const double most =
        feather_px > 0 ? feather_px : std::hypot(view.camera.width_px, view.camera.height_px);
    constexpr double hole_px = 24, outline_px = 2;
    std::vector<std::uint8_t> cut(view.pixels(), 0), outside(view.pixels(), 0);
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = y * width + x;
            const bool rim = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
            cut[i] = rim && view.seen[i] != 0 ? 1 : 0;
            outside[i] = view.seen[i] != 0 ? 0 : 1;
        }
    }
    const std::vector<float> to_cut = distance_from(cut, width, height, most),
                             to_hole = distance_from(masked_out, width, height, hole_px),
                             to_outside = distance_from(outside, width, height, outline_px);
    std::vector<float> fade(view.pixels());
    for (std::size_t i = 0; i < fade.size(); ++i) {
        const double cut_off = std::min((static_cast<double>(to_cut[i]) + 0.5) / most, 1.0);
        fade[i] = static_cast<float>(cut_off * to_hole[i] / hole_px * to_outside[i] / outline_px);
    }
    return fade;
}

struct Moments {
    double xx = 0, xy = 0, yy = 0, weight = 0;
    void add(const f64::LobeMoments& m, double by) {
        xx += by * m.xx;
        xy += by * m.xy;
        yy += by * m.yy;
        weight += by;
    }
    [[nodiscard]] f64::Lobe lobe() const {
        return f64::lobe_from_moments({xx / weight, xy / weight, yy / weight});
    }
};

struct Texel {
    // A lobe without any share keeps the plain mean, which stands in `plain`.
    Moments ji, ha, plain_ji, plain_ha;
    double w = 0, h = 0, h_weight = 0, weight = 0;
};

struct Photograph {
    const ProjectedMap* map = nullptr;
    SurfaceView view;
    std::vector<float> fade;
};

f64::LobeMoments moments_at(const PropertyMaps& maps, MapChannel first, std::size_t x,
                            std::size_t y, double cos2, double sin2) {
    const auto at = [&](int k) {
        const auto c = static_cast<MapChannel>(static_cast<int>(first) + k);
        return maps[c].empty() ? 0.0 : static_cast<double>(maps.at(c, x, y));
    };
    // Turning a lobe by an angle turns (e1, e2) by twice that.
    const double e1 = at(1), e2 = at(2);
    const f64::Lobe lobe =
        f64::sanitise_lobe({at(0), cos2 * e1 - sin2 * e2, sin2 * e1 + cos2 * e2});
    return f64::lobe_moments(lobe, f64::lobe_shape(lobe.e1, lobe.e2));
}

}  // namespace

ProjectResult project_maps(const BladeMesh& mesh, const std::vector<ProjectedMap>& photographs,
                           const ProjectOptions& options, const ProjectProgress& progress) {
    if (photographs.empty()) throw InputError("project", "photographs", "none", "one or more");
    if (options.width < 1 || options.height < 1 || options.width > 32768 || options.height > 32768)
        throw InputError("project", "size",
                         std::to_string(options.width) + " x " + std::to_string(options.height),
                         "1 to 32768 texels either way");
    if (!(options.feather_px >= 0 && options.feather_px < 1e6))
        throw InputError("project", "feather_px", std::to_string(options.feather_px),
                         "0 (the whole overlap) or pixels");
    std::vector<Photograph> all;
    all.reserve(photographs.size());
    for (std::size_t k = 0; k < photographs.size(); ++k) {
        const ProjectedMap& one = photographs[k];
        const auto width = static_cast<std::size_t>(one.camera.width_px),
                   height = static_cast<std::size_t>(one.camera.height_px);
        const std::string name = "photograph " + std::to_string(k + 1);
        if (one.maps.width != width || one.maps.height != height) {
            throw InputError(
                "project", name,
                std::to_string(one.maps.width) + " x " + std::to_string(one.maps.height) +
                    " pixels",
                std::to_string(width) + " x " + std::to_string(height) + ", as its camera");
        }
        if (!one.usable.empty() && one.usable.size() != width * height)
            throw InputError("project", name, std::to_string(one.usable.size()) + " mask values",
                             "one a pixel");
        for (const MapChannel c :
             {MapChannel::ji_ln_mu_deg, MapChannel::ha_ln_mu_deg, MapChannel::w}) {
            if (one.maps[c].empty())
                throw InputError("project", name,
                                 "without " + std::string(map_channel_names[std::size_t(c)]),
                                 "a property map");
        }
        Photograph photograph;
        photograph.map = &one;
        photograph.view = view_of_mesh(mesh, one.camera);
        std::vector<std::uint8_t> masked_out(photograph.view.pixels(), 0);
        for (std::size_t i = 0; i < one.usable.size(); ++i)
            masked_out[i] = photograph.view.seen[i] != 0 && one.usable[i] == 0 ? 1 : 0;
        photograph.fade = fade_of(photograph.view, masked_out, options.feather_px);
        all.push_back(std::move(photograph));
    }
    const ChartSurface chart = chart_surface(mesh, options.width, options.height);
    ProjectResult result;
    PropertyMaps& maps = result.maps;
    maps.width = options.width;
    maps.height = options.height;
    const std::size_t n = options.width * options.height;
    for (auto& plane : maps.channels) plane.assign(n, std::numeric_limits<float>::quiet_NaN());
    maps[MapChannel::part] = chart.part;
    result.coverage.assign(n, 0.0F);
    const double grazing = std::cos(options.grazing_deg * double(TG_RAD_PER_DEG));

    const auto texel_at = [&](std::size_t tx, std::size_t ty) {
        const std::size_t i = ty * options.width + tx;
        const glm::dvec3 point = chart.position_mm[i];
        const glm::dvec3 normal(chart.normal[i]), tangent(chart.tangent[i]);
        const glm::dvec3 bitangent = glm::cross(normal, tangent);
        // The texel's sides on the surface, by its neighbours.
        const auto neighbour = [&](std::size_t x, std::size_t y, double sign) {
            const std::size_t k = y * options.width + x;
            return x < options.width && y < options.height && chart.on[k] != 0
                       ? sign * (chart.position_mm[k] - point)
                       : glm::dvec3(0);
        };
        glm::dvec3 side_u = neighbour(tx + 1, ty, 1), side_v = neighbour(tx, ty + 1, 1);
        if (side_u == glm::dvec3(0) && tx > 0) side_u = neighbour(tx - 1, ty, -1);
        if (side_v == glm::dvec3(0) && ty > 0) side_v = neighbour(tx, ty - 1, -1);
        // Across a ridge the neighbour lies on another face: a texel stays on its own.
        side_u -= normal * glm::dot(normal, side_u);
        side_v -= normal * glm::dot(normal, side_v);
        Texel texel;
        for (const Photograph& photograph : all) {
            const Camera& camera = photograph.view.camera;
            const double facing = glm::dot(normal, camera.view(point));
            if (!(facing > grazing)) continue;
            const auto centre = camera.project(point);
            const auto edge_u = camera.project(point + side_u),
                       edge_v = camera.project(point + side_v);
            if (!centre || !edge_u || !edge_v) continue;
            const glm::dvec2 du = *edge_u - *centre, dv = *edge_v - *centre;
            const double reach = std::max({glm::length(du), glm::length(dv), 1.0});
            const int taps = std::min(64, static_cast<int>(std::ceil(1.5 * reach)));
            double cos2 = 1, sin2 = 0;
            if (photograph.map->frame == MapFrame::image) {
                const double along = glm::dot(camera.right, tangent),
                             across = glm::dot(camera.right, bitangent),
                             size2 = along * along + across * across;
                if (size2 > 1e-12) {
                    cos2 = (along * along - across * across) / size2;
                    sin2 = 2 * along * across / size2;
                }
            }
            const auto w_px = static_cast<std::size_t>(camera.width_px),
                       h_px = static_cast<std::size_t>(camera.height_px);
            for (int a = 0; a < taps; ++a) {
                for (int b = 0; b < taps; ++b) {
                    const glm::dvec2 at = *centre + ((a + 0.5) / taps - 0.5) * du +
                                          ((b + 0.5) / taps - 0.5) * dv - 0.5;
                    // Bilinear: four pixels, those that cannot be used left out.
                    const double fx0 = std::floor(at.x), fy0 = std::floor(at.y);
                    for (int k = 0; k < 4; ++k) {
                        const double px = fx0 + (k & 1), py = fy0 + (k >> 1);
                        if (!(px >= 0 && py >= 0 && px < double(w_px) && py < double(h_px)))
                            continue;
                        const auto x = static_cast<std::size_t>(px),
                                   y = static_cast<std::size_t>(py);
                        const std::size_t pixel = y * w_px + x;
                        const double fade = photograph.fade[pixel];
                        if (!(fade > 0)) continue;
                        // Another place of the blade, in front of this one.
                        const glm::dvec3 off = photograph.view.position_mm[pixel] - point;
                        if (std::abs(glm::dot(off, normal)) > options.hidden_mm) continue;
                        const double share = (1 - std::abs(at.x - px)) * (1 - std::abs(at.y - py));
                        const double weight = share * facing * facing * fade / (taps * taps);
                        if (!(weight > 0)) continue;
                        const std::size_t row = h_px - 1 - y;  // maps begin at the lowest row
                        const PropertyMaps& from = photograph.map->maps;
                        const double w = f64::sanitise_share(from.at(MapChannel::w, x, row));
                        const double h = from[MapChannel::h].empty()
                                             ? 0
                                             : f64::sanitise_share(from.at(MapChannel::h, x, row));
                        const auto ji =
                            moments_at(from, MapChannel::ji_ln_mu_deg, x, row, cos2, sin2);
                        const auto ha =
                            moments_at(from, MapChannel::ha_ln_mu_deg, x, row, cos2, sin2);
                        texel.ji.add(ji, weight * (1 - w) * (1 - h));
                        texel.ha.add(ha, weight * w);
                        texel.plain_ji.add(ji, weight);
                        texel.plain_ha.add(ha, weight);
                        texel.w += weight * w;
                        texel.h += weight * (1 - w) * h;
                        texel.h_weight += weight * (1 - w);
                        texel.weight += weight;
                    }
                }
            }
        }
        return texel;
    };
    std::size_t rows_done = 0;
    std::atomic<bool> cancelled{false};
    std::mutex telling;
    parallel_for(
        options.height, 1,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t ty = begin; ty < end && !cancelled; ++ty) {
                for (std::size_t tx = 0; tx < options.width; ++tx) {
                    const std::size_t i = ty * options.width + tx;
                    if (chart.on[i] == 0) continue;
                    const Texel texel = texel_at(tx, ty);
                    if (!(texel.weight > 1e-9)) continue;
                    result.coverage[i] = static_cast<float>(texel.weight);
                    constexpr double some = 1e-6;
                    const auto set = [&](MapChannel first, const f64::Lobe& lobe) {
                        const auto c = static_cast<std::size_t>(first);
                        maps.channels[c][i] = static_cast<float>(lobe.ln_mu_deg);
                        maps.channels[c + 1][i] = static_cast<float>(lobe.e1);
                        maps.channels[c + 2][i] = static_cast<float>(lobe.e2);
                    };
                    set(MapChannel::ji_ln_mu_deg,
                        (texel.ji.weight > some * texel.weight ? texel.ji : texel.plain_ji).lobe());
                    set(MapChannel::ha_ln_mu_deg,
                        (texel.ha.weight > some * texel.weight ? texel.ha : texel.plain_ha).lobe());
                    maps[MapChannel::w][i] = static_cast<float>(texel.w / texel.weight);
                    maps[MapChannel::h][i] =
                        static_cast<float>(texel.h_weight > 0 ? texel.h / texel.h_weight : 0.0);
                }
                if (progress) {
                    const std::scoped_lock lock(telling);
                    const auto done = static_cast<double>(++rows_done);
                    if (!progress(done / static_cast<double>(options.height))) cancelled = true;
                }
            }
        },
        options.threads);
    if (cancelled) throw ProjectCancelled{};
    for (std::size_t i = 0; i < n; ++i) {
        if (chart.on[i] == 0) continue;
        ++result.on_blade;
        if (!(result.coverage[i] > 0)) ++result.holes;
    }
    if (result.holes == result.on_blade) {
        throw InputError("project", "photographs", "none shows the blade",
                         "cameras that look at it, maps with pixels that are not masked");
    }
    (void)repair_map(maps);  // holes take the nearest value
    return result;
}

}  // namespace togishi
