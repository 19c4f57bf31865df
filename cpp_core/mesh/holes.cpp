#include "mesh/holes.hpp"

#include <algorithm>
#include <limits>
#include <unordered_set>
#include <utility>

#include "mesh/half_edges.hpp"

namespace togishi {
namespace {

using EdgeSet = std::unordered_set<std::uint64_t>;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
}

/// The mesh's edges between vertices of holes: a patch must not have them once more.
EdgeSet edges_between(const TriangleMesh& mesh, const std::vector<Hole>& holes) {
    std::vector<std::uint8_t> on_border(mesh.positions.size(), 0);
    for (const Hole& hole : holes) {
        for (const std::uint32_t v : hole.vertices) on_border[v] = 1;
    }
    EdgeSet found;
    for (const Triangle& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (on_border[a] != 0 && on_border[b] != 0) found.insert(edge_key(a, b));
        }
    }
    return found;
}

/// The triangles of least area over a border.
class Patch {
  public:
    Patch(const TriangleMesh& mesh, const std::vector<std::uint32_t>& border, const EdgeSet& taken)
        : border_(border),
          n_(border.size()),
          taken_(taken),
          area_(n_ * n_, 0.0),
          middle_(n_ * n_, 0) {
        points_.reserve(n_);
        for (const std::uint32_t v : border) points_.emplace_back(mesh.positions[v]);
    }

    /// None where every patch has a chord that the mesh has already.
    std::vector<Triangle> triangles() {
        for (std::size_t reach = 2; reach < n_; ++reach) {
            for (std::size_t i = 0; i + reach < n_; ++i) {
                const std::size_t k = i + reach;
                double best = refused;
                const bool border_edge = i == 0 && k == n_ - 1;
                if (!border_edge && taken_.contains(edge_key(border_[i], border_[k]))) {
                    area_[i * n_ + k] = best;
                    continue;
                }
                for (std::size_t m = i + 1; m < k; ++m) {
                    const double area =
                        area_[i * n_ + m] + area_[m * n_ + k] + triangle_area(i, m, k);
                    if (area < best) {
                        best = area;
                        middle_[i * n_ + k] = static_cast<std::uint32_t>(m);
                    }
                }
                area_[i * n_ + k] = best;
            }
        }
        std::vector<Triangle> out;
        if (area_[n_ - 1] >= refused) return out;
        out.reserve(n_ - 2);
        std::vector<std::pair<std::size_t, std::size_t>> open{{0, n_ - 1}};
        while (!open.empty()) {
            const auto [i, k] = open.back();
            open.pop_back();
            if (k - i < 2) continue;
            const std::size_t m = middle_[i * n_ + k];
            out.push_back({border_[i], border_[m], border_[k]});
            open.emplace_back(i, m);
            open.emplace_back(m, k);
        }
        return out;
    }

  private:
    [[nodiscard]] double triangle_area(std::size_t i, std::size_t m, std::size_t k) const {
        const glm::dvec3 a = points_[m] - points_[i], b = points_[k] - points_[i];
        const double area = 0.5 * glm::length(glm::cross(a, b));
        const double longest = std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(b - a, b - a)});
        // Corners in a line: only where nothing else fits.
        return area < 1e-4 * longest ? area + 10 * longest : area;
    }

    static constexpr double refused = std::numeric_limits<double>::infinity();

    /// Row i, column k: the least area over the border from i to k and the chord back.
    const std::vector<std::uint32_t>& border_;
    std::size_t n_;
    const EdgeSet& taken_;
    std::vector<glm::dvec3> points_;
    std::vector<double> area_;
    std::vector<std::uint32_t> middle_;
};

}  // namespace

std::vector<Hole> find_holes(const TriangleMesh& mesh) {
    const HalfEdges edges = link_half_edges(mesh, true);
    // Every vertex of a clean mesh has one fan, so at most one border edge starts at it.
    std::vector<std::uint32_t> next(mesh.positions.size(), no_half_edge);
    std::vector<std::uint32_t> starts;
    for (std::uint32_t h = 0; h < edges.twin.size(); ++h) {
        if (edges.twin[h] != no_half_edge) continue;
        const std::uint32_t from = start_of(mesh.triangles, h);
        next[from] = start_of(mesh.triangles, next_half_edge(h));
        starts.push_back(from);
    }
    std::vector<Hole> holes;
    for (const std::uint32_t start : starts) {
        if (next[start] == no_half_edge) continue;
        Hole& hole = holes.emplace_back();
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
        std::uint32_t v = start;
        while (next[v] != no_half_edge) {
            hole.vertices.push_back(v);
            const std::uint32_t to = next[v];
            next[v] = no_half_edge;
            const glm::dvec3 at = mesh.positions[v];
            hole.length += glm::length(glm::dvec3(mesh.positions[to]) - at);
            low = glm::min(low, at);
            high = glm::max(high, at);
            v = to;
        }
        hole.size = glm::length(high - low);
        hole.centre = mesh.origin + 0.5 * (low + high);
    }
    std::stable_sort(holes.begin(), holes.end(),
                     [](const Hole& a, const Hole& b) { return a.length > b.length; });
    return holes;
}

HoleClosing close_holes(TriangleMesh& mesh, const std::vector<Hole>& holes) {
    HoleClosing done;
    EdgeSet taken = edges_between(mesh, holes);
    for (const Hole& hole : holes) {
        if (hole.vertices.size() < 3 || hole.vertices.size() > most_hole_edges) {
            ++done.left_open;
            continue;
        }
        // The border runs with its triangles; what closes it runs against them.
        const std::vector<std::uint32_t> border(hole.vertices.rbegin(), hole.vertices.rend());
        const auto patch = Patch(mesh, border, taken).triangles();
        if (patch.empty()) {
            ++done.left_open;
            continue;
        }
        for (const Triangle& t : patch) {
            for (std::size_t k = 0; k < 3; ++k) taken.insert(edge_key(t[k], t[(k + 1) % 3]));
        }
        mesh.triangles.insert(mesh.triangles.end(), patch.begin(), patch.end());
        done.triangles_made += patch.size();
        ++done.closed;
    }
    return done;
}

}  // namespace togishi
