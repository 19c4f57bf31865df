#include "scanned/chart_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace togishi {
namespace {

constexpr std::size_t grain = 16384;
constexpr std::uint8_t nakago_mune = 8;
constexpr std::uint8_t nakago_shinogi_ji = 9;
// Nearer to its end than this share of an edge, a cut goes through the end.
constexpr float snap_share = 0.05F;
// Beside a border of the chart, where a label that differs is a matter of the triangles' size.
constexpr double label_slack_mm = 0.7;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32U | std::max(a, b);
}

// The scan while it is being cut.
class Cutter {
  public:
    Cutter(ChartedMesh& charted, const ScannedChart& chart, std::span<const Part> labels,
           unsigned threads)
        : c_(charted),
          chart_(chart),
          labels_(labels),
          threads_(threads),
          scan_triangles_(charted.mesh.triangles.size()),
          was_cut_(scan_triangles_, 0) {}

    void place_vertices() {
        const std::size_t n = c_.mesh.positions.size();
        c_.s_mm.resize(n);
        c_.t_mm.resize(n);
        c_.off_mm.resize(n);
        middle_.resize(n);
        parallel_for(
            n, grain,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t v = begin; v < end; ++v) place(v);
            },
            threads_);
    }

    void cut_all() {
        const BladeFrame& frame = chart_.frame();
        cut([&](std::size_t v) { return middle_[v]; }, true);
        auto at_curve = [&](const std::vector<double>& curve) {
            cut(
                [&](std::size_t v) {
                    return static_cast<float>(double(c_.t_mm[v]) -
                                              frame.at(curve, double(c_.s_mm[v])));
                },
                false);
        };
        auto at_s = [&](double s) {
            cut([&](std::size_t v) { return static_cast<float>(double(c_.s_mm[v]) - s); }, false);
        };
        at_curve(frame.mune_mm);
        double shinogi_ji = 0;
        for (std::size_t i = 0; i < frame.mune_mm.size(); ++i)
            shinogi_ji = std::max(shinogi_ji, frame.shinogi_mm[i] - frame.mune_mm[i]);
        if (shinogi_ji > 0.1) at_curve(frame.shinogi_mm);
        at_curve(frame.suguha_mm);
        if (frame.nakago_mm > 0) at_s(0);
        if (frame.yokote_s_mm < frame.nagasa_mm) at_s(frame.yokote_s_mm);
    }

    void set_regions() {
        const std::size_t n = c_.mesh.triangles.size();
        c_.region.resize(n);
        std::vector<Part> own(n);
        parallel_for(
            n, grain,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t f = begin; f < end; ++f) own[f] = chart_part(f);
            },
            threads_);
        // The chart's parts that the pieces of a cut triangle lie in.
        std::unordered_map<std::uint32_t, unsigned> parts_of_cut;
        if (!labels_.empty()) {
            for (std::size_t f = 0; f < n; ++f) {
                const std::uint32_t scan = scan_triangle(f);
                if (was_cut_[scan] != 0) parts_of_cut[scan] |= 1U << static_cast<unsigned>(own[f]);
            }
        }
        parallel_for(
            n, grain,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t f = begin; f < end; ++f) {
                    Part part = own[f];
                    if (!labels_.empty()) {
                        const std::uint32_t scan = scan_triangle(f);
                        const Part label = labels_[scan];
                        const auto pieces = parts_of_cut.find(scan);
                        const bool among =
                            pieces != parts_of_cut.end() &&
                            (pieces->second >> static_cast<unsigned>(label) & 1U) != 0;
                        if (label != part && !among && !beside(f, label)) part = label;
                    }
                    const glm::dvec2 st = middle_of(f);
                    const BladeFrame& frame = chart_.frame();
                    const int strip = st.y <= frame.at(frame.mune_mm, st.x)      ? 0
                                      : st.y <= frame.at(frame.shinogi_mm, st.x) ? 1
                                                                                 : 2;
                    c_.region[f] = Region(part, omote(f), strip);
                }
            },
            threads_);
        c_.cut = static_cast<std::size_t>(std::count(was_cut_.begin(), was_cut_.end(), 1));
    }

  private:
    void place(std::size_t v) {
        const ChartPlace p = chart_.place(glm::dvec3(c_.mesh.positions[v]));
        c_.s_mm[v] = static_cast<float>(p.s_mm);
        c_.t_mm[v] = static_cast<float>(p.t_mm);
        const double off = std::abs(p.off_mm) > p.beyond_mm ? p.off_mm : p.beyond_mm;
        c_.off_mm[v] = static_cast<float>(off);
        middle_[v] = static_cast<float>(p.middle_mm);
    }

    [[nodiscard]] std::uint32_t scan_triangle(std::size_t f) const {
        return f < scan_triangles_ ? static_cast<std::uint32_t>(f) : parent_[f - scan_triangles_];
    }
    [[nodiscard]] glm::dvec2 middle_of(std::size_t f) const {
        glm::dvec2 sum(0);
        for (const std::uint32_t v : c_.mesh.triangles[f])
            sum += glm::dvec2(c_.s_mm[v], c_.t_mm[v]);
        return sum / 3.0;
    }
    [[nodiscard]] Part part_at(double s, double t) const {
        const BladeFrame& frame = chart_.frame();
        // The scan's own edge may lie a hair beyond the cross-sections'.
        return frame.part_at(s, std::min(t, frame.at(frame.edge_mm, s)));
    }
    [[nodiscard]] Part chart_part(std::size_t f) const {
        const glm::dvec2 st = middle_of(f);
        return part_at(st.x, st.y);
    }
    [[nodiscard]] bool beside(std::size_t f, Part label) const {
        const glm::dvec2 st = middle_of(f);
        for (const double d : {-label_slack_mm, label_slack_mm}) {
            if (part_at(st.x, std::max(0.0, st.y + d)) == label || part_at(st.x + d, st.y) == label)
                return true;
        }
        return false;
    }
    [[nodiscard]] bool omote(std::size_t f) const {
        float sum = 0;
        for (const std::uint32_t v : c_.mesh.triangles[f]) sum += middle_[v];
        return sum >= 0;
    }

    // Cuts where `value`, taken as linear along edges, passes zero.
    template <class Value>
    void cut(const Value& value, bool seam) {
        std::vector<float> phi(c_.mesh.positions.size());
        parallel_for(
            phi.size(), grain,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t v = begin; v < end; ++v) phi[v] = value(v);
            },
            threads_);
        const std::size_t triangles = c_.mesh.triangles.size();
        std::vector<std::size_t> crossed;
        for (std::size_t f = 0; f < triangles; ++f) {
            const Triangle& t = c_.mesh.triangles[f];
            const float low = std::min({phi[t[0]], phi[t[1]], phi[t[2]]});
            const float high = std::max({phi[t[0]], phi[t[1]], phi[t[2]]});
            if (low < 0 && high > 0) crossed.push_back(f);
        }
        std::vector<std::uint32_t> onto;
        for (const std::size_t f : crossed) {
            const Triangle& t = c_.mesh.triangles[f];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k];
                const std::uint32_t b = t[(k + 1) % 3];
                if (!(phi[a] * phi[b] < 0)) continue;
                const float share = phi[a] / (phi[a] - phi[b]);
                if (share < snap_share) onto.push_back(a);
                if (share > 1 - snap_share) onto.push_back(b);
            }
        }
        for (const std::uint32_t v : onto) {
            phi[v] = 0;
            if (seam) to_seam(v, 0);
        }
        made_.clear();
        for (const std::size_t f : crossed) split(f, phi, seam);
    }

    // A vertex on the seam belongs to both sides; at the ridge its t is nothing.
    void to_seam(std::uint32_t v, float edge_length) {
        middle_[v] = 0;
        const float slack = std::max(0.5F * edge_length, 0.05F);
        if (c_.t_mm[v] < slack) c_.t_mm[v] = 0;
    }

    std::uint32_t point_on(std::uint32_t a, std::uint32_t b, std::vector<float>& phi, bool seam) {
        if (a > b) std::swap(a, b);  // one result, whichever triangle asks first
        const auto [found, fresh] =
            made_.try_emplace(edge_key(a, b), static_cast<std::uint32_t>(c_.mesh.positions.size()));
        const std::uint32_t v = found->second;
        if (!fresh) return v;
        const float f = phi[a] / (phi[a] - phi[b]);
        TriangleMesh& m = c_.mesh;
        const glm::vec3 pa = m.positions[a];
        const glm::vec3 pb = m.positions[b];
        m.positions.push_back(glm::mix(pa, pb, f));
        if (!m.colours.empty()) {
            Colour8 colour{};
            for (std::size_t k = 0; k < colour.size(); ++k) {
                colour[k] = static_cast<std::uint8_t>(
                    std::lround(glm::mix(float(m.colours[a][k]), float(m.colours[b][k]), f)));
            }
            m.colours.push_back(colour);
        }
        auto mixed = [&](std::vector<float>& values) {
            values.push_back(glm::mix(values[a], values[b], f));
        };
        mixed(c_.s_mm);
        mixed(c_.t_mm);
        mixed(c_.off_mm);
        mixed(middle_);
        phi.push_back(0);
        if (seam) {
            place(v);
            to_seam(v, glm::distance(pa, pb));
        }
        return v;
    }

    void add(const Triangle& t, std::size_t from) {
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
        c_.mesh.triangles.push_back(t);
        parent_.push_back(scan_triangle(from));
    }

    void split(std::size_t f, std::vector<float>& phi, bool seam) {
        const Triangle t = c_.mesh.triangles[f];
        auto crosses = [&](std::size_t k) { return phi[t[k]] * phi[t[(k + 1) % 3]] < 0; };
        const int crossings = int(crosses(0)) + int(crosses(1)) + int(crosses(2));
        if (crossings == 0) return;
        was_cut_[scan_triangle(f)] = 1;
        if (crossings == 1) {
            // Through a vertex and the edge that faces it.
            const std::size_t k = crosses(0) ? 0U : crosses(1) ? 1U : 2U;
            const std::uint32_t a = t[k];
            const std::uint32_t b = t[(k + 1) % 3];
            const std::uint32_t c = t[(k + 2) % 3];
            const std::uint32_t m = point_on(a, b, phi, seam);
            c_.mesh.triangles[f] = {a, m, c};
            add({m, b, c}, f);
            return;
        }
        // One vertex alone on its side.
        const std::size_t k = !crosses(0) ? 2U : !crosses(1) ? 0U : 1U;
        const std::uint32_t a = t[k];
        const std::uint32_t b = t[(k + 1) % 3];
        const std::uint32_t c = t[(k + 2) % 3];
        const std::uint32_t ab = point_on(a, b, phi, seam);
        const std::uint32_t ca = point_on(c, a, phi, seam);
        c_.mesh.triangles[f] = {a, ab, ca};
        const std::vector<glm::vec3>& p = c_.mesh.positions;
        if (glm::distance(p[ab], p[c]) < glm::distance(p[b], p[ca])) {
            add({ab, b, c}, f);
            add({ab, c, ca}, f);
        } else {
            add({ab, b, ca}, f);
            add({b, c, ca}, f);
        }
    }

    ChartedMesh& c_;
    const ScannedChart& chart_;
    std::span<const Part> labels_;
    unsigned threads_;
    std::size_t scan_triangles_;
    std::vector<std::uint8_t> was_cut_;  // of the scan's triangles
    std::vector<std::uint32_t> parent_;  // of the triangles that were added
    std::vector<float> middle_;
    std::unordered_map<std::uint64_t, std::uint32_t> made_;
};

}  // namespace

