// Lamps of a size (shared/area_lights.glsl) in a pixel.
//   TG_RECTANGLES, TG_ROUNDS   which outlines the scene has
//   TG_PICTURES                some of them shine with a picture (pictures.glsl)
//   TG_FINE                    round ones by nodes that resolve G's bends: the picture at rest
#include "shared/area_lights.glsl"

#define TG_AREA_RECTANGLE 0
#define TG_AREA_ELLIPSE 1
#define TG_AREA_SPOT 3
#define TG_AREA_SUN 4
// Where all of a lamp is so far from the mirror direction that D is below 1e-7 of its peak, nothing is reflected.
#define TG_DARK_AREA 16.0

// A lamp as the pixel's point sees it.
struct AreaSeen {
    int kind;
    vec3 axis;        // unit, to its middle
    float bound_rad;  // none of it is farther from the axis
    float angle_rad;  // cones: half angle
    float radiance;   // of a lamp of RGB 1; 0: not seen
    float nearness;   // 1/distance, of a sun 0
    FlatLight outline;
#ifdef TG_SHADOWS
    vec3 start;  // of rays to it
    int before;  // the casters that these may meet
#endif
};

// One lobe of the surface, as everything that follows needs it.
struct AreaLobe {
    LobeForm form;
    TangentFrame axes;
    vec3 view;
    float n_dot_v;
    float widest;   // lower bound of the exponent over phi^2
    bool at_theta_i; // F's angle: the ji's, else the hamon's
    bool shadowed;  // G/cos(theta_r) multiplies
    int row;
#ifdef TG_MIRRORED
    vec3 place;
    int own;        // caster that the surface belongs to, or -1
#endif
};

// What is reflected of one direction of a lamp of radiance 1, without the weight of the lobe. Each program has its own.
vec3 node_colour(LightNode node, AreaLobe q);

AreaSeen area_seen(TgArea area, vec3 place) {
    AreaSeen seen;
    seen.kind = int(area.place.w + 0.5);
    vec3 to_lamp = area.place.xyz - (seen.kind == TG_AREA_SUN ? vec3(0.0) : place);
    float distance_squared = max(dot(to_lamp, to_lamp), TG_MIN_DISTANCE_SQUARED);
    float inv = inversesqrt(distance_squared);
    seen.axis = to_lamp * inv;
    seen.nearness = seen.kind == TG_AREA_SUN ? 0.0 : inv;
    seen.angle_rad = 0.0;
    seen.outline.centre = to_lamp;
    if (seen.kind <= TG_AREA_ELLIPSE) {
        seen.outline = flat_light(to_lamp, area.axis_x.xyz, area.axis_y.xyz, area.size.x, area.size.y);
        float half_u = seen.outline.half_u;
        float half_v = seen.outline.half_v;
        float reach = seen.kind == TG_AREA_ELLIPSE ? max(half_u, half_v) : sqrt(half_u * half_u + half_v * half_v);
        seen.bound_rad = reach * inv < 1.0 ? asin(reach * inv) : TG_PI;
        float share = seen.kind == TG_AREA_ELLIPSE ? TG_PI : 4.0;
        seen.radiance = light_area_radiance(1.0, share * half_u * half_v);
        seen.radiance = flat_light_height(seen.outline) > 0.0 ? seen.radiance : 0.0;
    } else {
        bool sun = seen.kind == TG_AREA_SUN;
        bool soft = area.size.y > 0.5;
        float tangent = area.size.x * inv;
        // No asin: graphics cards know it to 1e-4 only.
        float ball = soft ? atan(tangent) : atan(tangent, sqrt(max(1.0 - tangent * tangent, 0.0)));
        // As cone_slices widens it, with its own power.
        seen.angle_rad = clamp(sun ? area.size.x : ball, TG_MIN_HALF_ANGLE, 1.5);
        seen.bound_rad = seen.angle_rad;
        float squared = distance_squared + (soft ? area.size.x * area.size.x : 0.0);
        float facing = sun ? 1.0 : light_point_intensity(1.0) * light_distance_falloff(squared);
        seen.radiance = light_cone_radiance(facing, seen.angle_rad);
        // From inside a sphere is dark; soft, it is a disk that faces every point.
        seen.radiance = !sun && !soft && tangent >= 1.0 ? 0.0 : seen.radiance;
    }
    return seen;
}

