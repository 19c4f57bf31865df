#include "mesh/simplify.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>

#include <meshoptimizer/meshoptimizer.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "mesh/clean_steps.hpp"
#include "mesh/components.hpp"

namespace togishi {
namespace {

constexpr const char* where = "simplification";

void check(const TriangleMesh& mesh, const SimplifyOptions& o) {
    const auto fail = [](const char* field, const std::string& found, const std::string& allowed) {
        throw InputError(where, field, found, allowed);
    };
    const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
    if (triangles == 0) fail("triangles", "0", "a surface of one triangle at least");
    if (o.stretch_triangles < 1000)
        fail("stretch_triangles", std::to_string(o.stretch_triangles), "at least 1000");
    if (!std::isfinite(o.error_mm) || o.error_mm <= 0)
        fail("error_mm", std::to_string(o.error_mm), "a distance above 0 mm");
    if (!o.locked.empty() && o.locked.size() != vertices)
        fail("locked", std::to_string(o.locked.size()) + " flags",
             "one for each of " + std::to_string(vertices) + " vertices");
    if (!o.part.empty() && o.part.size() != triangles)
        fail("part", std::to_string(o.part.size()) + " labels",
             "one for each of " + std::to_string(triangles) + " triangles");
    if (o.attribute_count > 16)
        fail("attribute_count", std::to_string(o.attribute_count), "at most 16");
    if (o.attributes.size() != vertices * o.attribute_count ||
        o.attribute_weights.size() != o.attribute_count)
        fail("attributes", std::to_string(o.attributes.size()) + " values",
             "vertices x attribute_count, and as many weights as attributes");
    for (const float w : o.attribute_weights) {
        if (!std::isfinite(w) || w < 0) fail("attribute_weights", std::to_string(w), "0 or more");
    }
}

/// The mesh as meshoptimizer takes it: where parts meet, each has vertices of its own at one place,
/// which it holds together as a seam.
struct Prepared {
    std::vector<std::uint32_t> indices;
    std::vector<glm::vec3> added;       ///< positions after the mesh's own
    std::vector<std::uint32_t> source;  ///< of the added ones
    std::vector<std::uint8_t> part_of;  ///< vertex -> part; empty without parts
};

Prepared prepare(const TriangleMesh& mesh, std::span<const std::uint8_t> part) {
    Prepared out;
    out.indices.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        out.indices.insert(out.indices.end(), t.begin(), t.end());
    if (part.empty()) return out;
    constexpr std::uint16_t none = 256;
    std::vector<std::uint16_t> first(mesh.positions.size(), none);
    std::unordered_map<std::uint64_t, std::uint32_t> others;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            std::uint32_t& v = out.indices[3 * t + k];
            if (first[v] == none) first[v] = part[t];
            if (first[v] == part[t]) continue;
            const auto [found, made] = others.try_emplace(
                std::uint64_t{v} << 8U | part[t],
                static_cast<std::uint32_t>(mesh.positions.size() + out.added.size()));
            if (made) {
                out.added.push_back(mesh.positions[v]);
                out.source.push_back(v);
            }
            v = found->second;
        }
    }
    out.part_of.resize(mesh.positions.size() + out.added.size());
    for (std::size_t i = 0; i < out.indices.size(); ++i) out.part_of[out.indices[i]] = part[i / 3];
    return out;
}

template <class T>
std::vector<T> with_added(std::span<const T> rows, std::size_t width,
                          const std::vector<std::uint32_t>& source) {
    std::vector<T> all(rows.begin(), rows.end());
    all.reserve(all.size() + width * source.size());
    for (const std::uint32_t v : source) {
        for (std::size_t k = 0; k < width; ++k) all.push_back(rows[v * width + k]);
    }
    return all;
}