Region::Region(Part part, bool omote, int strip) {
    auto kind = static_cast<std::uint8_t>(part);
    if (part == Part::nakago && strip == 0) kind = nakago_mune;
    if (part == Part::nakago && strip == 1) kind = nakago_shinogi_ji;
    id_ = static_cast<std::uint8_t>(2 * kind + (omote ? 0 : 1));
}

Part Region::part() const {
    const int kind = id_ / 2;
    return kind >= nakago_mune ? Part::nakago : static_cast<Part>(kind);
}

std::uint8_t Region::smooth_surface() const {
    auto as = [&](Part part) { return static_cast<std::uint8_t>(2 * int(part) + id_ % 2); };
    if (id_ / 2 >= nakago_mune) return id_;
    if (part() == Part::ha) return as(Part::ji);
    if (part() == Part::boshi) return as(Part::kissaki);
    return id_;
}

ChartedMesh chart_mesh(TriangleMesh scan, const BladePose& pose, const ScannedChart& chart,
                       std::span<const Part> labels, unsigned threads) {
    if (!labels.empty() && labels.size() != scan.triangles.size()) {
        throw InputError("scanned blade", "labels", std::to_string(labels.size()) + " labels",
                         "one for each of " + std::to_string(scan.triangles.size()) + " triangles");
    }
    ChartedMesh charted;
    charted.mesh = std::move(scan);
    const glm::dvec3 shift = charted.mesh.origin - pose.origin_mm;
    for (glm::vec3& p : charted.mesh.positions)
        p = glm::vec3(pose.rotation * (glm::dvec3(p) + shift));
    charted.mesh.origin = glm::dvec3(0);
    Cutter cutter(charted, chart, labels, threads);
    cutter.place_vertices();
    cutter.cut_all();
    cutter.set_regions();
    return charted;
}

