#include "mesh/simplify.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include <meshoptimizer/meshoptimizer.h>

#include "base/error.hpp"

namespace togishi {
namespace {

constexpr const char* where = "simplification";

void check(const TriangleMesh& mesh, const SimplifyOptions& o) {
    const auto fail = [](const char* field, const std::string& found, const std::string& allowed) {
        throw InputError(where, field, found, allowed);
    };
    const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
    if (triangles == 0) fail("triangles", "0", "a surface of one triangle at least");
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

}  // namespace

SimplifiedMesh simplify(const TriangleMesh& mesh, const SimplifyOptions& options) {
    check(mesh, options);
    constexpr int most_attempts = 6;
    double estimate_mm = options.error_mm;
    SimplifiedMesh best;
    for (int attempt = 1; attempt <= most_attempts; ++attempt) {
        best = once(mesh, options, estimate_mm);
        best.attempts = attempt;
        if (!best.mesh.triangles.empty()) {
            best.distance = mesh_distance(mesh, best.mesh, options.samples);
            if (best.distance.largest <= options.error_mm) return best;
            estimate_mm *= std::min(0.5, 0.8 * options.error_mm / best.distance.largest);
        } else {
            estimate_mm *= 0.25;  // a piece smaller than the error vanished
        }
    }
    // Nothing could be taken away: the mesh as it is keeps every bound.
    const Prepared whole = prepare(mesh, options.part);
    best = taken_out(mesh, whole, whole.indices);
    best.attempts = most_attempts;
    return best;
}

std::vector<SimplifiedMesh> levels_of_detail(const TriangleMesh& mesh,
                                             std::span<const double> errors_mm,
                                             const SimplifyOptions& options) {
    std::vector<SimplifiedMesh> levels;
    levels.reserve(errors_mm.size());
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
        std::vector<std::uint8_t> locked;
        std::vector<float> attributes;
        for (const std::uint32_t v : before.source_vertex) {
            if (!options.locked.empty()) locked.push_back(options.locked[v]);
            for (std::size_t k = 0; k < options.attribute_count; ++k)
                attributes.push_back(options.attributes[v * options.attribute_count + k]);
        }
        here.locked = locked;
        here.attributes = attributes;
        here.part = before.part;
        here.error_mm = std::max(errors_mm[i] - before.distance.largest, 1e-6 * errors_mm[i]);
        SimplifiedMesh level = simplify(before.mesh, here);
        for (std::uint32_t& v : level.source_vertex) v = before.source_vertex[v];
        level.distance = mesh_distance(mesh, level.mesh, options.samples);
        levels.push_back(std::move(level));
    }
    return levels;
}

}  // namespace togishi
