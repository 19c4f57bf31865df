#include "mesh/pieces.hpp"

#include <algorithm>
#include <limits>

#include "mesh/components.hpp"

namespace togishi {

std::vector<Piece> sort_into_pieces(TriangleMesh& mesh) {
    const Components found = find_components(mesh);
    std::vector<Piece> pieces(found.count);
    constexpr double far = std::numeric_limits<double>::infinity();
    for (Piece& p : pieces) {
        p.low = glm::dvec3(far);
        p.high = glm::dvec3(-far);
    }
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        Piece& p = pieces[found.of_vertex[v]];
        const glm::dvec3 at = mesh.origin + glm::dvec3(mesh.positions[v]);
        p.low = glm::min(p.low, at);
        p.high = glm::max(p.high, at);
        ++p.vertex_count;
    }
    for (const Triangle& t : mesh.triangles) {
        Piece& p = pieces[found.of_vertex[t[0]]];
        p.area += triangle_area(mesh, t);
        ++p.triangle_count;
    }
    std::vector<std::uint32_t> order(pieces.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return pieces[a].area > pieces[b].area;
    });
    std::vector<Piece> sorted;
    sorted.reserve(pieces.size());
    std::size_t triangle = 0, vertex = 0;
    for (const std::uint32_t i : order) {
        Piece& p = pieces[i];
        if (p.triangle_count == 0) p.vertex_count = 0;  // a vertex in no triangle
        p.first_triangle = triangle;
        p.first_vertex = vertex;
        triangle += p.triangle_count;
        vertex += p.vertex_count;
        if (p.triangle_count > 0) sorted.push_back(p);
    }
    if (sorted.size() == 1 && vertex == mesh.positions.size()) return sorted;
    std::vector<std::size_t> next_vertex(pieces.size()), next_triangle(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        next_vertex[i] = pieces[i].first_vertex;
        next_triangle[i] = pieces[i].first_triangle;
    }
    std::vector<std::uint32_t> place(mesh.positions.size());
    std::vector<glm::vec3> positions(vertex);
    std::vector<Colour8> colours(mesh.colours.empty() ? 0 : vertex);
    for (std::size_t v = 0; v < place.size(); ++v) {
        const std::uint32_t i = found.of_vertex[v];
        if (pieces[i].triangle_count == 0) continue;
        place[v] = static_cast<std::uint32_t>(next_vertex[i]++);
        positions[place[v]] = mesh.positions[v];
        if (!colours.empty()) colours[place[v]] = mesh.colours[v];
    }
    mesh.positions = std::move(positions);
    mesh.colours = std::move(colours);
    std::vector<Triangle> triangles(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        triangles[next_triangle[found.of_vertex[t[0]]]++] = {place[t[0]], place[t[1]], place[t[2]]};
    }
    mesh.triangles = std::move(triangles);
    return sorted;
}

TriangleMesh take_piece(const TriangleMesh& mesh, const Piece& piece) {
    const auto run = [](const auto& all, std::size_t first, std::size_t count) {
        const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
        return std::decay_t<decltype(all)>(begin, begin + static_cast<std::ptrdiff_t>(count));
    };
    TriangleMesh out;
    out.origin = mesh.origin;
    out.positions = run(mesh.positions, piece.first_vertex, piece.vertex_count);
    if (!mesh.colours.empty())
        out.colours = run(mesh.colours, piece.first_vertex, piece.vertex_count);
    out.triangles = run(mesh.triangles, piece.first_triangle, piece.triangle_count);
    const auto shift = static_cast<std::uint32_t>(piece.first_vertex);
    for (Triangle& t : out.triangles) {
        for (std::uint32_t& v : t) v -= shift;
    }
    return out;
}

}  // namespace togishi
