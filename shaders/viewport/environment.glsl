// The surroundings mirrored by a lobe, an HDRI and (TG_MIRRORED) things near the blade: round taps along the long axis of what the lobe sees of it (shared/area/environment_taps.glsl), each with
// Fresnel and shadowing of its own facet. Where many samples are gathered, each takes facets drawn from the lobe instead, so that the sum
// converges. Behind areas.glsl, whose lobes and nodes it shares.
#ifdef TG_ENVIRONMENT
#include "viewport/environment_read.glsl"
#endif
#ifdef TG_MIRRORED
#include "viewport/mirrored.glsl"
#endif

// Taps: while something moves, and at rest.
#define TG_TAPS_MOVING 5
#define TG_TAPS_RESTING 25
// Facets of each sample, from so many samples on.
#define TG_DRAWN_FACETS 16
#define TG_LEAST_SERIES 16.0
#define TG_FACETS_MOVING 4

// Point k of a series (Roberts 2018) as two standard normal numbers (Box and Muller).
vec2 normal_point(int k) {
    vec2 u = fract(vec2(0.5, 0.5) + float(k) * vec2(0.7548776662466927, 0.5698402909980532));
    float turn = 2.0 * TG_PI * u.y;
    return sqrt(-2.0 * log(max(1.0 - u.x, 1.0e-7))) * vec2(cos(turn), sin(turn));
}

// What the lobe reflects, without its weight.
struct SurroundingsSeen {
    vec3 world;  // of the HDRI, without the world's colour
    vec3 things;
    float open;  // share of the lobe in which no thing is
};

