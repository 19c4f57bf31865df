// The point of a triangle that is nearest to another point.
#pragma once
#include <glm/glm.hpp>

namespace togishi {

struct ClosestPoint {
    glm::vec3 point;
    glm::vec3 weights;
};

/// Ericson, Real-Time Collision Detection (2005), 5.1.5: by the Voronoi region of the triangle's
/// features. A triangle without area falls on one of its edges.
inline ClosestPoint closest_on(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b,
                               const glm::vec3& c) {
    const glm::vec3 ab = b - a, ac = c - a, ap = p - a;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {a, {1, 0, 0}};
    const glm::vec3 bp = p - b;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {b, {0, 1, 0}};
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        const float v = d1 / (d1 - d3);
        return {a + v * ab, {1 - v, v, 0}};
    }
    const glm::vec3 cp = p - c;
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {c, {0, 0, 1}};
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        const float w = d2 / (d2 - d6);
        return {a + w * ac, {1 - w, 0, w}};
    }
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {b + w * (c - b), {0, 1 - w, w}};
    }
    const float scale = 1 / (va + vb + vc);
    const float v = vb * scale, w = vc * scale;
    return {a + v * ab + w * ac, {1 - v - w, v, w}};
}

}  // namespace togishi