/// Two triangles back to back, which a collapse can leave: both go, their neighbours meet. Vertices
/// that were in these alone stay unused.
void remove_flaps(SimplifiedMesh& light) {
    std::vector<Triangle>& triangles = light.mesh.triangles;
    struct Sorted {
        Triangle corners;
        std::uint32_t triangle;
    };
    std::vector<Sorted> sorted;
    sorted.reserve(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        Triangle c = triangles[t];
        std::sort(c.begin(), c.end());
        sorted.push_back({c, t});
    }
    std::sort(sorted.begin(), sorted.end(), [](const Sorted& a, const Sorted& b) {
        return a.corners != b.corners ? a.corners < b.corners : a.triangle < b.triangle;
    });
    std::vector<std::uint8_t> drop(triangles.size(), 0);
    bool any = false;
    for (std::size_t i = 1; i < sorted.size(); ++i) {
        const bool pair =
            sorted[i].corners == sorted[i - 1].corners && drop[sorted[i - 1].triangle] == 0;
        if (!pair) continue;
        drop[sorted[i].triangle] = drop[sorted[i - 1].triangle] = 1;
        any = true;
    }
    if (!any) return;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (drop[t] != 0) continue;
        triangles[kept] = triangles[t];
        if (!light.part.empty()) light.part[kept] = light.part[t];
        ++kept;
    }
    triangles.resize(kept);
    if (!light.part.empty()) light.part.resize(kept);
}

/// meshoptimizer's result as a mesh of its own.
SimplifiedMesh taken_out(const TriangleMesh& mesh, const Prepared& prepared,
                         std::span<const std::uint32_t> indices) {
    SimplifiedMesh out;
    out.mesh.origin = mesh.origin;
    out.mesh.triangles.reserve(indices.size() / 3);
    constexpr std::uint32_t none = 0xffffffffU;
    std::vector<std::uint32_t> place(mesh.positions.size(), none);
    const auto kept = [&](std::uint32_t index) {
        const std::uint32_t v =
            index < place.size() ? index : prepared.source[index - place.size()];
        if (place[v] == none) {
            place[v] = static_cast<std::uint32_t>(out.source_vertex.size());
            out.source_vertex.push_back(v);
        }
        return place[v];
    };
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        const Triangle t{kept(indices[i]), kept(indices[i + 1]), kept(indices[i + 2])};
        // Two vertices of a seam may have been brought to one place.
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        out.mesh.triangles.push_back(t);
        if (!prepared.part_of.empty()) out.part.push_back(prepared.part_of[indices[i]]);
    }
    remove_flaps(out);
    out.mesh.positions.reserve(out.source_vertex.size());
    for (const std::uint32_t v : out.source_vertex) out.mesh.positions.push_back(mesh.positions[v]);
    if (!mesh.colours.empty()) {
        out.mesh.colours.reserve(out.source_vertex.size());
        for (const std::uint32_t v : out.source_vertex) out.mesh.colours.push_back(mesh.colours[v]);
    }
    return out;
}

SimplifiedMesh once(const TriangleMesh& mesh, const SimplifyOptions& o, double estimate_mm) {
    const Prepared prepared = prepare(mesh, o.part);
    std::span<const glm::vec3> positions = mesh.positions;
    std::span<const float> attributes = o.attributes;
    std::span<const std::uint8_t> locked = o.locked;
    std::vector<glm::vec3> all_positions;
    std::vector<float> all_attributes;
    std::vector<std::uint8_t> all_locked;
    if (!prepared.added.empty()) {
        positions = all_positions = with_added(positions, 1, prepared.source);
        attributes = all_attributes = with_added(attributes, o.attribute_count, prepared.source);
        if (!locked.empty()) locked = all_locked = with_added(locked, 1, prepared.source);
    }
    std::vector<std::uint32_t> result(prepared.indices.size());
    unsigned options = meshopt_SimplifyErrorAbsolute;
    if (o.lock_border) options |= meshopt_SimplifyLockBorder;
    const std::size_t stride = std::max<std::size_t>(1, o.attribute_count) * sizeof(float);
    const std::size_t count = meshopt_simplifyWithAttributes(
        result.data(), prepared.indices.data(), prepared.indices.size(), &positions.data()->x,
        positions.size(), sizeof(glm::vec3), attributes.data(), stride, o.attribute_weights.data(),
        o.attribute_count, locked.empty() ? nullptr : locked.data(),
        std::min(3 * o.at_least, prepared.indices.size()), static_cast<float>(estimate_mm), options,
        nullptr);
    return taken_out(mesh, prepared, {result.data(), count});
}

