#include <utility>

#include "mesh/clean_steps.hpp"

namespace togishi {

void agree_windings(TriangleMesh& mesh, HalfEdges& edges, CleanReport& report) {
    constexpr std::uint8_t unseen = 2;
    std::vector<std::uint8_t> turn(mesh.triangles.size(), unseen);
    std::vector<std::uint32_t> reached;  // of one surface, in the order of their reaching
    for (std::uint32_t seed = 0; seed < turn.size(); ++seed) {
        if (turn[seed] != unseen) continue;
        reached.assign(1, seed);
        turn[seed] = 0;
        std::size_t turned = 0;
        for (std::size_t i = 0; i < reached.size(); ++i) {
            const std::uint32_t t = reached[i];
            turned += turn[t];
            for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
                const std::uint32_t twin = edges.twin[h];
                if (twin == no_half_edge) continue;
                const bool same = start_of(mesh.triangles, h) == start_of(mesh.triangles, twin);
                const auto wanted = static_cast<std::uint8_t>(turn[t] ^ (same ? 1U : 0U));
                std::uint8_t& other = turn[twin / 3];
                if (other == unseen) {
                    other = wanted;
                    reached.push_back(twin / 3);
                } else if (other != wanted) {
                    edges.twin[h] = edges.twin[twin] = no_half_edge;
                    ++report.one_sided_edges;
                }
            }
        }
        // The smaller part is turned.
        const bool swap = 2 * turned > reached.size();
        report.flipped_triangles += swap ? reached.size() - turned : turned;
        for (const std::uint32_t t : reached) turn[t] ^= swap ? 1U : 0U;
    }
    for (std::size_t t = 0; t < turn.size(); ++t) {
        if (turn[t] == 1) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    }
}

}  // namespace togishi