// Share of the lamp's radiance that it sends along -direction.
float area_emission(TgArea area, AreaSeen seen, vec3 direction) {
    if (seen.kind <= TG_AREA_ELLIPSE) {
        if (area.size.z <= 0.0) {
            return 1.0;
        }
        float cosine = max(-dot(direction, cross(area.axis_x.xyz, area.axis_y.xyz)), 1.0e-6);
        float tangent = sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine;
        return light_area_spread(tangent, area.size.z, area.size.w);
    }
    if (seen.kind == TG_AREA_SPOT) {
        vec3 in_lamp = -vec3(dot(area.axis_x.xyz, direction), dot(area.axis_y.xyz, direction), dot(area.axis_z.xyz, direction));
        float cos_angle = in_lamp.z * inversesqrt(max(dot(in_lamp, in_lamp), 1.0e-20));
        return light_spot_blend(cos_angle, area.size.w, area.size.z);
    }
    return 1.0;
}

// Where a point of the lamp is seen, not of unit length. at: in a rectangle's square of half side 1, else in a disk of radius 1.
vec3 lamp_point(TgArea area, AreaSeen seen, vec2 at) {
    TangentFrame around = tangent_frame(seen.axis, area.axis_x.xyz);
    vec3 on_cone = seen.axis + (around.tangent * at.x + around.bitangent * at.y) * tan(seen.angle_rad);
    vec3 on_flat = seen.outline.centre + area.axis_x.xyz * (at.x * area.size.x) + area.axis_y.xyz * (at.y * area.size.y);
    return seen.kind <= TG_AREA_ELLIPSE ? on_flat : on_cone;
}

#ifdef TG_PICTURES
#include "viewport/area_pictures.glsl"
#endif

// Whether the lobe reflects any of the lamp: its facets are at least half as far from N as L is from the mirror direction.
bool area_reached(AreaSeen seen, AreaLobe q) {
    vec3 mirror = q.axes.normal * (2.0 * q.n_dot_v) - q.view;
    float away = min(seen.bound_rad + 2.0 * sqrt(TG_DARK_AREA / q.widest), TG_PI);
    return seen.radiance > 0.0 && dot(mirror, seen.axis) >= cos(away);
}

#ifdef TG_SHADOWS
// With what hides the lamp from `start`. own: as casters_towards has it.
AreaSeen area_seen_past(AreaSeen open, TgArea area, vec3 start, int own) {
    AreaSeen seen = open;
    seen.start = start;
    // The farthest point of a flat lamp is farther than its middle.
    float beyond = seen.kind <= TG_AREA_ELLIPSE ? seen.outline.half_u + seen.outline.half_v : 0.0;
    float farthest = seen.nearness > 0.0 ? 1.0 / seen.nearness + beyond : TG_FAR;
    seen.before = area.axis_z.w > 0.5 && seen.radiance > 0.0
                       ? casters_towards(start, seen.axis, seen.bound_rad, farthest, own, TG_CASTS)
                       : 0;
    int itself = int(area.axis_y.w + 0.5);
    seen.before = itself > 0 ? seen.before & ~(1 << (itself - 1)) : seen.before;
    return seen;
}

// 1 where the lamp's point in this direction is seen, else 0.
float area_point_seen(AreaSeen seen, vec3 direction) {
    float reach = seen.nearness > 0.0 ? 1.0 / seen.nearness : TG_FAR;
    if (seen.kind <= TG_AREA_ELLIPSE) {
        vec3 facing = cross(seen.outline.u, seen.outline.v);
        reach = dot(seen.outline.centre, facing) / min(dot(direction, facing), -1.0e-6);
    }
    return ray_blocked(seen.before, seen.start, direction, reach * TG_BEFORE_LAMP) ? 0.0 : 1.0;
}

