#include "capture/silhouette.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "capture/camera_step.hpp"
#include "capture/camera_surface.hpp"

namespace togishi {
namespace {

constexpr std::size_t most_points = 4000;
constexpr int most_passes = 10;
/// Standard deviation of an outline found in a picture, and how many neighbours share their error.
constexpr double edge_sigma_px = 0.5, alike = 5;
/// How far a camera is trusted that was not found by landmarks; they speak for themselves.
constexpr double start_sigma_rad = 0.5 * 3.14159265358979323846 / 180, start_sigma_ln_scale = 0.02;
constexpr double landmarks_trust = 40;

/// A mesh's edge and the two faces that meet there.
struct Edge {
    std::size_t from, to;
    std::size_t face[2];
};

std::vector<Edge> edges_of(const BladeMesh& mesh) {
    std::vector<Edge> edges;
    std::unordered_map<std::uint64_t, std::size_t> found;
    found.reserve(2 * mesh.corner_vertex.size());
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto first = static_cast<std::size_t>(mesh.face_start[f]),
                   end = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = first; c < end; ++c) {
            const auto a = static_cast<std::size_t>(mesh.corner_vertex[c]),
                       b = static_cast<std::size_t>(
                           mesh.corner_vertex[c + 1 < end ? c + 1 : first]);
            const std::uint64_t key =
                (static_cast<std::uint64_t>(std::min(a, b)) << 32U) | std::max(a, b);
            const auto [at, fresh] = found.try_emplace(key, edges.size());
            if (fresh) {
                edges.push_back({a, b, {f, f}});
            } else {
                edges[at->second].face[1] = f;
            }
        }
    }
    return edges;
}

/// A place of the outline: on the blade, in the picture, and the way out of it in the picture.
struct OutlinePoint {
    glm::dvec3 point_mm;
    glm::dvec2 pixel, outwards;
    double px_per_mm;
};

std::vector<OutlinePoint> outline_of(const BladeMesh& mesh, const std::vector<Edge>& edges,
                                     const Camera& camera) {
    std::vector<std::uint8_t> front(mesh.face_count(), 0);
    for (std::size_t f = 0; f < front.size(); ++f) {
        const auto first = static_cast<std::size_t>(mesh.face_start[f]);
        const auto vertex = [&](std::size_t c) {
            return mesh.positions_mm[static_cast<std::size_t>(mesh.corner_vertex[first + c])];
        };
        const glm::dvec3 p = vertex(0);
        front[f] = glm::dot(glm::cross(vertex(1) - p, vertex(2) - p), camera.view(p)) > 0 ? 1 : 0;
    }
    const std::vector<std::uint8_t> seen = view_of_mesh(mesh, camera).seen;
    const auto inside = [&](const glm::dvec2& at) {
        return at.x >= 0 && at.y >= 0 && at.x < camera.width_px && at.y < camera.height_px;
    };
    const auto covered = [&](const glm::dvec2& at) {
        return seen[static_cast<std::size_t>(at.y) * static_cast<std::size_t>(camera.width_px) +
                    static_cast<std::size_t>(at.x)] != 0;
    };
    std::vector<OutlinePoint> points;
    for (const Edge& edge : edges) {
        if (front[edge.face[0]] == front[edge.face[1]]) continue;
        const glm::dvec3 a = mesh.positions_mm[edge.from], b = mesh.positions_mm[edge.to];
        const auto pa = camera.project(a), pb = camera.project(b);
        if (!pa || !pb) continue;
        const double length = glm::length(*pb - *pa);
        if (length < 1e-6) continue;
        const glm::dvec2 along = (*pb - *pa) / length;
        const int steps = std::max(1, static_cast<int>(std::lround(length)));
        for (int k = 0; k < steps; ++k) {
            const glm::dvec3 point = a + ((k + 0.5) / steps) * (b - a);
            const glm::dvec2 pixel = *camera.project(point);
            glm::dvec2 outwards(along.y, -along.x);
            // Two pixels to either side: one on the blade, one on the ground.
            const glm::dvec2 one = pixel + 2.0 * outwards, other = pixel - 2.0 * outwards;
            if (!inside(one) || !inside(other) || covered(one) == covered(other)) continue;
            if (covered(one)) outwards = -outwards;
            const double per_mm =
                camera.pinhole ? camera.scale / camera.depth_mm(point) : camera.scale;
            points.push_back({point, pixel, outwards, per_mm});
        }
    }
    if (points.size() > most_points) {
        const double step = static_cast<double>(points.size()) / most_points;
        for (std::size_t k = 0; k < most_points; ++k)
            points[k] = points[static_cast<std::size_t>(static_cast<double>(k) * step)];
        points.resize(most_points);
    }
    return points;
}

