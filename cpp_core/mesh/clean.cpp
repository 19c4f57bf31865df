#include "mesh/clean.hpp"

#include <array>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "mesh/clean_steps.hpp"
#include "mesh/components.hpp"

namespace togishi {

void remove_marked(TriangleMesh& mesh, const std::vector<std::uint8_t>& drop) {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (drop[t] == 0) mesh.triangles[kept++] = mesh.triangles[t];
    }
    mesh.triangles.resize(kept);
}

void remove_unused_vertices(TriangleMesh& mesh, CleanReport& report) {
    const std::size_t count = mesh.positions.size();
    constexpr std::uint32_t unused = 0xffffffffU;
    std::vector<std::uint32_t> place(count, unused);
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) place[v] = 0;
    }
    std::uint32_t kept = 0;
    for (std::size_t v = 0; v < count; ++v) {
        if (place[v] == unused) continue;
        mesh.positions[kept] = mesh.positions[v];
        if (!mesh.colours.empty()) mesh.colours[kept] = mesh.colours[v];
        place[v] = kept++;
    }
    if (kept == count) return;
    report.unused_vertices += count - kept;
    mesh.positions.resize(kept);
    if (!mesh.colours.empty()) mesh.colours.resize(kept);
    for (Triangle& t : mesh.triangles) {
        for (std::uint32_t& v : t) v = place[v];
    }
}

void turn_outward(TriangleMesh& mesh, CleanReport& report) {
    const Components pieces = find_components(mesh);
    struct Sum {
        double volume = 0, area = 0;
        glm::dvec3 centre{0, 0, 0};
        std::size_t triangles = 0;
        glm::dvec3 directed{0, 0, 0};  ///< zero where the piece is closed
    };
    std::vector<Sum> sums(pieces.count);
    // Two passes: volumes are told from the piece's own middle, or open pieces far from the origin
    // would get any sign.
    const auto corners = [&](const Triangle& t) {
        return std::array<glm::dvec3, 3>{mesh.positions[t[0]], mesh.positions[t[1]],
                                         mesh.positions[t[2]]};
    };
    for (const Triangle& t : mesh.triangles) {
        Sum& sum = sums[pieces.of_vertex[t[0]]];
        const auto [a, b, c] = corners(t);
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const double area = 0.5 * glm::length(normal);
        sum.area += area;
        sum.centre += area / 3 * (a + b + c);
        sum.directed += 0.5 * normal;
        ++sum.triangles;
    }
    for (Sum& sum : sums) {
        if (sum.area > 0) sum.centre /= sum.area;
    }
    for (const Triangle& t : mesh.triangles) {
        Sum& sum = sums[pieces.of_vertex[t[0]]];
        const auto [a, b, c] = corners(t);
        sum.volume += glm::dot(a - sum.centre, glm::cross(b - sum.centre, c - sum.centre)) / 6;
    }
    std::vector<std::uint8_t> reverse(pieces.count, 0);
    bool any = false;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const Sum& sum = sums[i];
        if (sum.triangles == 0) continue;
        // What an open piece lacks of a closed one shows in its directed area.
        const bool sheet = glm::length(sum.directed) > 0.2 * sum.area;
        const bool flat = std::abs(sum.volume) < 1e-3 * sum.area * std::sqrt(sum.area);
        if (sheet && flat) {
            ++report.undecided_pieces;
        } else if (sum.volume < 0) {
            reverse[i] = 1;
            any = true;
            ++report.reversed_pieces;
        }
    }
    if (!any) return;
    for (Triangle& t : mesh.triangles) {
        if (reverse[pieces.of_vertex[t[0]]] != 0) std::swap(t[1], t[2]);
    }
}

CleanReport clean(TriangleMesh& mesh, const CleanOptions& options) {
    if (!std::isfinite(options.weld_distance) || options.weld_distance < 0) {
        throw InputError("cleaning", "weld_distance", std::to_string(options.weld_distance),
                         "a finite number of at least 0");
    }
    CleanReport report;
    report.vertices_before = mesh.positions.size();
    report.triangles_before = mesh.triangles.size();
    weld(mesh, options.weld_distance, report);
    remove_flat_triangles(mesh, report);
    HalfEdges edges = link_half_edges(mesh, false);
    if (edges.duplicates > 0) {
        report.duplicate_triangles = edges.duplicates;
        remove_marked(mesh, edges.duplicate);
        edges = link_half_edges(mesh, false);
    }
    if (edges.same_way > 0) agree_windings(mesh, edges, report);
    if (edges.same_way > 0 || !edges.crowded.empty()) edges = link_half_edges(mesh, true);
    part_surfaces(mesh, std::move(edges), report);
    remove_unused_vertices(mesh, report);
    turn_outward(mesh, report);
    report.vertices_after = mesh.positions.size();
    report.triangles_after = mesh.triangles.size();
    return report;
}

}  // namespace togishi
