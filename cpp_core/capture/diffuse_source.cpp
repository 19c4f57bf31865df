#include "capture/diffuse_source.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "base/error.hpp"

namespace togishi {
namespace {

constexpr double pi = std::numbers::pi;

// Two unit vectors that make a right-handed frame with a unit axis.
std::array<glm::dvec3, 2> across(const glm::dvec3& axis) {
    const glm::dvec3 other = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(other, axis));
    return {u, glm::cross(axis, u)};
}

}  // namespace

double DiffuseSource::inside(const glm::dvec3& point_mm, const glm::dvec3& light) const {
    if (kind == SourceKind::hemisphere) {
        const double radius = glm::length(half_u_mm);
        const glm::dvec3 axis = half_u_mm / radius;
        if (far_away) return glm::dot(light, axis);
        // Where the ray leaves the sphere.
        const glm::dvec3 d = point_mm - centre_mm;
        const double b = glm::dot(d, light), c = glm::dot(d, d) - radius * radius;
        if (c > 0) return -1;  // the surface lies outside the dome
        const double distance = -b + std::sqrt(b * b - c);
        return glm::dot(d + distance * light, axis) / radius;
    }
    const glm::dvec3 normal = glm::cross(half_u_mm, half_v_mm);
    const double along = glm::dot(light, normal);
    const double height = glm::dot(centre_mm - point_mm, normal);
    if (!(along * height > 0)) return -1;
    const glm::dvec3 hit = point_mm + (height / along) * light - centre_mm;
    // u and v need not be at right angles.
    const double uu = glm::dot(half_u_mm, half_u_mm), vv = glm::dot(half_v_mm, half_v_mm),
                 uv = glm::dot(half_u_mm, half_v_mm), det = uu * vv - uv * uv;
    const double hu = glm::dot(hit, half_u_mm), hv = glm::dot(hit, half_v_mm);
    const double u = (hu * vv - hv * uv) / det, v = (hv * uu - hu * uv) / det;
    const double reach =
        kind == SourceKind::disk ? std::hypot(u, v) : std::max(std::abs(u), std::abs(v));
    return std::max(1 - reach, -1.0);
}

DiffuseSource::Seen DiffuseSource::seen_from(const glm::dvec3& point_mm, double a, double b) const {
    if (kind == SourceKind::hemisphere) {
        const double radius = glm::length(half_u_mm);
        const glm::dvec3 axis = half_u_mm / radius;
        const auto [e, f] = across(axis);
        const double theta = a * pi / 2, azimuth = b * 2 * pi;
        const glm::dvec3 direction =
            std::cos(theta) * axis +
            std::sin(theta) * (std::cos(azimuth) * e + std::sin(azimuth) * f);
        const double own = std::sin(theta) * pi * pi;  // d omega as the centre sees it
        if (far_away) return {direction, own};
        const glm::dvec3 to = centre_mm + radius * direction - point_mm;
        const double r2 = glm::dot(to, to), r = std::sqrt(r2);
        return {to / r, own * radius * radius * std::abs(glm::dot(to, direction)) / (r2 * r)};
    }
    double u = 2 * a - 1, v = 2 * b - 1, share = 4;
    if (kind == SourceKind::disk) {
        u = a * std::cos(2 * pi * b);
        v = a * std::sin(2 * pi * b);
        share = 2 * pi * a;
    }
    const glm::dvec3 to = centre_mm + u * half_u_mm + v * half_v_mm - point_mm;
    const double r2 = glm::dot(to, to), r = std::sqrt(r2);
    const glm::dvec3 area = glm::cross(half_u_mm, half_v_mm);
    return {to / r, share * std::abs(glm::dot(to, area)) / (r2 * r)};
}

void check_source(const DiffuseSource& source, std::string_view where) {
    const auto sized = [](const glm::dvec3& v) {
        const double l = glm::length(v);
        return l > 0 && l < 1e9;
    };
    if (!std::isfinite(glm::length(source.centre_mm)))
        throw InputError(where, "source.centre_mm", "not finite", "a place in mm");
    if (!sized(source.half_u_mm)) {
        throw InputError(
            where, source.kind == SourceKind::hemisphere ? "source.axis" : "source.half_u_mm",
            "length " + std::to_string(glm::length(source.half_u_mm)), "a vector above 0 mm");
    }
    if (source.kind != SourceKind::hemisphere) {
        const double area = glm::length(glm::cross(source.half_u_mm, source.half_v_mm));
        if (!sized(source.half_v_mm) ||
            !(area > 1e-6 * glm::length(source.half_u_mm) * glm::length(source.half_v_mm))) {
            throw InputError(where, "source.half_v_mm",
                             "length " + std::to_string(glm::length(source.half_v_mm)),
                             "a vector above 0 mm that is not parallel to half_u_mm");
        }
    }
    if (!(source.radiance > 0 && source.radiance < 1e12)) {
        throw InputError(where, "source.radiance", std::to_string(source.radiance), "above 0");
    }
}

double source_irradiance(const DiffuseSource& source, const glm::dvec3& point_mm,
                         const glm::dvec3& normal, int steps) {
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        for (int k = 0; k < steps; ++k) {
            const auto seen = source.seen_from(point_mm, (i + 0.5) / steps, (k + 0.5) / steps);
            sum += seen.solid_angle * std::max(glm::dot(seen.direction, normal), 0.0);
        }
    }
    return sum / (steps * steps);
}

}  // namespace togishi