class EdgeFinder {
  public:
    EdgeFinder(const std::vector<float>& picture, const Camera& camera)
        : picture_(picture), width_(camera.width_px), height_(camera.height_px) {
        std::vector<float> values;
        const std::size_t step = std::max<std::size_t>(1, picture.size() / 100000);
        for (std::size_t i = 0; i < picture.size(); i += step)
            if (std::isfinite(picture[i])) values.push_back(picture[i]);
        std::sort(values.begin(), values.end());
        if (!values.empty()) {
            const auto n = static_cast<double>(values.size() - 1);
            range_ = values[static_cast<std::size_t>(0.99 * n)] -
                     values[static_cast<std::size_t>(0.01 * n)];
        }
    }
    [[nodiscard]] double range() const { return range_; }

    /// Distance along `outwards`, within +-reach pixels, of the outermost step of brightness that
    /// is a good share of the largest one.
    [[nodiscard]] std::optional<double> find(const OutlinePoint& point, double reach) const {
        constexpr double spacing = 0.5;
        const int n = static_cast<int>(std::ceil(reach / spacing));
        std::vector<double> rise(2 * static_cast<std::size_t>(n) + 1, 0.0);
        double most = 0;
        for (int k = -n; k <= n; ++k) {
            const double t = k * spacing;
            const double v = std::abs(at(point.pixel + (t + 1) * point.outwards) -
                                      at(point.pixel + (t - 1) * point.outwards));
            if (!std::isfinite(v)) continue;
            const int index = k + n;
            rise[static_cast<std::size_t>(index)] = v;
            most = std::max(most, v);
        }
        constexpr double least_of_range = 0.05, least_of_most = 0.4;
        const double least = std::max(least_of_range * range_, least_of_most * most);
        for (std::size_t k = rise.size() - 2; k > 0; --k) {
            if (!(rise[k] >= least && rise[k] >= rise[k + 1] && rise[k] >= rise[k - 1])) continue;
            const double bend = rise[k + 1] - 2 * rise[k] + rise[k - 1];
            const double shift = bend < 0 ? 0.5 * (rise[k - 1] - rise[k + 1]) / bend : 0;
            return (static_cast<double>(k) - n + shift) * spacing;
        }
        return std::nullopt;
    }

  private:
    [[nodiscard]] double at(const glm::dvec2& pixel) const {
        const double x = std::clamp(pixel.x - 0.5, 0.0, width_ - 1.0),
                     y = std::clamp(pixel.y - 0.5, 0.0, height_ - 1.0);
        const int x0 = std::min(static_cast<int>(x), std::max(width_ - 2, 0)),
                  y0 = std::min(static_cast<int>(y), std::max(height_ - 2, 0));
        const double fx = x - x0, fy = y - y0;
        const auto value = [&](int px, int py) {
            return static_cast<double>(
                picture_[static_cast<std::size_t>(std::min(py, height_ - 1)) *
                             static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(std::min(px, width_ - 1))]);
        };
        return (1 - fy) * ((1 - fx) * value(x0, y0) + fx * value(x0 + 1, y0)) +
               fy * ((1 - fx) * value(x0, y0 + 1) + fx * value(x0 + 1, y0 + 1));
    }

    const std::vector<float>& picture_;
    int width_, height_;
    double range_ = 0;
};

/// The outline in the picture beside where a camera puts it.
struct Match {
    OutlinePoint point;
    double offset_px;  ///< outwards
    double weight = 1;
};

struct Matches {
    std::vector<Match> found;
    std::size_t outline = 0;
    double rms_mm = 0, p90_mm = 0, rms_px = 0;
};

Matches match(const BladeMesh& mesh, const std::vector<Edge>& edges, const Camera& camera,
              const EdgeFinder& finder, double reach_mm) {
    Matches out;
    std::vector<double> mm;
    double sum = 0, sum_px = 0;
    for (const OutlinePoint& point : outline_of(mesh, edges, camera)) {
        ++out.outline;
        const auto offset = finder.find(point, std::max(reach_mm * point.px_per_mm, 3.0));
        if (!offset) continue;
        out.found.push_back({point, *offset, 1});
        mm.push_back(std::abs(*offset) / point.px_per_mm);
        sum += mm.back() * mm.back();
        sum_px += *offset * *offset;
    }
    if (mm.empty()) return out;
    const auto n = static_cast<double>(mm.size());
    out.rms_mm = std::sqrt(sum / n);
    out.rms_px = std::sqrt(sum_px / n);
    // Points that found something else (the habaki, a stain) count less and less.
    std::vector<double> px;
    px.reserve(out.found.size());
    for (const Match& one : out.found) px.push_back(std::abs(one.offset_px));
    const double scale = std::max(3 * 1.4826 * median(px), 1.0);
    for (Match& one : out.found)
        one.weight = 1 / (1 + (one.offset_px / scale) * (one.offset_px / scale));
    out.p90_mm = quantile(mm, 0.9);
    return out;
}