CornerMesh split_corners(const ChartedMesh& charted, const BladeFrame& frame, unsigned threads) {
    const TriangleMesh& mesh = charted.mesh;
    CornerMesh out;
    out.triangles = mesh.triangles;
    const std::size_t vertices = mesh.positions.size();
    out.source.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v) out.source[v] = static_cast<std::uint32_t>(v);
    constexpr std::uint8_t none = 255;
    std::vector<std::uint8_t> surface(vertices, none);
    std::unordered_map<std::uint64_t, std::uint32_t> others;
    for (std::size_t f = 0; f < out.triangles.size(); ++f) {
        const std::uint8_t here = charted.region[f].smooth_surface();
        for (std::uint32_t& v : out.triangles[f]) {
            if (surface[v] == none) surface[v] = here;
            if (surface[v] == here) continue;
            const auto [found, fresh] = others.try_emplace(
                std::uint64_t{v} << 8U | here, static_cast<std::uint32_t>(out.source.size()));
            if (fresh) {
                out.source.push_back(v);
                surface.push_back(here);
            }
            v = found->second;
        }
    }
    const std::size_t n = out.source.size();
    out.positions.resize(n);
    out.uv.resize(n);
    out.normals.assign(n, glm::vec3(0));
    for (std::size_t v = 0; v < n; ++v) out.positions[v] = mesh.positions[out.source[v]];
    for (const Triangle& t : out.triangles) {
        const glm::vec3 twice = glm::cross(out.positions[t[1]] - out.positions[t[0]],
                                           out.positions[t[2]] - out.positions[t[0]]);
        for (const std::uint32_t v : t) out.normals[v] += twice;
    }
    parallel_for(
        n, grain,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                const float length = glm::length(out.normals[v]);
                const bool omote = surface[v] % 2 == 0;
                out.normals[v] =
                    length > 0 ? out.normals[v] / length : glm::vec3(0, omote ? 1 : -1, 0);
                const std::uint32_t from = out.source[v];
                const double s = double(charted.s_mm[from]);
                const double t = double(charted.t_mm[from]);
                const double y = frame.chart_y_mm(s, t) / frame.chart_height_mm;
                out.uv[v] = {(frame.chart_x_mm(s, t) + frame.nakago_mm) / frame.length_mm(),
                             omote ? 0.5 - y : 0.5 + y};
            }
        },
        threads);
    return out;
}

