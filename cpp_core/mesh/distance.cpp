#include "mesh/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/parallel.hpp"
#include "mesh/closest_point.hpp"

namespace togishi {
namespace {

struct Box {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};
    void add(const glm::vec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    [[nodiscard]] float squared(const glm::vec3& p) const {
        const glm::vec3 d = glm::max(glm::max(low - p, p - high), glm::vec3(0));
        return glm::dot(d, d);
    }
};

}  // namespace

struct SurfaceTree::Nodes {
    /// Leaves hold `order` from first on; inner nodes have their children at first and first + 1.
    struct Node {
        Box box;
        std::uint32_t first = 0;
        std::uint32_t count = 0;  ///< 0: an inner node
    };
    static constexpr std::uint32_t leaf_size = 6;

    explicit Nodes(const TriangleMesh& m) : mesh(m), order(m.triangles.size()) {
        Box box;
        const auto middle = [&](const Triangle& c) {
            return (mesh.positions[c[0]] + mesh.positions[c[1]] + mesh.positions[c[2]]) / 3.0F;
        };
        for (const Triangle& c : mesh.triangles) box.add(middle(c));
        const glm::vec3 size = box.high - box.low;
        const float scale = 2'097'151.0F / std::max({size.x, size.y, size.z, 1e-30F});
        // Along a curve that fills space (Morton), so that halves of the row are halves of the
        // place.
        struct Place {
            std::uint64_t code;
            std::uint32_t triangle;
        };
        std::vector<Place> places(order.size());
        for (std::uint32_t t = 0; t < places.size(); ++t) {
            const glm::vec3 at = (middle(mesh.triangles[t]) - box.low) * scale;
            places[t] = {spread(at.x) | spread(at.y) << 1U | spread(at.z) << 2U, t};
        }
        std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
            return a.code != b.code ? a.code < b.code : a.triangle < b.triangle;
        });
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = places[i].triangle;
        nodes.reserve(order.size() / 2 + 1);
        nodes.emplace_back();
        split(0, 0, static_cast<std::uint32_t>(order.size()));
        fit(0);
    }

    /// 21 bits, two places apart.
    static std::uint64_t spread(float value) {
        auto x = static_cast<std::uint64_t>(std::clamp(value, 0.0F, 2'097'151.0F));
        x = (x | x << 32U) & 0x001f00000000ffffULL;
        x = (x | x << 16U) & 0x001f0000ff0000ffULL;
        x = (x | x << 8U) & 0x100f00f00f00f00fULL;
        x = (x | x << 4U) & 0x10c30c30c30c30c3ULL;
        return (x | x << 2U) & 0x1249249249249249ULL;
    }

    /// Halves by count; depth is log2 of it.
    void split(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
        if (end - begin <= leaf_size) {
            nodes[node].first = begin;
            nodes[node].count = end - begin;
            return;
        }
        const std::uint32_t half = begin + (end - begin) / 2;
        const auto children = static_cast<std::uint32_t>(nodes.size());
        nodes[node].first = children;
        nodes.emplace_back();
        nodes.emplace_back();
        split(children, begin, half);
        split(children + 1, half, end);
    }
    void fit(std::uint32_t node) {
        Node& n = nodes[node];
        if (n.count > 0) {
            for (std::uint32_t i = n.first; i < n.first + n.count; ++i) {
                for (const std::uint32_t v : mesh.triangles[order[i]]) n.box.add(mesh.positions[v]);
            }
            return;
        }
        fit(n.first);
        fit(n.first + 1);
        for (std::uint32_t k = 0; k < 2; ++k) {
            n.box.add(nodes[n.first + k].box.low);
            n.box.add(nodes[n.first + k].box.high);
        }
    }

    const TriangleMesh& mesh;
    std::vector<std::uint32_t> order;
    std::vector<Node> nodes;
};

SurfaceTree::SurfaceTree(const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) {
        throw InputError("mesh", "triangles", "0", "a surface of one triangle at least");
    }
    nodes_ = std::make_unique<Nodes>(mesh);
}

SurfaceTree::~SurfaceTree() = default;

SurfaceTree::Nearest SurfaceTree::nearest(const glm::vec3& point, const Search& search) const {
    const auto& all = nodes_->nodes;
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
    stack[depth++] = {0, all[0].box.squared(point)};
    while (depth > 0 && least > enough) {
        const Waiting next = stack[--depth];
        if (next.squared >= least) continue;
        const auto& node = all[next.node];
        if (node.count > 0) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                look_at(nodes_->order[i]);
            }
            continue;
        }
        Waiting close{node.first, all[node.first].box.squared(point)};
        Waiting far{node.first + 1, all[node.first + 1].box.squared(point)};
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

/// Distances of the samples of `from` to a surface with that origin, and where the even ones begin.
std::pair<std::vector<float>, std::size_t> distances(const TriangleMesh& from,
                                                     const glm::dvec3& origin,
                                                     const SurfaceTree& tree, std::size_t count) {
    const Samples samples = sample(from, origin, count);
    std::vector<float> out(samples.points.size());
    parallel_for(out.size(), 1024, [&](std::size_t begin, std::size_t end) {
        SurfaceTree::Search search;
        for (std::size_t i = begin; i < end; ++i) {
            const auto found = tree.nearest(samples.points[i], search);
            search.near = found.triangle;
            out[i] = found.distance;
        }
    });
    return {std::move(out), samples.even};
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
    const auto [there, there_even] = distances(a, b.origin, SurfaceTree(b), samples);
    const auto [back, back_even] = distances(b, a.origin, tree_of_a, samples);
    MeshDistance d;
    d.samples = there.size() + back.size();
    d.largest_there = *std::max_element(there.begin(), there.end());
    d.largest_back = *std::max_element(back.begin(), back.end());
    d.largest = std::max(d.largest_there, d.largest_back);
    double sum = 0;
    std::vector<float> even(there.begin() + static_cast<std::ptrdiff_t>(there_even), there.end());
    even.insert(even.end(), back.begin() + static_cast<std::ptrdiff_t>(back_even), back.end());
    for (const float x : even) sum += double{x} * x;
    d.rms = std::sqrt(sum / static_cast<double>(even.size()));
    d.p99 = quantile(even, 0.99);
    return d;
}

}  // namespace togishi
