#include "mesh_file/mesh_builder.hpp"

#include <algorithm>
#include <limits>

#include "base/error.hpp"

namespace togishi {
namespace {

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace

void MeshBuilder::expect(std::uint64_t vertices, std::uint64_t faces) {
    if (vertices > limits_.max_vertices) refuse_count("vertices", limits_.max_vertices);
    if (faces > limits_.max_triangles) refuse_count("triangles", limits_.max_triangles);
    points_.reserve(vertices);
    triangles_.reserve(faces);
}

void MeshBuilder::refuse_vertex(const glm::dvec3& at) const {
    const char axis = !(std::abs(at.x) < 1e9) ? 'x' : !(std::abs(at.y) < 1e9) ? 'y' : 'z';
    const double value = axis == 'x' ? at.x : axis == 'y' ? at.y : at.z;
    const std::uint64_t number = std::max<std::uint64_t>(points_.size(), welded_.size()) + 1;
    throw InputError(where_ + ", vertex " + std::to_string(number), std::string(1, axis),
                     std::to_string(value), "finite coordinates below 1e9");
}

void MeshBuilder::refuse_count(std::string_view what, std::uint64_t most) const {
    throw InputError(
        where_, what, "more than " + std::to_string(most),
        "at most " + std::to_string(most) + ", a limit against files that lie; it can be raised");
}

std::uint32_t MeshBuilder::welded_vertex(const glm::dvec3& at) {
    if (!usable(at)) refuse_vertex(at);
    if (welded_.size() >= limits_.max_vertices) refuse_count("vertices", limits_.max_vertices);
    if (welded_.empty()) welded_origin_ = glm::round(at);
    return index_.add(glm::vec3(at - welded_origin_), welded_);
}

void MeshBuilder::polygon(std::span<const std::uint32_t> corners, std::uint64_t face) {
    if (corners.size() == 3) {
        triangle(corners[0], corners[1], corners[2]);
        return;
    }
    if (corners.size() < 3 || corners.size() > most_corners) {
        throw InputError(where_ + ", face " + std::to_string(face), "corners",
                         std::to_string(corners.size()), "3 to 256");
    }
    ++polygons_;
    const auto highest = *std::max_element(corners.begin(), corners.end());
    if (later_.empty() && highest < points_.size()) {
        cut(corners);
        return;
    }
    later_.push_back(static_cast<std::uint32_t>(corners.size()));
    later_.insert(later_.end(), corners.begin(), corners.end());
}

void MeshBuilder::cut(std::span<const std::uint32_t> corners) {
    if (corners.size() > 4) {
        cut_by_ears(corners);
        return;
    }
    const auto at = [&](std::size_t i) { return points_[corners[i % 4]]; };
    const auto normal = [&](std::size_t a, std::size_t b, std::size_t c) {
        return glm::cross(at(b) - at(a), at(c) - at(a));
    };
    // The diagonal that folds nothing over, of two such the shorter.
    const bool first = glm::dot(normal(0, 1, 2), normal(0, 2, 3)) >= 0;
    const bool second = glm::dot(normal(1, 2, 3), normal(1, 3, 0)) >= 0;
    const bool shorter = glm::length(at(2) - at(0)) <= glm::length(at(3) - at(1));
    const std::size_t s = first == second ? (shorter ? 0 : 1) : first ? 0 : 1;
    triangle(corners[s], corners[s + 1], corners[s + 2]);
    triangle(corners[s], corners[s + 2], corners[(s + 3) % 4]);
}

void MeshBuilder::cut_by_ears(std::span<const std::uint32_t> corners) {
    // Newell's normal; the polygon seen along it.
    glm::dvec3 normal(0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        normal += glm::cross(points_[corners[i]] - points_[corners[0]],
                             points_[corners[(i + 1) % corners.size()]] - points_[corners[0]]);
    }
    const glm::dvec3 size = glm::abs(normal);
    const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const double sign = normal[drop] < 0 ? -1 : 1;
    const auto seen = [&](std::uint32_t v) {
        const glm::dvec3& p = points_[v];
        return glm::dvec2(sign * p[(drop + 1) % 3], p[(drop + 2) % 3]);
    };
    std::vector<std::uint32_t> left(corners.begin(), corners.end());
    std::size_t i = 0, tried = 0;
    while (left.size() > 3) {
        const std::size_t n = left.size();
        const std::size_t before = (i + n - 1) % n, after = (i + 1) % n;
        const glm::dvec2 a = seen(left[before]), b = seen(left[i]), c = seen(left[after]);
        bool ear = turn(a, b, c) > 0;
        for (std::size_t k = 0; ear && k < n; ++k) {
            if (k == before || k == i || k == after) continue;
            const glm::dvec2 p = seen(left[k]);
            ear = !(turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0);
        }
        // A polygon that crosses itself runs out of ears: then any corner will do.
        if (ear || tried > n) {
            triangle(left[before], left[i], left[after]);
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
            i %= left.size();
            tried = 0;
        } else {
            i = after;
            ++tried;
        }
    }
    triangle(left[0], left[1], left[2]);
}

void MeshBuilder::check_indices(std::uint64_t vertices) const {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        for (const std::uint32_t v : triangles_[t]) {
            if (v < vertices) continue;
            throw InputError(where_ + ", triangle " + std::to_string(t + 1), "vertex index",
                             std::to_string(v),
                             "0 to " + std::to_string(vertices) + " - 1, counted from 0");
        }
    }
}

TriangleMesh MeshBuilder::finish() {
    for (std::size_t i = 0; i < later_.size(); i += later_[i] + 1) {
        const std::span<const std::uint32_t> corners(&later_[i + 1], later_[i]);
        for (const std::uint32_t v : corners) {
            if (v >= points_.size()) {
                throw InputError(where_, "vertex index", std::to_string(v),
                                 "0 to " + std::to_string(points_.size()) + " - 1, counted from 0");
            }
        }
        cut(corners);
    }
    const bool welded = !welded_.empty();
    check_indices(welded ? welded_.size() : points_.size());
    if (triangles_.empty()) {
        throw InputError(where_, "triangles", "0",
                         "a mesh: a cloud of points must be meshed first");
    }
    TriangleMesh mesh;
    mesh.triangles = std::move(triangles_);
    glm::dvec3 low(std::numeric_limits<double>::max()), high = -low;
    const auto grow = [&](const glm::dvec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    };
    // Whole numbers: the origin reads well in a report.
    if (welded) {
        for (const glm::vec3& p : welded_) grow(glm::dvec3(p));
        const glm::dvec3 middle = glm::round(0.5 * (low + high));
        mesh.origin = welded_origin_ + middle;
        mesh.positions = std::move(welded_);
        for (glm::vec3& p : mesh.positions) p = glm::vec3(glm::dvec3(p) - middle);
        return mesh;
    }
    for (const glm::dvec3& p : points_) grow(p);
    mesh.origin = glm::round(0.5 * (low + high));
    mesh.positions.reserve(points_.size());
    for (const glm::dvec3& p : points_) mesh.positions.emplace_back(p - mesh.origin);
    if (!colours_.empty()) {
        colours_.resize(points_.size(), Colour8{255, 255, 255, 255});
        mesh.colours = std::move(colours_);
    }
    return mesh;
}

}  // namespace togishi
