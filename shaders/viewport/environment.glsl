// An HDRI mirrored by a lobe: round taps along the long axis of what the lobe sees of it (shared/area/environment_taps.glsl), each with
// Fresnel and shadowing of its own facet. Behind areas.glsl, whose lobes and nodes it shares.
#include "viewport/environment_read.glsl"

// Taps: while something moves, and at rest.
#define TG_TAPS_MOVING 5
#define TG_TAPS_RESTING 25

// What the lobe reflects of the surroundings, without the weight of the lobe and the world's colour.
vec3 environment_reflection(AreaLobe q) {
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
    vec3 turn = (e1 * axis.x + e2 * (axis.y / cosine)) * (0.5 * sigma);
    float size = max(length(turn), 1.0e-12);
    vec3 turn_axis = turn / size;
    float variance = minor * taps.width * taps.width;
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int k = 0; k < count; ++k) {
        float place = environment_tap_place(taps, count, k);
        float weight = environment_tap_weight(taps, place);
        weights += weight;
        float angle = clamp(place * size, -1.5, 1.5);
        vec3 h = q.axes.normal * cos(angle) + turn_axis * sin(angle);
        LightNode node;
        node.v_dot_h = min(dot(q.view, h), 1.0);
        node.n_dot_h = cos(angle);
        node.direction = h * (2.0 * node.v_dot_h) - q.view;
        node.n_dot_l = dot(q.axes.normal, node.direction);
        bool lit = node.n_dot_l > TG_MIN_COS && node.v_dot_h > 0.0;
        // The lobe's measure on the sphere of facets against that on its plane.
        float sphere = abs(angle) > 1.0e-3 ? sin(angle) / angle : 1.0;
        // Across the plane of V and H, turns grow with V.H.
        float grown = node.v_dot_h / cosine;
        float wide = variance * mix(1.0, grown * grown, axis.x * axis.x);
        node.measure = lit ? weight * sphere * 4.0 * node.v_dot_h : 0.0;
        int times = lit ? 1 : 0;
        for (int once = 0; once < times; ++once) {
            sum += node_colour(node, q) * environment_at(node.direction, wide) * node.measure;
        }
    }
    return sum * (TG_PI / (q.form.scale * weights));
}
