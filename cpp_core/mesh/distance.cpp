#include "mesh/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/parallel.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/closest_point.hpp"

namespace togishi {
namespace {

/// From a point to a box, squared.
float squared_distance(const Box& box, const glm::vec3& p) {
    const glm::vec3 d = glm::max(glm::max(box.low - p, p - box.high), glm::vec3(0));
    return glm::dot(d, d);
}

}  // namespace

struct SurfaceTree::Nodes {
    explicit Nodes(const TriangleMesh& m) : mesh(m), tree(box_tree(m, 6)) {}
    const TriangleMesh& mesh;
    BoxTree tree;
};

SurfaceTree::SurfaceTree(const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) {
        throw InputError("mesh", "triangles", "0", "a surface of one triangle at least");
    }
    nodes_ = std::make_unique<Nodes>(mesh);
}

SurfaceTree::~SurfaceTree() = default;

SurfaceTree::Nearest SurfaceTree::nearest(const glm::vec3& point, const Search& search) const {
    const auto& all = nodes_->tree.nodes;
    const TriangleMesh& mesh = nodes_->mesh;
    Nearest best;
    best.distance = search.within;
    float least = search.within * search.within;
    const float enough = search.enough * search.enough;
    const auto look_at = [&](std::uint32_t t) {
        const Triangle& c = mesh.triangles[t];
        const ClosestPoint found =
            closest_on(point, mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]);
        const glm::vec3 off = point - found.point;
        const float squared = glm::dot(off, off);
        if (squared < least) {
            least = squared;
            best = {t, found.point, found.weights, std::sqrt(squared)};
        }
    };
    look_at(search.near);
    struct Waiting {
        std::uint32_t node;
        float squared;
    };
    std::array<Waiting, 72> stack{};  // two a level, 32 levels for 2^32 triangles
    std::size_t depth = 0;
    stack[depth++] = {0, squared_distance(all[0].box, point)};
    while (depth > 0 && least > enough) {
        const Waiting next = stack[--depth];
        if (next.squared >= least) continue;
        const auto& node = all[next.node];
        if (node.count > 0) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                look_at(nodes_->tree.order[i]);
            }
            continue;
        }
        Waiting close{node.first, squared_distance(all[node.first].box, point)};
        Waiting far{node.first + 1, squared_distance(all[node.first + 1].box, point)};
        if (far.squared < close.squared) std::swap(close, far);
        stack[depth++] = far;
        stack[depth++] = close;
    }
    return best;
}

namespace {

/// Fractions of a row that no two places share: Roberts' R2 sequence.
double fraction(double step, std::size_t i) {
    const double x = step * static_cast<double>(i + 1);
    return x - std::floor(x);
}

/// Points on `from`, told from `to`'s origin: all its vertices, or every so manieth, and points
/// even over its area.
struct Samples {
    std::vector<glm::vec3> points;
    std::size_t even = 0;  ///< the first of those that are even over the area
};

Samples sample(const TriangleMesh& from, const glm::dvec3& origin, std::size_t count) {
    const glm::dvec3 shift = from.origin - origin;
    const auto place = [&](const glm::dvec3& p) { return glm::vec3(p + shift); };
    Samples out;
    const std::size_t vertices = from.positions.size();
    const std::size_t wanted = std::min(vertices, count / 2 + 1);
    for (std::size_t i = 0; i < wanted; ++i) {
        // Integer steps by 64 bits: vertices and counts stay far below 2^32.
        out.points.push_back(place(from.positions[i * vertices / wanted]));
    }
    out.even = out.points.size();
    std::vector<double> up_to(from.triangles.size());
    double sum = 0;
    for (std::size_t t = 0; t < up_to.size(); ++t) {
        const Triangle& c = from.triangles[t];
        const glm::dvec3 a = from.positions[c[0]];
        sum += glm::length(
            glm::cross(glm::dvec3(from.positions[c[1]]) - a, glm::dvec3(from.positions[c[2]]) - a));
        up_to[t] = sum;
    }
    const std::size_t even = std::max<std::size_t>(1, count - std::min(count, wanted));
    std::size_t t = 0;
    for (std::size_t i = 0; i < even; ++i) {
        const double at = sum * (static_cast<double>(i) + 0.5) / static_cast<double>(even);
        while (t + 1 < up_to.size() && up_to[t] < at) ++t;
        double u = fraction(0.7548776662466927, i), v = fraction(0.5698402909980532, i);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Triangle& c = from.triangles[t];
        const glm::dvec3 a = from.positions[c[0]], b = from.positions[c[1]],
                         d = from.positions[c[2]];
        out.points.push_back(place(a + u * (b - a) + v * (d - a)));
    }
    return out;
}

/// Distances of points to a surface, told from its origin; of those nearer than `enough` any one
/// that is below it.
std::vector<float> distances(const std::vector<glm::vec3>& points, const SurfaceTree& tree,
                             float enough = 0) {
    std::vector<float> out(points.size());
    parallel_for(out.size(), 1024, [&](std::size_t begin, std::size_t end) {
        SurfaceTree::Search search{.enough = enough};
        for (std::size_t i = begin; i < end; ++i) {
            const auto found = tree.nearest(points[i], search);
            search.near = found.triangle;
            out[i] = found.distance;
        }
    });
    return out;
}

}  // namespace

MeshDistance mesh_distance(const TriangleMesh& a, const TriangleMesh& b, std::size_t samples) {
    if (a.triangles.empty()) {
        throw InputError("mesh", "triangles", "0", "a surface of one triangle at least");
    }
    return mesh_distance(a, SurfaceTree(a), b, samples);
}

MeshDistance mesh_distance(const TriangleMesh& a, const SurfaceTree& tree_of_a,
                           const TriangleMesh& b, std::size_t samples) {
    const SurfaceTree tree_of_b(b);  // before the samples: it refuses a mesh without triangles
    const Samples of_a = sample(a, b.origin, samples);
    const Samples of_b = sample(b, a.origin, samples);
    const std::vector<float> there = distances(of_a.points, tree_of_b);
    const std::vector<float> back = distances(of_b.points, tree_of_a);
    MeshDistance d;
    d.samples = there.size() + back.size();
    d.largest_there = *std::max_element(there.begin(), there.end());
    d.largest_back = *std::max_element(back.begin(), back.end());
    d.largest = std::max(d.largest_there, d.largest_back);
    double sum = 0;
    std::vector<float> even(there.begin() + static_cast<std::ptrdiff_t>(of_a.even), there.end());
    even.insert(even.end(), back.begin() + static_cast<std::ptrdiff_t>(of_b.even), back.end());
    for (const float x : even) sum += double{x} * x;
    d.rms = std::sqrt(sum / static_cast<double>(even.size()));
    d.p99 = quantile(even, 0.99);
    return d;
}

std::vector<glm::vec3> points_beyond(const TriangleMesh& from, const glm::dvec3& origin,
                                     const SurfaceTree& surface, float bound, std::size_t samples) {
    const Samples all = sample(from, origin, samples);
    const std::vector<float> distance = distances(all.points, surface, bound);
    std::vector<glm::vec3> found;
    for (std::size_t i = 0; i < distance.size(); ++i) {
        if (distance[i] > bound) found.push_back(all.points[i]);
    }
    return found;
}

}  // namespace togishi