// Only those things that the lobe sees before the lamp.
AreaSeen seen_by_lobe(AreaSeen all, AreaLobe q, int own) {
    AreaSeen seen = all;
    vec3 mirror = q.axes.normal * (2.0 * q.n_dot_v) - q.view;
    float reach_rad = min(2.0 * sqrt(TG_DARK_AREA / q.widest), TG_PI);
    int times = all.before != 0 ? 1 : 0;
    for (int once = 0; once < times; ++once) {
        seen.before = all.before & casters_towards(all.start, mirror, reach_rad, TG_FAR, own, TG_CASTS);
    }
    return seen;
}
#endif

// blur_rad: standard deviation of the directions that the node stands for.
vec3 light_of_node(LightNode node, TgArea area, AreaSeen seen, AreaLobe q, float blur_rad) {
    vec3 light = node_colour(node, q) * (node.measure * area_emission(area, seen, node.direction));
#ifdef TG_PICTURES
    light *= area_picture(area, seen, node.direction, blur_rad);
#endif
#ifdef TG_SHADOWS
    int times = node.measure > 0.0 && seen.before != 0 ? 1 : 0;
    for (int once = 0; once < times; ++once) {
        light *= area_point_seen(seen, node.direction);
    }
#endif
    return light;
}

// width_rad: that the slice stands for.
vec3 slice_colour(LightSlice slice, TgArea area, AreaSeen seen, AreaLobe q, float width_rad) {
    // Two nodes at a standard deviation to each side of the mean: blurred by .6 of it nothing between them is missed; nor between
    // slices, whose width on the sphere of facets is twice as much of directions, blurred by its own standard deviation.
    vec3 between = slice.first.direction - slice.second.direction;
    float blur_rad = max(0.3 * length(between), 0.65 * width_rad * slice.first.v_dot_h);
    return light_of_node(slice.first, area, seen, q, blur_rad) + light_of_node(slice.second, area, seen, q, blur_rad);
}

// What the lobe reflects of the lamp in `count` slices, without the weight of the lobe and the lamp's colour.
vec3 area_reflection(TgArea area, AreaSeen seen, AreaLobe q, int count) {
    vec3 sum = vec3(0.0);
#ifdef TG_RECTANGLES
    int rectangle = seen.kind == TG_AREA_RECTANGLE ? 1 : 0;
    for (int once = 0; once < rectangle; ++once) {
        RectangleSlices slices = rectangle_slices(seen.outline, q.axes, q.view, q.form, count);
        for (int k = 0; k < count; ++k) {
            float width = slice_place(slices.range, count, k).y;
#ifdef TG_PICTURES
            // A picture's detail needs more nodes than an even light.
            if (count >= 8) {
                SliceParts parts = rectangle_slice_fine(slices, count, k);
                sum += slice_colour(parts.lower, area, seen, q, width) + slice_colour(parts.middle, area, seen, q, width) +
                       slice_colour(parts.upper, area, seen, q, width);
            } else {
                sum += slice_colour(rectangle_slice(slices, count, k), area, seen, q, width);
            }
#else
            sum += slice_colour(rectangle_slice(slices, count, k), area, seen, q, width);
#endif
        }
    }
#endif
#ifdef TG_ROUNDS
    int rounds = seen.kind == TG_AREA_RECTANGLE ? 0 : 1;
    for (int once = 0; once < rounds; ++once) {
        DiskSlices slices;
        if (seen.kind == TG_AREA_ELLIPSE) {
            slices = ellipse_slices(seen.outline, q.axes, q.view, q.form, count);
        } else {
            slices = cone_slices(seen.axis, seen.angle_rad, q.axes, q.view, q.form, count);
        }
        for (int k = 0; k < count; ++k) {
#ifdef TG_FINE
            SliceParts parts = disk_slice_fine(slices, count, k);
            sum += slice_colour(parts.lower, area, seen, q, 0.0) + slice_colour(parts.middle, area, seen, q, 0.0) +
                   slice_colour(parts.upper, area, seen, q, 0.0);
#else
            sum += slice_colour(disk_slice(slices, count, k), area, seen, q, 0.0);
#endif
        }
    }
#endif
    return sum * seen.radiance;
}