/// A mesh's attributes for the vertices that are left of it.
struct Carried {
    Carried(const SimplifyOptions& from, const SimplifiedMesh& left) : options(from) {
        for (const std::uint32_t v : left.source_vertex) {
            if (!from.locked.empty()) locked.push_back(from.locked[v]);
            for (std::size_t k = 0; k < from.attribute_count; ++k)
                attributes.push_back(from.attributes[v * from.attribute_count + k]);
        }
        options.locked = locked;
        options.attributes = attributes;
        options.part = left.part;
    }
    Carried(const Carried&) = delete;
    Carried& operator=(const Carried&) = delete;

    SimplifyOptions options;
    std::vector<std::uint8_t> locked;
    std::vector<float> attributes;
};

/// Locks what lies beyond the bound, in either direction; returns how many vertices that were.
std::size_t lock_offenders(const TriangleMesh& mesh, const SurfaceTree& surface,
                           const TriangleMesh& light, double error_mm,
                           std::vector<std::uint8_t>& locked) {
    const auto bound = static_cast<float>(error_mm);
    std::size_t found = 0;
    const auto lock = [&](std::uint32_t v) {
        if (locked[v] == 0) ++found;
        locked[v] = 1;
    };
    const SurfaceTree light_surface(light);
    SurfaceTree::Search search{.enough = bound};
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const auto at = light_surface.nearest(mesh.positions[v], search);
        search.near = at.triangle;
        if (at.distance > bound) lock(v);
    }
    // Points on the light mesh, no farther apart than a few times the bound, at most 100 a
    // triangle.
    search.near = 0;
    for (const Triangle& t : light.triangles) {
        const glm::vec3 a = light.positions[t[0]], b = light.positions[t[1]];
        const glm::vec3 c = light.positions[t[2]];
        const float longest =
            std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
        const int steps = std::clamp(static_cast<int>(longest / (4 * bound)), 3, 5);
        for (int i = 0; i <= steps; ++i) {
            for (int k = 0; k + i <= steps; ++k) {
                const glm::vec3 p =
                    a + (static_cast<float>(i) * (b - a) + static_cast<float>(k) * (c - a)) /
                            static_cast<float>(steps);
                const auto at = surface.nearest(p, search);
                search.near = at.triangle;
                if (at.distance <= bound) continue;
                for (const std::uint32_t v : mesh.triangles[at.triangle]) lock(v);
            }
        }
    }
    return found;
}

/// What was locked since `before` gets its neighbours locked too: around a held vertex others give
/// way.
void lock_neighbours(const TriangleMesh& mesh, const std::vector<std::uint8_t>& before,
                     std::vector<std::uint8_t>& locked) {
    std::vector<std::uint8_t> wider = locked;
    for (const Triangle& t : mesh.triangles) {
        bool any = false;
        for (const std::uint32_t v : t) any = any || locked[v] != before[v];
        if (!any) continue;
        for (const std::uint32_t v : t) wider[v] = 1;
    }
    locked.swap(wider);
}

/// All vertices within the bound, by locking; fewer attempts: all but a few.
SimplifiedMesh within_bound(const TriangleMesh& mesh, SimplifyOptions options,
                            int most_attempts = 16) {
    std::vector<std::uint8_t> locked(options.locked.begin(), options.locked.end());
    locked.resize(mesh.positions.size(), 0);
    const bool hasty = most_attempts < 16;
    const SurfaceTree surface(mesh);
    double estimate_mm = options.error_mm;
    SimplifiedMesh out;
    for (int attempt = 1; attempt <= most_attempts; ++attempt) {
        options.locked = locked;
        out = once(mesh, options, estimate_mm);
        out.attempts = attempt;
        const std::vector<std::uint8_t> before = locked;
        // A piece smaller than the bound may vanish whole.
        if (!out.mesh.triangles.empty() &&
            lock_offenders(mesh, surface, out.mesh, options.error_mm, locked) == 0)
            return out;
        if (attempt == most_attempts && hasty && !out.mesh.triangles.empty()) return out;
        if (out.mesh.triangles.empty() || attempt > 12) estimate_mm *= 0.6;
        if (attempt > 1) lock_neighbours(mesh, before, locked);
    }
    // The mesh as it is keeps every bound.
    const Prepared whole = prepare(mesh, options.part);
    out = taken_out(mesh, whole, whole.indices);
    out.attempts = most_attempts;
    return out;
}

