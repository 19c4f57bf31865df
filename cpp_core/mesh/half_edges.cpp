#include "mesh/half_edges.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "base/parallel.hpp"

namespace togishi {
namespace {

/// A half-edge in the list of the lower of its two vertices.
struct Entry {
    std::uint32_t other;
    std::uint32_t half_edge;
    bool operator<(const Entry& e) const {
        return other != e.other ? other < e.other : half_edge < e.half_edge;
    }
};

/// Lists are short: six half-edges to three edges.
void sort_entries(Entry* begin, Entry* end) {
    if (end - begin > 24) {
        std::sort(begin, end);
        return;
    }
    for (Entry* i = begin; i < end; ++i) {
        const Entry e = *i;
        Entry* k = i;
        for (; k > begin && e < k[-1]; --k) *k = k[-1];
        *k = e;
    }
}

/// The edges of a range of lower vertices.
class EdgeRange {
  public:
    EdgeRange(const TriangleMesh& mesh, bool strict, std::vector<std::uint32_t>& twin)
        : triangles_(mesh.triangles), positions_(mesh.positions), strict_(strict), twin_(twin) {}

    /// One edge's half-edges, ascending.
    void edge(const Entry* begin, const Entry* end) {
        const auto count = end - begin;
        if (count < 2) return;
        find_duplicates(begin, end);
        const bool same = count == 2 && start_of(triangles_, begin[0].half_edge) ==
                                            start_of(triangles_, begin[1].half_edge);
        if (same) ++same_way;
        if (count > 2 || (same && strict_)) {
            auto& all = crowded.emplace_back();
            for (const Entry* e = begin; e < end; ++e) all.push_back(e->half_edge);
            if (strict_ && count > 2) pair_up(all);
            return;
        }
        join(begin[0].half_edge, begin[1].half_edge);
    }

    std::vector<std::vector<std::uint32_t>> crowded;
    std::vector<std::uint32_t> duplicates;
    std::size_t same_way = 0;

  private:
    [[nodiscard]] std::uint32_t third(const Entry& e) const {
        return start_of(triangles_, previous_half_edge(e.half_edge));
    }
    /// Each triangle is looked at from the edge of its two lower vertices only.
    void find_duplicates(const Entry* begin, const Entry* end) {
        if (end - begin == 2) {
            if (third(begin[0]) == third(begin[1]) && third(begin[0]) > begin->other)
                duplicates.push_back(begin[1].half_edge / 3);
            return;
        }
        seen_.clear();
        for (const Entry* e = begin; e < end; ++e) {
            if (third(*e) > e->other) seen_.push_back({third(*e), e->half_edge});
        }
        std::sort(seen_.begin(), seen_.end());
        for (std::size_t i = 1; i < seen_.size(); ++i) {
            if (seen_[i].other == seen_[i - 1].other) duplicates.push_back(seen_[i].half_edge / 3);
        }
    }

    void join(std::uint32_t a, std::uint32_t b) {
        twin_[a] = b;
        twin_[b] = a;
    }

    /// Around the edge, a body lies between a triangle and the next one against the turning of its
    /// normal. Where the triangles do not alternate so (a fin on a surface), the flattest pair it
    /// is.
    void pair_up(const std::vector<std::uint32_t>& half_edges) {
        const std::uint32_t a = start_of(triangles_, half_edges[0]);
        const std::uint32_t b = start_of(triangles_, next_half_edge(half_edges[0]));
        const glm::dvec3 low = positions_[a];
        const glm::dvec3 axis = glm::dvec3(positions_[b]) - low;
        const glm::dvec3 x = glm::cross(
            axis, std::abs(axis.x) < std::abs(axis.y) ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0));
        const glm::dvec3 y = glm::cross(axis, x) / glm::length(axis);
        struct Side {
            double angle;
            bool forward;
            std::uint32_t half_edge;
        };
        std::vector<Side> sides;
        sides.reserve(half_edges.size());
        int balance = 0;
        for (const std::uint32_t h : half_edges) {
            const glm::dvec3 out =
                glm::dvec3(positions_[start_of(triangles_, previous_half_edge(h))]) - low;
            const bool forward = start_of(triangles_, h) == a;
            balance += forward ? 1 : -1;
            sides.push_back({std::atan2(glm::dot(out, y), glm::dot(out, x)), forward, h});
        }
        std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
            return p.angle != q.angle ? p.angle > q.angle : p.half_edge < q.half_edge;
        });
        if (balance == 0) {
            for (std::size_t i = 0; i < sides.size(); ++i) {
                const Side& next = sides[(i + 1) % sides.size()];
                if (sides[i].forward && !next.forward) join(sides[i].half_edge, next.half_edge);
            }
            return;
        }
        const Side* best[2] = {nullptr, nullptr};
        double flattest = -1;
        for (const Side& p : sides) {
            for (const Side& q : sides) {
                const double bend = std::abs(std::sin((p.angle - q.angle) / 2));  // 1: a plane
                if (p.forward && !q.forward && bend > flattest) {
                    flattest = bend;
                    best[0] = &p;
                    best[1] = &q;
                }
            }
        }
        if (best[0] != nullptr) join(best[0]->half_edge, best[1]->half_edge);
    }

    const std::vector<Triangle>& triangles_;
    const std::vector<glm::vec3>& positions_;
    bool strict_;
    std::vector<std::uint32_t>& twin_;
    std::vector<Entry> seen_;
};

}  // namespace

HalfEdges link_half_edges(const TriangleMesh& mesh, bool strict) {
    const std::size_t vertices = mesh.positions.size();
    std::vector<std::uint32_t> first(vertices + 1, 0);
    for (const Triangle& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) ++first[std::min(t[k], t[(k + 1) % 3])];
    }
    std::exclusive_scan(first.begin(), first.end(), first.begin(), std::uint32_t{0});
    std::vector<Entry> entries(3 * mesh.triangles.size());
    std::uint32_t h = 0;
    for (const Triangle& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k, ++h) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            entries[first[std::min(a, b)]++] = {std::max(a, b), h};
        }
    }
    // Now first[v] is where the list of v ends.
    HalfEdges out;
    out.twin.assign(3 * mesh.triangles.size(), no_half_edge);
    std::vector<std::uint32_t> duplicates;
    std::mutex guard;
    parallel_for(vertices, 65536, [&](std::size_t begin, std::size_t end) {
        EdgeRange range(mesh, strict, out.twin);
        for (std::size_t v = begin; v < end; ++v) {
            Entry* const from = entries.data() + (v == 0 ? 0 : first[v - 1]);
            Entry* const to = entries.data() + first[v];
            sort_entries(from, to);
            for (Entry* e = from; e < to;) {
                Entry* last = e + 1;
                while (last < to && last->other == e->other) ++last;
                range.edge(e, last);
                e = last;
            }
        }
        const std::lock_guard lock(guard);
        out.same_way += range.same_way;
        out.crowded.insert(out.crowded.end(), range.crowded.begin(), range.crowded.end());
        duplicates.insert(duplicates.end(), range.duplicates.begin(), range.duplicates.end());
    });
    // Ranges end in any order.
    std::sort(out.crowded.begin(), out.crowded.end());
    if (!duplicates.empty()) {
        out.duplicate.assign(mesh.triangles.size(), 0);
        for (const std::uint32_t t : duplicates) out.duplicate[t] = 1;
        out.duplicates = duplicates.size();
    }
    return out;
}

}  // namespace togishi
