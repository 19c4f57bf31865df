#include "scanned/surface_samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/random_normal.hpp"
#include "mesh/components.hpp"

namespace togishi {
namespace {

// Of a triangle's number, even in [0, 1).
double dither(std::uint64_t i) {
    return RandomNormal(i * 0x9e3779b97f4a7c15U).uniform();
}

}  // namespace

MeshPieces find_pieces(const TriangleMesh& mesh) {
    const Components found = find_components(mesh);
    constexpr std::uint32_t none = 0xffffffffU;
    std::vector<std::uint32_t> number(found.count, none);
    MeshPieces result;
    result.of.resize(mesh.triangles.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const Triangle& t = mesh.triangles[f];
        const std::uint32_t r = found.of_vertex[t[0]];
        if (number[r] == none) {
            number[r] = static_cast<std::uint32_t>(result.pieces.size());
            const glm::dvec3 p(mesh.positions[t[0]]);
            result.pieces.push_back({0, p, p, 0});
        }
        MeshPiece& piece = result.pieces[number[r]];
        result.of[f] = number[r];
        piece.area_mm2 += triangle_area(mesh, t);
        ++piece.triangles;
        for (const std::uint32_t v : t) {
            piece.low = glm::min(piece.low, glm::dvec3(mesh.positions[v]));
            piece.high = glm::max(piece.high, glm::dvec3(mesh.positions[v]));
        }
    }
    std::vector<std::uint32_t> order(result.pieces.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return result.pieces[a].area_mm2 > result.pieces[b].area_mm2;
    });
    std::vector<std::uint32_t> rank(order.size());
    std::vector<MeshPiece> sorted;
    sorted.reserve(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        rank[order[i]] = static_cast<std::uint32_t>(i);
        sorted.push_back(result.pieces[order[i]]);
    }
    result.pieces = std::move(sorted);
    for (std::uint32_t& piece : result.of) piece = rank[piece];
    return result;
}

std::vector<SurfaceSample> sample_surface(
    const TriangleMesh& mesh, const MeshPieces& pieces, std::span<const char> wanted,
    const std::function<double(const glm::dvec3& middle)>& per_mm2) {
    std::vector<SurfaceSample> samples;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        if (wanted[pieces.of[f]] == 0) continue;
        const Triangle& t = mesh.triangles[f];
        const glm::dvec3 middle =
            (glm::dvec3(mesh.positions[t[0]]) + glm::dvec3(mesh.positions[t[1]]) +
             glm::dvec3(mesh.positions[t[2]])) /
            3.0;
        const auto n = static_cast<int>(triangle_area(mesh, t) * per_mm2(middle) + dither(f));
        const auto triangle = static_cast<std::uint32_t>(f);
        if (n == 1) {
            samples.push_back({triangle, {1.0F / 3, 1.0F / 3}});
            continue;
        }
        // Additive recurrence with the plastic number: even over a square, folded to the triangle.
        for (int i = 0; i < n; ++i) {
            double b = std::fmod(0.5 + 0.7548776662466927 * (i + 1), 1.0);
            double c = std::fmod(0.5 + 0.5698402909980532 * (i + 1), 1.0);
            if (b + c > 1) {
                b = 1 - b;
                c = 1 - c;
            }
            samples.push_back({triangle, {static_cast<float>(b), static_cast<float>(c)}});
        }
    }
    return samples;
}

std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, const MeshPieces& pieces,
                                          std::span<const char> wanted, double count) {
    double total = 0;
    for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
        if (wanted[i] != 0) total += pieces.pieces[i].area_mm2;
    }
    if (!(total > 0)) return {};
    return sample_surface(mesh, pieces, wanted, [&](const glm::dvec3&) { return count / total; });
}

}  // namespace togishi