/// The stretches side by side again, by the vertices of `mesh`.
SimplifiedMesh joined(const TriangleMesh& mesh, const std::vector<SimplifiedMesh>& all) {
    SimplifiedMesh out;
    out.mesh.origin = mesh.origin;
    constexpr std::uint32_t none = 0xffffffffU;
    std::vector<std::uint32_t> place(mesh.positions.size(), none);
    for (const SimplifiedMesh& one : all) {
        out.attempts = std::max(out.attempts, one.attempts);
        out.part.insert(out.part.end(), one.part.begin(), one.part.end());
        for (Triangle t : one.mesh.triangles) {
            for (std::uint32_t& v : t) {
                const std::uint32_t source = one.source_vertex[v];
                if (place[source] == none) {
                    place[source] = static_cast<std::uint32_t>(out.source_vertex.size());
                    out.source_vertex.push_back(source);
                    out.mesh.positions.push_back(mesh.positions[source]);
                    if (!mesh.colours.empty()) out.mesh.colours.push_back(mesh.colours[source]);
                }
                v = place[source];
            }
            out.mesh.triangles.push_back(t);
        }
    }
    return out;
}

/// Vertices at an edge sharper than a right angle, where quadrics tell too little.
std::vector<std::uint8_t> at_sharp_edges(const TriangleMesh& mesh) {
    std::vector<glm::vec3> normal(mesh.positions.size(), glm::vec3(0));
    const auto of = [&](const Triangle& t) {
        const glm::vec3 n = glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                       mesh.positions[t[2]] - mesh.positions[t[0]]);
        return n / std::max(glm::length(n), 1e-30F);
    };
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) normal[v] += of(t);
    }
    std::vector<std::uint8_t> sharp(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles) {
        const glm::vec3 n = of(t);
        for (const std::uint32_t v : t) {
            if (glm::dot(n, normal[v]) < 0.6F * glm::length(normal[v])) sharp[v] = 1;
        }
    }
    return sharp;
}

/// The same of a very dense scan, whose single triangles face any way by noise alone: where the
/// normals within a fraction of a millimetre cancel.
std::vector<std::uint8_t> near_sharp_edges(const TriangleMesh& mesh) {
    constexpr float finest_mm = 0.4F;
    constexpr float least_share = 0.55F;
    double length = 0;
    for (const Triangle& t : mesh.triangles)
        length += double(glm::distance(mesh.positions[t[0]], mesh.positions[t[1]]));
    const float cell = std::max(
        finest_mm, 3 * static_cast<float>(length) / static_cast<float>(mesh.triangles.size()));
    const auto key = [&](const glm::vec3& p) {
        const glm::vec3 q = glm::floor(p / cell);
        const auto bits = [](float v) {
            return static_cast<std::uint64_t>(static_cast<std::int64_t>(v) + (1 << 20)) & 0x1fffffU;
        };
        return bits(q.x) | bits(q.y) << 21U | bits(q.z) << 42U;
    };
    struct Facing {
        glm::vec3 sum{0};
        float area = 0;
    };
    std::unordered_map<std::uint64_t, Facing> cells;
    for (const Triangle& t : mesh.triangles) {
        const glm::vec3 n = glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                       mesh.positions[t[2]] - mesh.positions[t[0]]);
        Facing& facing = cells[key(mesh.positions[t[0]])];
        facing.sum += n;
        facing.area += glm::length(n);
    }
    std::vector<std::uint8_t> sharp(mesh.positions.size(), 0);
    for (std::size_t v = 0; v < sharp.size(); ++v) {
        const auto found = cells.find(key(mesh.positions[v]));
        if (found == cells.end()) continue;
        const Facing& facing = found->second;
        if (glm::length(facing.sum) < least_share * facing.area) sharp[v] = 1;
    }
    return sharp;
}

/// One stretch as a mesh of its own; what it shares with others is locked.
struct Stretch {
    TriangleMesh mesh;
    std::vector<std::uint32_t> source;
    std::vector<std::uint8_t> locked, part;
    std::vector<float> attributes;
};