std::string number(double value) {
    std::string text = std::to_string(value);
    return text.substr(0, text.find('.') + 3);
}

}  // namespace

SilhouetteFit refine_on_silhouette(const BladeMesh& mesh, const Camera& start,
                                   const std::vector<float>& picture,
                                   const std::vector<Landmark>& landmarks,
                                   const SilhouetteOptions& options) {
    check_camera(start, "silhouette");
    if (picture.size() !=
        static_cast<std::size_t>(start.width_px) * static_cast<std::size_t>(start.height_px)) {
        throw InputError("silhouette", "picture", std::to_string(picture.size()) + " pixels",
                         std::to_string(start.width_px) + " x " + std::to_string(start.height_px) +
                             ", as the camera");
    }
    if (!(options.search_mm > 0 && options.search_mm < 1000))
        throw InputError("silhouette", "search_mm", number(options.search_mm), "above 0, to 1000");
    const EdgeFinder finder(picture, start);
    const std::vector<Edge> edges = edges_of(mesh);
    const auto refuse_lost = [&](const Matches& m) {
        if (m.outline < 40) {
            throw InputError("silhouette", "outline", "outside the picture",
                             "a camera that sees the blade and the ground beside it");
        }
        if (!(finder.range() > 0) || m.found.size() * 2 < m.outline) {
            throw InputError(
                "silhouette", "outline",
                "found on " + std::to_string(100 * m.found.size() / m.outline) + " % of it",
                "a picture in which the blade stands out from a plain ground, and a camera that "
                "puts it within " +
                    number(options.search_mm) + " mm");
        }
    };
    SilhouetteFit fit;
    fit.camera = start;
    double reach = options.search_mm;
    const double trust = landmarks.empty() ? 1 : landmarks_trust;
    std::optional<glm::dvec3> anchor;  // what the start says of the place, where no landmark does
    for (int pass = 0; pass < most_passes; ++pass) {
        const Matches matches = match(mesh, edges, fit.camera, finder, reach);
        refuse_lost(matches);
        if (pass == 0) {
            fit.before_rms_mm = matches.rms_mm;
            if (landmarks.empty()) anchor = matches.found[matches.found.size() / 2].point.point_mm;
        }
        const double share = 1 / (edge_sigma_px * std::sqrt(alike));
        std::vector<Landmark> held = landmarks;
        double held_mm = options.landmark_sigma_mm;
        if (anchor) {
            held.push_back({"start", *anchor, *start.project(*anchor)});
            held_mm = options.search_mm;
        }
        const Camera before = fit.camera;
        fit_camera(fit.camera, [&](const Camera& with) {
            Eigen::VectorXd r(
                static_cast<Eigen::Index>(matches.found.size() + 2 * held.size() + 4));
            Eigen::Index k = 0;
            for (const Match& one : matches.found) {
                const auto pixel = with.project(one.point.point_mm);
                const double off =
                    pixel ? glm::dot(*pixel - one.point.pixel, one.point.outwards) : 1e6;
                r[k++] = share * std::sqrt(one.weight) * (off - one.offset_px);
            }
            for (const Landmark& one : held) {
                const auto pixel = with.project(one.point_mm);
                const glm::dvec2 d = pixel ? *pixel - one.pixel : glm::dvec2(1e6);
                const double per_mm =
                    with.pinhole ? with.scale / with.depth_mm(one.point_mm) : with.scale;
                r[k++] = d.x / (per_mm * held_mm);
                r[k++] = d.y / (per_mm * held_mm);
            }
            const glm::dvec3 turned =
                0.5 * (glm::cross(start.right, with.right) + glm::cross(start.down, with.down) +
                       glm::cross(start.forward(), with.forward()));
            for (const double angle : {turned.x, turned.y, turned.z})
                r[k++] = angle / (trust * start_sigma_rad);
            r[k++] = std::log(with.scale / start.scale) / (trust * start_sigma_ln_scale);
            return r;
        });
        double moved = 0;
        for (const Match& one : matches.found) {
            const auto a = before.project(one.point.point_mm),
                       b = fit.camera.project(one.point.point_mm);
            if (a && b) moved = std::max(moved, glm::length(*a - *b));
        }
        reach = std::clamp(4 * matches.rms_mm, 0.25, reach);
        if (pass > 1 && moved < 0.02) break;
    }
    const Matches last = match(mesh, edges, fit.camera, finder, reach);
    refuse_lost(last);
    fit.rms_mm = last.rms_mm;
    fit.p90_mm = last.p90_mm;
    fit.points = last.found.size();
    fit.outline = last.outline;
    if (!(fit.rms_mm <= options.max_residual_mm)) {
        throw InputError(
            "silhouette", "outline", number(fit.rms_mm) + " mm off",
            "within " + number(options.max_residual_mm) + " mm: a blade of these dimensions");
    }
    return fit;
}

}  // namespace togishi