// Mean of area_emission over the lamp: at sixteen points of it, along a spiral or, in a rectangle, a lattice.
float mean_emission(TgArea area, AreaSeen seen) {
    bool all_alike = seen.kind <= TG_AREA_ELLIPSE ? area.size.z <= 0.0 : seen.kind != TG_AREA_SPOT;
    int points = all_alike ? 0 : 16;
    float sum = 0.0;
    for (int k = 0; k < points; ++k) {
        float share = (float(k) + 0.5) / 16.0;
        float turn = 2.39996323 * float(k);
        vec2 at = sqrt(share) * vec2(cos(turn), sin(turn));
        at = seen.kind == TG_AREA_RECTANGLE ? vec2(2.0 * share - 1.0, 2.0 * fract(0.61803399 * float(k)) - 1.0) : at;
        sum += area_emission(area, seen, unit_or_zero(lamp_point(area, seen, at)));
    }
    return all_alike ? 1.0 : sum / 16.0;
}

#ifdef TG_SHADOWS
// Interleaved gradient noise (Jimenez 2014): neighbours differ as much as they can.
float pixel_noise(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

// Share of the lamp's irradiance on a matt surface that nothing hides: by rays to points of it, other ones in each pixel; first:
// number of the first of them.
float area_share_seen(TgArea area, AreaSeen seen, vec3 normal, int rays, float first) {
    int points = seen.before != 0 ? rays : 0;
    vec2 shift = vec2(pixel_noise(gl_FragCoord.xy), pixel_noise(gl_FragCoord.yx + vec2(47.0, 17.0)));
    float reached = 0.0;
    float all = 0.0;
    for (int k = 0; k < points; ++k) {
        vec2 u = fract(shift + (first + float(k)) * vec2(0.7548776662466927, 0.5698402909980532));
        float turn = 2.0 * TG_PI * u.y;
        vec2 at = seen.kind == TG_AREA_RECTANGLE ? 2.0 * u - 1.0 : sqrt(u.x) * vec2(cos(turn), sin(turn));
        vec3 to_point = lamp_point(area, seen, at);
        float distance2 = max(dot(to_point, to_point), TG_MIN_DISTANCE_SQUARED);
        vec3 direction = to_point * inversesqrt(distance2);
        float weight = max(dot(normal, direction), 0.0) * area_emission(area, seen, direction);
        if (seen.kind <= TG_AREA_ELLIPSE) {
            weight *= max(-dot(direction, cross(seen.outline.u, seen.outline.v)), 0.0) / distance2;
        }
        int times = weight > 0.0 ? 1 : 0;
        for (int once = 0; once < times; ++once) {
            all += weight;
            reached += weight * area_point_seen(seen, direction);
        }
    }
    return all > 0.0 ? reached / all : 1.0;
}
#endif

// Irradiance on a matt surface, of a lamp of RGB 1.
float area_irradiance(TgArea area, AreaSeen seen, vec3 normal) {
    float directions = seen.kind <= TG_AREA_ELLIPSE
                           ? flat_irradiance(seen.outline, seen.kind == TG_AREA_ELLIPSE, normal)
                           : cone_irradiance(seen.axis, seen.angle_rad, normal);
    return directions * seen.radiance * mean_emission(area, seen);
}

float shadowed_node(LightNode node, AreaLobe q) {
    return q.shadowed ? shadowing_over_cos_r(node.n_dot_h, q.n_dot_v, max(node.n_dot_l, TG_MIN_COS), node.v_dot_h) : 1.0;
}