/// Stretches across the longest side, shifted by `shift` of a stretch. rough: sharp edges are
/// left as they are, few attempts.
SimplifiedMesh in_stretches(const TriangleMesh& mesh, const SimplifyOptions& options, double shift,
                            bool rough) {
    constexpr std::size_t very_many = 3'000'000;
    const bool unmeasured = rough && mesh.triangles.size() > very_many;
    const std::size_t count =
        std::max<std::size_t>(1, mesh.triangles.size() / options.stretch_triangles);
    glm::vec3 low(mesh.positions[0]), high(low);
    for (const glm::vec3& p : mesh.positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const glm::vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    // As many triangles in each: by the places of a sample of them.
    std::vector<float> places;
    places.reserve(mesh.triangles.size() / 16 + 1);
    const auto place = [&](const Triangle& t) { return mesh.positions[t[0]][axis]; };
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 16)
        places.push_back(place(mesh.triangles[t]));
    std::sort(places.begin(), places.end());
    std::vector<float> cuts;
    for (std::size_t i = 1; i <= count; ++i) {
        const double at = (static_cast<double>(i) - shift) / static_cast<double>(count);
        if (at < 1)
            cuts.push_back(
                places[static_cast<std::size_t>(at * static_cast<double>(places.size()))]);
    }
    std::vector<std::vector<std::uint32_t>> members(cuts.size() + 1);
    constexpr std::uint16_t nobody = 0xffff, shared = 0xfffe;
    std::vector<std::uint16_t> owner(mesh.positions.size(), nobody);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto cut = std::upper_bound(cuts.begin(), cuts.end(), place(mesh.triangles[t]));
        const auto stretch = static_cast<std::uint16_t>(cut - cuts.begin());
        members[stretch].push_back(t);
        for (const std::uint32_t v : mesh.triangles[t])
            owner[v] = owner[v] == nobody || owner[v] == stretch ? stretch : shared;
    }
    std::vector<SimplifiedMesh> done(members.size());
    parallel_for(members.size(), 1, [&](std::size_t begin, std::size_t) {
        Stretch own;
        own.mesh.origin = mesh.origin;
        std::unordered_map<std::uint32_t, std::uint32_t> place_of;
        place_of.reserve(members[begin].size());
        for (const std::uint32_t t : members[begin]) {
            Triangle mine{};
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = mesh.triangles[t][k];
                const auto [found, made] =
                    place_of.try_emplace(v, static_cast<std::uint32_t>(own.source.size()));
                mine[k] = found->second;
                if (!made) continue;
                own.source.push_back(v);
                own.mesh.positions.push_back(mesh.positions[v]);
                const bool given = !options.locked.empty() && options.locked[v] != 0;
                own.locked.push_back(owner[v] == shared || given ? 1 : 0);
                for (std::size_t a = 0; a < options.attribute_count; ++a)
                    own.attributes.push_back(options.attributes[v * options.attribute_count + a]);
            }
            own.mesh.triangles.push_back(mine);
            if (!options.part.empty()) own.part.push_back(options.part[t]);
        }
        members[begin] = {};
        if (own.mesh.triangles.empty()) return;
        if (rough) {
            const auto sharp = unmeasured ? near_sharp_edges(own.mesh) : at_sharp_edges(own.mesh);
            for (std::size_t v = 0; v < sharp.size(); ++v) own.locked[v] |= sharp[v];
        }
        SimplifyOptions here = options;
        here.locked = own.locked;
        here.part = own.part;
        here.attributes = own.attributes;
        here.at_least = options.at_least / members.size();
        // Most of a very dense scan's triangles go without a measured distance, within half of the
        // bound by the library's estimate; what is left is held to it.
        done[begin] = unmeasured ? once(own.mesh, here, options.error_mm)
                                 : within_bound(own.mesh, here, rough ? 2 : 8);
        for (std::uint32_t& v : done[begin].source_vertex) v = own.source[v];
        done[begin].mesh.positions = {};
    });
    return joined(mesh, done);
}

SimplifiedMesh simplified(const TriangleMesh& mesh, const SimplifyOptions& options) {
    if (mesh.triangles.size() <= 2 * options.stretch_triangles) return within_bound(mesh, options);
    SimplifyOptions first = options;
    first.error_mm = 0.5 * options.error_mm;
    const SimplifiedMesh rough = in_stretches(mesh, first, 0.0, true);
    const Carried carried(options, rough);
    SimplifyOptions second = carried.options;
    second.error_mm = 0.5 * options.error_mm;
    SimplifiedMesh out = in_stretches(rough.mesh, second, 0.5, false);
    for (std::uint32_t& v : out.source_vertex) v = rough.source_vertex[v];
    out.attempts = std::max(out.attempts, rough.attempts);
    return out;
}

