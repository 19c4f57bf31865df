// A mesh as a scanner would deliver it of known cross-sections: closed, its vertices nowhere on the
// blade's ridges, in any pose.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/triangle_mesh.hpp"
#include "scanned/stations.hpp"

namespace togishi {

struct SectionScan {
    std::size_t rows = 600, columns = 80;
    /// mm outwards at (arc length, t from the ridge, omote); empty: the surface itself.
    std::function<double(double, double, bool)> relief;
    BladePose pose;
};

inline TriangleMesh section_scan(const ScannedStations& stations, const SectionScan& scan) {
    // Once around each section: down omote, up ura.
    struct Loop {
        std::vector<glm::dvec3> places;
        std::vector<double> length;
        double edge_mm = 0;
    };
    std::vector<Loop> loops;
    for (const Station& s : stations.stations) {
        Loop loop;
        const glm::dvec3 out = glm::cross(s.along, s.across);
        for (const std::size_t side : {0U, 1U}) {
            std::vector<glm::dvec2> outline = s.side[side].outline_mm;
            if (side == 1) std::reverse(outline.begin(), outline.end());
            for (const glm::dvec2& p : outline) {
                const glm::dvec3 place =
                    s.ridge_mm + s.across * p.x + out * (side == 0 ? p.y : -p.y);
                loop.length.push_back(loop.places.empty()
                                          ? 0
                                          : loop.length.back() +
                                                glm::distance(place, loop.places.back()));
                loop.places.push_back(place);
            }
            if (side == 0) loop.edge_mm = loop.length.back();
        }
        loops.push_back(std::move(loop));
    }
    auto around = [&](std::size_t station, double share, double arc) {
        const Loop& loop = loops[station];
        const double total = loop.length.back();
        const double at = (share - std::floor(share)) * total;
        const auto k = static_cast<std::size_t>(
            std::upper_bound(loop.length.begin() + 1, loop.length.end() - 1, at) -
            loop.length.begin());
        const double piece = loop.length[k] - loop.length[k - 1];
        const double f = piece > 0 ? std::clamp((at - loop.length[k - 1]) / piece, 0.0, 1.0) : 0;
        glm::dvec3 place = glm::mix(loop.places[k - 1], loop.places[k], f);
        if (scan.relief) {
            const glm::dvec3 out =
                glm::cross(stations.stations[station].along, loop.places[k] - loop.places[k - 1]);
            const bool omote = at <= loop.edge_mm;
            if (glm::length(out) > 1e-9)
                place += glm::normalize(out) * scan.relief(arc, omote ? at : total - at, omote);
        }
        return place;
    };
    const std::vector<Station>& s = stations.stations;
    std::vector<glm::dvec3> places;
    places.reserve(scan.rows * scan.columns + 2);
    const auto last = static_cast<double>(s.size() - 1);
    for (std::size_t r = 0; r < scan.rows; ++r) {
        // The ends themselves are points of their own.
        const double x = last * (static_cast<double>(r) + 0.5) / static_cast<double>(scan.rows);
        const auto i = std::min(static_cast<std::size_t>(x), s.size() - 2);
        const double f = x - static_cast<double>(i);
        const double arc = s[i].s_mm + f * (s[i + 1].s_mm - s[i].s_mm);
        for (std::size_t c = 0; c < scan.columns; ++c) {
            const double share =
                (static_cast<double>(c) + 0.37 + 0.5 * static_cast<double>(r % 2)) /
                static_cast<double>(scan.columns);
            places.push_back(glm::mix(around(i, share, arc), around(i + 1, share, arc), f));
        }
    }
    auto middle = [&](std::size_t row) {
        glm::dvec3 sum(0);
        for (std::size_t c = 0; c < scan.columns; ++c) sum += places[row * scan.columns + c];
        return sum / static_cast<double>(scan.columns);
    };
    const auto begin = static_cast<std::uint32_t>(places.size());
    places.push_back(middle(0));
    places.push_back(s.back().ridge_mm);

    TriangleMesh mesh;
    const glm::dmat3 back = glm::transpose(scan.pose.rotation);
    mesh.origin = back * glm::dvec3(300, 0, 0) + scan.pose.origin_mm;
    mesh.positions.reserve(places.size());
    for (const glm::dvec3& p : places)
        mesh.positions.emplace_back(back * p + scan.pose.origin_mm - mesh.origin);
    auto at = [&](std::size_t r, std::size_t c) {
        return static_cast<std::uint32_t>(r * scan.columns + c % scan.columns);
    };
    for (std::size_t r = 0; r + 1 < scan.rows; ++r) {
        for (std::size_t c = 0; c < scan.columns; ++c) {
            const std::size_t shift = r % 2;  // the next row begins half a column on or back
            if (shift == 0) {
                mesh.triangles.push_back({at(r, c), at(r, c + 1), at(r + 1, c)});
                mesh.triangles.push_back({at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)});
            } else {
                mesh.triangles.push_back({at(r, c), at(r + 1, c + 1), at(r + 1, c)});
                mesh.triangles.push_back({at(r, c), at(r, c + 1), at(r + 1, c + 1)});
            }
        }
    }
    for (std::size_t c = 0; c < scan.columns; ++c) {
        mesh.triangles.push_back({begin, at(0, c + 1), at(0, c)});
        mesh.triangles.push_back({begin + 1, at(scan.rows - 1, c), at(scan.rows - 1, c + 1)});
    }
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

/// Some pose far from any axis, with an offset.
inline BladePose tilted_pose(const glm::dvec3& origin_mm) {
    auto turn = [](int axis, double angle) {
        glm::dmat3 m(1);
        const int a = (axis + 1) % 3;
        const int b = (axis + 2) % 3;
        m[a][a] = std::cos(angle);
        m[a][b] = std::sin(angle);
        m[b][a] = -std::sin(angle);
        m[b][b] = std::cos(angle);
        return m;
    };
    return {turn(0, 0.7) * turn(1, -1.9) * turn(2, 2.6), origin_mm};
}

}  // namespace togishi
