#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "mesh/clean_steps.hpp"
#include "mesh/point_index.hpp"

namespace togishi {
namespace {

/// The first vertex within `distance` becomes the place of all later ones there. Cells of that
/// size: a neighbour lies in one of 27.
std::vector<std::uint32_t> near_places(const TriangleMesh& mesh, double distance) {
    const auto hash = [](const std::array<std::int64_t, 3>& cell) {
        std::uint64_t h = 0;
        for (const std::int64_t c : cell)
            h = (h ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15ULL, h ^= h >> 29U;
        return h;
    };
    // Heads of chains of kept vertices that share a cell's hash; chains of strangers are harmless.
    std::vector<std::uint32_t> head(std::bit_ceil(mesh.positions.size() + 16), no_half_edge);
    std::vector<std::uint32_t> next(mesh.positions.size(), no_half_edge),
        place(mesh.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const glm::dvec3 p = mesh.positions[v];
        std::array<std::int64_t, 3> cell{};
        // A float holds no more than 2^24 steps apart from 0: cells of less than that do not
        // differ.
        for (int i = 0; i < 3; ++i)
            cell[static_cast<std::size_t>(i)] =
                static_cast<std::int64_t>(std::clamp(p[i] / distance, -9e15, 9e15));
        std::uint32_t found = v;
        for (int n = 0; n < 27; ++n) {
            const std::array<std::int64_t, 3> at{cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1,
                                                 cell[2] + n / 9 - 1};
            for (std::uint32_t o = head[hash(at) & (head.size() - 1)]; o != no_half_edge;
                 o = next[o]) {
                if (o < found && glm::length(glm::dvec3(mesh.positions[o]) - p) <= distance)
                    found = o;
            }
        }
        place[v] = found;
        if (found == v) {
            std::uint32_t& first = head[hash(cell) & (head.size() - 1)];
            next[v] = first;
            first = v;
        }
    }
    return place;
}

bool flat(const TriangleMesh& mesh, const Triangle& t) {
    const glm::dvec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const glm::dvec3 ab = b - a, ac = c - a, bc = c - b;
    const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
    const glm::dvec3 normal = glm::cross(ab, ac);
    // Height below a millionth of the length: a float's own steps.
    return glm::dot(normal, normal) <= 1e-12 * longest * longest;
}

std::size_t longest_edge(const TriangleMesh& mesh, const Triangle& t) {
    std::size_t best = 0;
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec3 d =
            glm::dvec3(mesh.positions[t[(k + 1) % 3]]) - glm::dvec3(mesh.positions[t[k]]);
        if (glm::dot(d, d) > most) {
            most = glm::dot(d, d);
            best = k;
        }
    }
    return best;
}

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
}

/// One round: returns the number of flat triangles that are left.
std::size_t split_round(TriangleMesh& mesh, std::vector<std::uint8_t>& is_flat,
                        CleanReport& report) {
    std::unordered_map<std::uint64_t, std::uint32_t> by_edge;  // longest edge of a flat triangle
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (is_flat[t] == 0) continue;
        const Triangle& f = mesh.triangles[t];
        const std::size_t k = longest_edge(mesh, f);
        by_edge.emplace(edge_key(f[k], f[(k + 1) % 3]), t);
    }
    std::vector<std::uint8_t> drop = is_flat;
    const std::size_t before = mesh.triangles.size();
    std::size_t left = 0;
    for (std::size_t t = 0; t < before; ++t) {
        if (is_flat[t] != 0) continue;
        const Triangle whole = mesh.triangles[t];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = by_edge.find(edge_key(whole[k], whole[(k + 1) % 3]));
            if (found == by_edge.end()) continue;
            const Triangle& f = mesh.triangles[found->second];
            const std::uint32_t middle = f[(longest_edge(mesh, f) + 2) % 3];
            if (middle == whole[(k + 2) % 3]) continue;
            Triangle near = whole, far = whole;
            near[(k + 1) % 3] = middle;
            far[k] = middle;
            by_edge.erase(found);
            mesh.triangles[t] = near;
            mesh.triangles.push_back(far);
            is_flat[t] = flat(mesh, near) ? 1 : 0;
            drop[t] = 0;
            is_flat.push_back(flat(mesh, far) ? 1 : 0);
            drop.push_back(0);
            left += is_flat[t] + is_flat.back();
            ++report.split_at_degenerate;
            break;
        }
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < drop.size(); ++t) {
        if (drop[t] == 0) is_flat[kept++] = is_flat[t];
    }
    report.degenerate_triangles += drop.size() - kept;
    is_flat.resize(kept);
    remove_marked(mesh, drop);
    return left;
}

}  // namespace

void weld(TriangleMesh& mesh, double distance, CleanReport& report) {
    const std::size_t count = mesh.positions.size();
    std::vector<std::uint32_t> place(count);
    if (distance > 0) {
        place = near_places(mesh, distance);
    } else {
        std::vector<glm::vec3> points;
        points.reserve(count);
        PointIndex index(count);
        std::vector<std::uint32_t> first;
        first.reserve(count);
        for (std::uint32_t v = 0; v < count; ++v) {
            const std::uint32_t n = index.add(mesh.positions[v], points);
            if (n == first.size()) first.push_back(v);
            place[v] = first[n];
        }
    }
    for (std::uint32_t v = 0; v < count; ++v) report.welded_vertices += place[v] != v ? 1 : 0;
    std::size_t kept = 0;
    for (Triangle t : mesh.triangles) {
        if (report.welded_vertices > 0) {
            for (std::uint32_t& v : t) v = place[v];
        }
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        mesh.triangles[kept++] = t;
    }
    report.degenerate_triangles += mesh.triangles.size() - kept;
    mesh.triangles.resize(kept);
    if (report.welded_vertices == 0) return;
    // The vertices welded away are in no triangle any more: told apart from those that never were.
    std::uint32_t to = 0;
    std::vector<std::uint32_t> moved(count);
    for (std::uint32_t v = 0; v < count; ++v) {
        if (place[v] != v) continue;
        mesh.positions[to] = mesh.positions[v];
        if (!mesh.colours.empty()) mesh.colours[to] = mesh.colours[v];
        moved[v] = to++;
    }
    mesh.positions.resize(to);
    if (!mesh.colours.empty()) mesh.colours.resize(to);
    for (Triangle& t : mesh.triangles) {
        for (std::uint32_t& v : t) v = moved[v];
    }
}

void remove_flat_triangles(TriangleMesh& mesh, CleanReport& report) {
    std::vector<std::uint8_t> is_flat(mesh.triangles.size());
    std::size_t left = 0;
    for (std::size_t t = 0; t < is_flat.size(); ++t) {
        is_flat[t] = flat(mesh, mesh.triangles[t]) ? 1 : 0;
        left += is_flat[t];
    }
    // What a split leaves flat again has a shorter longest edge; a handful of rounds end it.
    for (int round = 0; left > 0 && round < 16; ++round) left = split_round(mesh, is_flat, report);
    if (left > 0) {
        report.degenerate_triangles += left;
        remove_marked(mesh, is_flat);
    }
}

}  // namespace togishi