/// Collapses may pinch the surface: an edge with four triangles. What is pinched off and smaller
/// than the bound goes.
void part_pinches(SimplifiedMesh& light, double error_mm) {
    const std::vector<Triangle> before = light.mesh.triangles;
    part_pinches(light.mesh);
    TriangleMesh& mesh = light.mesh;
    if (mesh.positions.size() == light.source_vertex.size()) return;
    light.source_vertex.resize(mesh.positions.size());
    std::vector<std::uint8_t> parted(mesh.positions.size(), 0);
    for (std::size_t t = 0; t < before.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t was = before[t][k];
            const std::uint32_t now = mesh.triangles[t][k];
            light.source_vertex[now] = light.source_vertex[was];
            if (now != was) parted[now] = parted[was] = 1;
        }
    }
    const Components components = find_components(mesh);
    struct Extent {
        glm::vec3 low{std::numeric_limits<float>::max()};
        glm::vec3 high{std::numeric_limits<float>::lowest()};
        bool parted = false;
    };
    std::vector<Extent> extents(components.count);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        Extent& extent = extents[components.of_vertex[v]];
        extent.low = glm::min(extent.low, mesh.positions[v]);
        extent.high = glm::max(extent.high, mesh.positions[v]);
        extent.parted = extent.parted || parted[v] != 0;
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Extent& extent = extents[components.of_vertex[mesh.triangles[t][0]]];
        if (extent.parted && double(glm::distance(extent.low, extent.high)) <= error_mm) continue;
        mesh.triangles[kept] = mesh.triangles[t];
        if (!light.part.empty()) light.part[kept] = light.part[t];
        ++kept;
    }
    if (kept == 0) return;
    mesh.triangles.resize(kept);
    if (!light.part.empty()) light.part.resize(kept);
}

}  // namespace

SimplifiedMesh simplify(const TriangleMesh& mesh, const SimplifyOptions& options) {
    check(mesh, options);
    SimplifyOptions inner = options;
    // Points between those that are held to the bound lie a little beyond it.
    inner.error_mm *= 0.95;
    for (int attempt = 1;; ++attempt) {
        SimplifiedMesh out = simplified(mesh, inner);
        part_pinches(out, options.error_mm);
        out.distance = mesh_distance(mesh, out.mesh, options.samples);
        if (out.distance.largest <= options.error_mm || attempt == 4) return out;
        inner.error_mm *= 0.9 * options.error_mm / out.distance.largest;
    }
}

std::vector<SimplifiedMesh> levels_of_detail(const TriangleMesh& mesh,
                                             std::span<const double> errors_mm,
                                             const SimplifyOptions& options) {
    std::vector<SimplifiedMesh> levels;
    levels.reserve(errors_mm.size());
    std::optional<SurfaceTree> whole;
    for (std::size_t i = 0; i < errors_mm.size(); ++i) {
        if (i > 0 && !(errors_mm[i] > errors_mm[i - 1])) {
            throw InputError(where, "errors_mm", std::to_string(errors_mm[i]),
                             "rising, above " + std::to_string(errors_mm[i - 1]));
        }
        SimplifyOptions here = options;
        here.error_mm = errors_mm[i];
        if (i == 0) {
            levels.push_back(simplify(mesh, here));
            continue;
        }
        // From the level before: what it already lies off is taken from what is allowed.
        const SimplifiedMesh& before = levels.back();
        const Carried carried(options, before);
        here = carried.options;
        here.error_mm = std::max(errors_mm[i] - before.distance.largest, 1e-6 * errors_mm[i]);
        SimplifiedMesh level = simplify(before.mesh, here);
        for (std::uint32_t& v : level.source_vertex) v = before.source_vertex[v];
        if (!whole) whole.emplace(mesh);
        level.distance = mesh_distance(mesh, *whole, level.mesh, options.samples);
        levels.push_back(std::move(level));
    }
    return levels;
}

}  // namespace togishi
