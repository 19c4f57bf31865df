// The surroundings mirrored by a lobe, an HDRI and (TG_MIRRORED) things near the blade: round taps along the long axis of what the lobe
// sees of it (shared/area/environment_taps.glsl), each with Fresnel and shadowing of its own facet. Where many samples are gathered, each
// takes facets drawn from the lobe instead, so that the sum converges. Behind areas.glsl, whose lobes and nodes it shares.
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
// Rays to things near the blade, of one sample.
#define TG_FACETS_MOVING 4
#define TG_FACETS_RESTING 8

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

// What the lobe covers of the sphere of directions: a Gaussian, long along one axis.
struct LobePatch {
    float cosine;
    float minor;    // variance across the long axis, rad^2
    float aspect;   // of the standard deviations
    float across;   // share of the long axis that lies across the plane of view and normal, squared
    vec3 long_turn; // of the facet, for a standard deviation of the short axis along either
    vec3 short_turn;
};

LobePatch lobe_patch(AreaLobe q) {
    LobePatch p;
    p.cosine = max(q.n_dot_v, 0.02);
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
    float mixed = 4.0 * p.cosine * dot(fa, b);
    float across = 4.0 * p.cosine * p.cosine * dot(fb, b);
    float difference = 0.5 * (along - across);
    float root = sqrt(difference * difference + mixed * mixed);
    float major = 0.5 * (along + across) + root;
    // Longer than the taps reach (20:1, at grazing view): wider instead, so that none of the length is lost.
    p.minor = max(4.0 * p.cosine * p.cosine / (det * major), major / 400.0);
    vec2 axis = difference >= 0.0 ? vec2(difference + root, mixed) : vec2(mixed, root - difference);
    float length2 = dot(axis, axis);
    axis = length2 > 1.0e-12 * major * major ? axis * inversesqrt(length2) : vec2(1.0, 0.0);
    p.aspect = sqrt(major / p.minor);
    p.across = axis.x * axis.x;
    float sigma = sqrt(p.minor);
    p.long_turn = (e1 * axis.x + e2 * (axis.y / p.cosine)) * (0.5 * sigma);
    p.short_turn = (e2 * (axis.x / p.cosine) - e1 * axis.y) * (0.5 * sigma);
    return p;
}

// The facet at a place of the patch, in standard deviations of its short axis; measure 0 where it mirrors nothing.
LightNode patch_node(LobePatch p, AreaLobe q, vec2 place, float weight) {
    vec3 turn = p.long_turn * place.x + p.short_turn * place.y;
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
    node.measure = lit ? weight * sphere * 4.0 * node.v_dot_h : 0.0;
    return node;
}

#ifdef TG_ENVIRONMENT
// What the node's facet mirrors of the HDRI, blurred by this variance (rad^2).
vec3 environment_of_node(LobePatch p, AreaLobe q, LightNode node, float variance) {
    // Across the plane of V and H, turns grow with V.H.
    float grown = node.v_dot_h / p.cosine;
    float wide = variance * mix(1.0, grown * grown, p.across);
    return node.measure > 0.0 ? node_colour(node, q) * environment_at(node.direction, wide) * node.measure : vec3(0.0);
}
#endif

// The width of what each drawn facet stands for: the more there are of them, the less; it is no part of the spread of all.
float drawn_width(float aspect, float facets) {
    return clamp(0.8 * sqrt(2.0 * TG_PI * min(aspect, 20.0) / facets), 0.01, 0.9);
}

vec2 drawn_place(int number, float aspect, float own) {
    return normal_point(number) * sqrt(vec2(min(aspect * aspect, 400.0), 1.0) - vec2(own * own));
}

SurroundingsSeen surroundings_reflection(AreaLobe q) {
    LobePatch p = lobe_patch(q);
    SurroundingsSeen seen;
    seen.world = vec3(0.0);
    seen.things = vec3(0.0);
    seen.open = 1.0;
    int about = 0;
#ifdef TG_MIRRORED
    vec3 mirror = q.axes.normal * (2.0 * q.n_dot_v) - q.view;
    // No drawn facet is farther out than 5 standard deviations.
    float reach_rad = min(5.0 * p.aspect * sqrt(p.minor), TG_PI);
    about = casters_towards(q.place, mirror, reach_rad, TG_FAR, q.own, TG_SHOWS);
#endif
    float scale = TG_PI / q.form.scale;
#ifdef TG_ENVIRONMENT
    // Where no thing is near.
    int count = frame.view.z < 8.0 ? TG_TAPS_MOVING : TG_TAPS_RESTING;
    EnvironmentTaps taps = environment_taps(p.aspect, count);
    bool drawn = frame.series.y >= TG_LEAST_SERIES;
    float own = drawn_width(p.aspect, frame.series.y * float(TG_DRAWN_FACETS));
    int before = int(frame.series.x) * TG_DRAWN_FACETS;
    count = about != 0 ? 0 : (drawn ? TG_DRAWN_FACETS : count);
    float variance = p.minor * (drawn ? own * own : taps.width * taps.width);
    float weights = 0.0;
    for (int k = 0; k < count; ++k) {
        float tap = environment_tap_place(taps, count, k);
        float weight = drawn ? 1.0 : environment_tap_weight(taps, tap);
        vec2 place = drawn ? drawn_place(before + k, p.aspect, own) : vec2(tap, 0.0);
        weights += weight;
        seen.world += environment_of_node(p, q, patch_node(p, q, place, weight), variance);
    }
    seen.world *= scale / max(weights, 1.0e-20);
#endif
#ifdef TG_MIRRORED
    // Things are not blurred beforehand: rays through the whole lobe, others in each sample that is added.
    int facets = frame.view.z < 8.0 ? TG_FACETS_MOVING : TG_FACETS_RESTING;
    float number = frame.series.w / max(frame.series.z, 1.0);
    int first = int(number + 0.5) * facets;
    float thin = 0.01;
#ifdef TG_ENVIRONMENT
    thin = drawn_width(p.aspect, max(frame.series.y, number + 1.0) * float(facets));
#endif
    int rays = about != 0 ? facets : 0;
    vec3 behind = vec3(0.0);
    float open = 0.0;
    float lit = 0.0;
    for (int k = 0; k < rays; ++k) {
        LightNode node = patch_node(p, q, drawn_place(first + k, p.aspect, thin), 1.0);
        if (node.measure > 0.0) {
            MirroredThing thing = mirrored_thing(about, q.place, node.direction);
            lit += 1.0;
            if (thing.found) {
                seen.things += mirrored_light(thing, node, q, first + k) * node.measure;
            } else {
                open += 1.0;
#ifdef TG_ENVIRONMENT
                behind += environment_of_node(p, q, node, p.minor * thin * thin);
#endif
            }
        }
    }
    float share = scale / float(max(rays, 1));
    seen.things *= share;
    seen.world += behind * share;
    seen.open = lit > 0.0 ? open / lit : 1.0;
#endif
    return seen;
}
