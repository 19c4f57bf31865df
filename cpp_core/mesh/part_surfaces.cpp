#include <algorithm>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "base/parallel.hpp"
#include "mesh/clean_steps.hpp"

namespace togishi {
namespace {

/// From a half-edge out of a vertex, the next one out of it, turning: over the edge before it.
std::uint32_t turn_left(const HalfEdges& edges, std::uint32_t h) {
    return edges.twin[previous_half_edge(h)];
}
std::uint32_t turn_right(const HalfEdges& edges, std::uint32_t h) {
    const std::uint32_t twin = edges.twin[h];
    return twin == no_half_edge ? no_half_edge : next_half_edge(twin);
}

/// Calls visit(h) for the half-edges out of a vertex in the fan of `h`.
template <class Visit>
void walk_fan(const HalfEdges& edges, std::uint32_t h, const Visit& visit) {
    std::uint32_t at = h;
    do {
        visit(at);
        at = turn_left(edges, at);
    } while (at != no_half_edge && at != h);
    if (at == h) return;
    for (at = turn_right(edges, h); at != no_half_edge; at = turn_right(edges, at)) visit(at);
}

/// Vertices of more than one fan, ascending.
std::vector<std::uint32_t> find_touching(const TriangleMesh& mesh, const HalfEdges& edges) {
    const std::size_t count = mesh.positions.size();
    std::vector<std::uint32_t> degree(count, 0), some(count, no_half_edge);
    std::uint32_t h = 0;
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            ++degree[v];
            some[v] = h++;
        }
    }
    std::vector<std::uint32_t> found;
    std::mutex guard;
    parallel_for(count, 65536, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> mine;
        for (std::size_t v = begin; v < end; ++v) {
            if (degree[v] == 0) continue;
            std::uint32_t seen = 0;
            walk_fan(edges, some[v], [&](std::uint32_t) { ++seen; });
            if (seen < degree[v]) mine.push_back(static_cast<std::uint32_t>(v));
        }
        const std::lock_guard lock(guard);
        found.insert(found.end(), mine.begin(), mine.end());
    });
    std::sort(found.begin(), found.end());
    return found;
}

std::uint32_t copy_vertex(TriangleMesh& mesh, std::uint32_t v) {
    mesh.positions.push_back(glm::vec3(mesh.positions[v]));
    if (!mesh.colours.empty()) mesh.colours.push_back(Colour8(mesh.colours[v]));
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

/// Every fan but the first of each vertex gets a vertex of its own.
std::size_t split_fans(TriangleMesh& mesh, const HalfEdges& edges,
                       const std::vector<std::uint32_t>& touching) {
    std::vector<std::uint8_t> wanted(mesh.positions.size(), 0);
    for (const std::uint32_t v : touching) wanted[v] = 1;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> corners;  // vertex, half-edge out of it
    std::uint32_t h = 0;
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            if (wanted[v] != 0) corners.emplace_back(v, h);
            ++h;
        }
    }
    std::sort(corners.begin(), corners.end());
    std::unordered_map<std::uint32_t, std::uint32_t> fan_vertex;  // half-edge -> vertex of its fan
    fan_vertex.reserve(corners.size());
    std::size_t copies = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto [v, corner] = corners[i];
        if (fan_vertex.contains(corner)) continue;
        const bool first = i == 0 || corners[i - 1].first != v;
        const std::uint32_t own = first ? v : copy_vertex(mesh, v);
        copies += first ? 0 : 1;
        walk_fan(edges, corner, [&](std::uint32_t out) { fan_vertex[out] = own; });
    }
    for (const auto& [v, corner] : corners)
        mesh.triangles[corner / 3][corner % 3] = fan_vertex.at(corner);
    return copies;
}

/// Triangles at a crowded edge, but for the first and its twin, get corners of their own.
std::size_t tear_off(TriangleMesh& mesh, const HalfEdges& edges,
                     const std::vector<std::uint32_t>& edge) {
    std::size_t copies = 0;
    for (std::size_t i = 1; i < edge.size(); ++i) {
        if (edge[i] == edges.twin[edge[0]]) continue;
        for (const std::uint32_t h : {edge[i], next_half_edge(edge[i])}) {
            std::uint32_t& corner = mesh.triangles[h / 3][h % 3];
            corner = copy_vertex(mesh, corner);
            ++copies;
        }
    }
    return copies;
}

/// The last half-edge into the vertex that `h` leaves, turning away from `h`.
std::uint32_t end_of_fan(const HalfEdges& edges, std::uint32_t h) {
    std::uint32_t into = previous_half_edge(h);
    while (edges.twin[into] != no_half_edge) into = previous_half_edge(edges.twin[into]);
    return into;
}

/// Joins the half-edges of crowded edges that bound one fan at either end: the surface on one side
/// of the pinch, which gets a vertex of its own there. The others stay alone.
void join_beside_pinches(const TriangleMesh& mesh, HalfEdges& edges) {
    for (const auto& edge : edges.crowded) {
        for (const std::uint32_t h : edge) edges.twin[h] = no_half_edge;
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> joined;
    for (const auto& edge : edges.crowded) {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
        const std::uint32_t low = start_of(mesh.triangles, edge.front());
        for (const bool at_low : {true, false}) {
            if (2 * pairs.size() == edge.size()) break;
            pairs.clear();
            for (const std::uint32_t h : edge) {
                if ((start_of(mesh.triangles, h) == low) != at_low) continue;
                const std::uint32_t back = end_of_fan(edges, h);
                if (std::find(edge.begin(), edge.end(), back) != edge.end())
                    pairs.emplace_back(h, back);
            }
        }
        joined.insert(joined.end(), pairs.begin(), pairs.end());
    }
    for (const auto& [h, back] : joined) {
        edges.twin[h] = back;
        edges.twin[back] = h;
    }
}

}  // namespace

void part_pinches(TriangleMesh& mesh) {
    HalfEdges edges = link_half_edges(mesh, true);
    while (!edges.crowded.empty()) {
        const std::size_t before = edges.crowded.size();
        join_beside_pinches(mesh, edges);
        split_fans(mesh, edges, find_touching(mesh, edges));
        edges = link_half_edges(mesh, true);
        if (edges.crowded.size() >= before) return;
    }
}

void part_surfaces(TriangleMesh& mesh, HalfEdges edges, CleanReport& report) {
    report.non_manifold_edges = edges.crowded.size() - edges.same_way;
    for (bool first = true;; first = false) {
        const auto touching = find_touching(mesh, edges);
        if (first) report.non_manifold_vertices = touching.size();
        std::size_t copies = 0;
        if (!touching.empty()) {
            copies = split_fans(mesh, edges, touching);
        } else {
            // No fan tells these apart: a surface that runs into itself.
            for (const auto& edge : edges.crowded) copies += tear_off(mesh, edges, edge);
            if (copies == 0) return;
        }
        report.vertices_split_off += copies;
        edges = link_half_edges(mesh, true);
    }
}

}  // namespace togishi