SurroundingsSeen surroundings_reflection(AreaLobe q) {
    float cosine = max(q.n_dot_v, 0.02);
    // Facets turned by d about e2 and e1 turn the mirror direction by 2 d and by 2 cos(theta) d.
    vec3 e1 = q.view - q.axes.normal * q.n_dot_v;
    float outward = dot(e1, e1);
    e1 = outward > 1.0e-10 ? e1 * inversesqrt(outward) : q.axes.tangent;
    vec3 e2 = cross(q.axes.normal, e1);
    vec2 a = vec2(dot(e1, q.axes.tangent), dot(e1, q.axes.bitangent));
    vec2 b = vec2(dot(e2, q.axes.tangent), dot(e2, q.axes.bitangent));
    float det = q.form.scale * q.form.scale;
    vec2 fa = vec2(q.form.yy * a.x - q.form.xy * a.y, q.form.xx * a.y - q.form.xy * a.x) / (2.0 * det);
    vec2 fb = vec2(q.form.yy * b.x - q.form.xy * b.y, q.form.xx * b.y - q.form.xy * b.x) / (2.0 * det);
    float along = 4.0 * dot(fa, a);
    float mixed = 4.0 * cosine * dot(fa, b);
    float across = 4.0 * cosine * cosine * dot(fb, b);
    float difference = 0.5 * (along - across);
    float root = sqrt(difference * difference + mixed * mixed);
    float major = 0.5 * (along + across) + root;
    // Longer than the taps reach (20:1, at grazing view): wider instead, so that none of the length is lost.
    float minor = max(4.0 * cosine * cosine / (det * major), major / 400.0);
    vec2 axis = difference >= 0.0 ? vec2(difference + root, mixed) : vec2(mixed, root - difference);
    float length2 = dot(axis, axis);
    axis = length2 > 1.0e-12 * major * major ? axis * inversesqrt(length2) : vec2(1.0, 0.0);
    float aspect = sqrt(major / minor);
    int count = frame.view.z < 8.0 ? TG_TAPS_MOVING : TG_TAPS_RESTING;
    EnvironmentTaps taps = environment_taps(aspect, count);
    float sigma = sqrt(minor);
    vec3 long_turn = (e1 * axis.x + e2 * (axis.y / cosine)) * (0.5 * sigma);
    vec3 short_turn = (e2 * (axis.x / cosine) - e1 * axis.y) * (0.5 * sigma);
    bool drawn = frame.series.y >= TG_LEAST_SERIES;
    int facets = TG_DRAWN_FACETS;
    float number = frame.series.x;
    float samples = frame.series.y;
#ifdef TG_MIRRORED
    vec3 mirror = q.axes.normal * (2.0 * q.n_dot_v) - q.view;
    // No drawn facet is farther out than 5 standard deviations.
    int about = casters_towards(q.place, mirror, min(5.0 * sqrt(major), TG_PI), TG_FAR, q.own, TG_SHOWS);
    if (about != 0) {
        // Things are not blurred beforehand: rays through the whole lobe, others in each sample that is added.
        drawn = true;
        facets = frame.view.z < 8.0 ? TG_FACETS_MOVING : TG_DRAWN_FACETS / 2;
        number = frame.series.w / max(frame.series.z, 1.0);
        samples = max(frame.series.y, number + 1.0);
    }
#endif
    int drawn_before = int(number + 0.5) * facets;
    // Each drawn facet stands for what lies around it: the more, the less; its own width is no part of the spread of all.
    float own = 0.8 * sqrt(2.0 * TG_PI * min(aspect, 20.0) / (samples * float(facets)));
    own = clamp(own, 0.01, 0.9);
#ifndef TG_ENVIRONMENT
    own = 0.01; // nothing is blurred beforehand
#endif
    vec2 drawn_spread = sqrt(vec2(min(aspect * aspect, 400.0), 1.0) - vec2(own * own));
    count = drawn ? facets : count;
    float variance = minor * (drawn ? own * own : taps.width * taps.width);
    SurroundingsSeen seen;
    seen.world = vec3(0.0);
    seen.things = vec3(0.0);
    float open = 0.0;
    float lit_weights = 0.0;
    float weights = 0.0;
#if defined(TG_MIRRORED) && !defined(TG_ENVIRONMENT)
    count = about != 0 ? count : 0;
#endif
    for (int k = 0; k < count; ++k) {
        vec2 place = vec2(environment_tap_place(taps, count, k), 0.0);
        float weight = drawn ? 1.0 : environment_tap_weight(taps, place.x);
        place = drawn ? normal_point(drawn_before + k) * drawn_spread : place;
        weights += weight;
        vec3 turn = long_turn * place.x + short_turn * place.y;
        float angle = length(turn);
        vec3 turn_axis = turn / max(angle, 1.0e-12);
        angle = min(angle, 1.5);
        vec3 h = q.axes.normal * cos(angle) + turn_axis * sin(angle);
        LightNode node;
        node.v_dot_h = min(dot(q.view, h), 1.0);
        node.n_dot_h = cos(angle);
        node.direction = h * (2.0 * node.v_dot_h) - q.view;
        node.n_dot_l = dot(q.axes.normal, node.direction);
        bool lit = node.n_dot_l > TG_MIN_COS && node.v_dot_h > 0.0;
        // The lobe's measure on the sphere of facets against that on its plane.
        float sphere = angle > 1.0e-3 ? sin(angle) / angle : 1.0;
        // Across the plane of V and H, turns grow with V.H.
        float grown = node.v_dot_h / cosine;
        float wide = variance * mix(1.0, grown * grown, axis.x * axis.x);
        node.measure = lit ? weight * sphere * 4.0 * node.v_dot_h : 0.0;
        int times = lit ? 1 : 0;
        for (int once = 0; once < times; ++once) {
            float open_here = 1.0;
#ifdef TG_MIRRORED
            int near = about != 0 ? 1 : 0;
            for (int once_near = 0; once_near < near; ++once_near) {
                MirroredThing thing = mirrored_thing(about, q.place, node.direction);
                open_here = thing.found ? 0.0 : 1.0;
                if (thing.found) {
                    seen.things += mirrored_light(thing, node, q, drawn_before + k) * node.measure;
                }
            }
#endif
#ifdef TG_ENVIRONMENT
            if (open_here > 0.0) {
                seen.world += node_colour(node, q) * environment_at(node.direction, wide) * node.measure;
            }
#endif
            open += open_here * weight;
            lit_weights += weight;
        }
    }
    float scale = TG_PI / (q.form.scale * max(weights, 1.0e-20));
    seen.world *= scale;
    seen.things *= scale;
    seen.open = lit_weights > 0.0 ? open / lit_weights : 1.0;
    return seen;
}