BladeMesh blade_mesh(const ChartedMesh& charted, const ScannedChart& chart, unsigned threads) {
    const CornerMesh corners = split_corners(charted, chart.frame(), threads);
    BladeMesh mesh;
    mesh.frame = chart.frame();
    mesh.positions_mm.assign(charted.mesh.positions.begin(), charted.mesh.positions.end());
    mesh.s_mm = charted.s_mm;
    mesh.t_mm = charted.t_mm;
    const std::size_t n = corners.triangles.size();
    mesh.corner_vertex.reserve(3 * n);
    mesh.corner_normal.reserve(3 * n);
    mesh.corner_tangent.reserve(3 * n);
    mesh.corner_uv.reserve(3 * n);
    mesh.face_start.reserve(n + 1);
    mesh.face_part.reserve(n);
    for (std::size_t f = 0; f < n; ++f) {
        mesh.face_start.push_back(static_cast<std::int32_t>(3 * f));
        mesh.face_part.push_back(charted.region[f].part());
        const Triangle& t = corners.triangles[f];
        const glm::vec3 across = corners.positions[t[1]] - corners.positions[t[0]];
        for (const std::uint32_t v : t) {
            const glm::dvec3 normal(corners.normals[v]);
            const glm::dvec3 along =
                chart.along(chart.arc_mm(double(charted.s_mm[corners.source[v]])));
            glm::dvec3 tangent = along - normal * glm::dot(along, normal);
            // A wall across the blade faces along it: there, any direction in it.
            if (glm::length(tangent) < 0.05) tangent = glm::cross(normal, glm::dvec3(0, 1, 0));
            if (glm::length(tangent) < 0.05)
                tangent = glm::dvec3(across) - normal * glm::dot(glm::dvec3(across), normal);
            const double length = glm::length(tangent);
            mesh.corner_vertex.push_back(static_cast<std::int32_t>(corners.source[v]));
            mesh.corner_normal.push_back(corners.normals[v]);
            mesh.corner_tangent.emplace_back(length > 0 ? tangent / length : glm::dvec3(1, 0, 0));
            mesh.corner_uv.push_back(corners.uv[v]);
        }
    }
    mesh.face_start.push_back(static_cast<std::int32_t>(3 * n));
    return mesh;
}

}  // namespace togishi
