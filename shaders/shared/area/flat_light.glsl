// A light that is flat: a rectangle or an ellipse, seen from the shaded point at the origin.

struct FlatLight {
    vec3 centre;
    vec3 u;        // unit, along half_u
    vec3 v;        // unit, perpendicular to u; it emits to the side of cross(u, v)
    float half_u;  // half of the side, or of the ellipse's axis
    float half_v;
};

// Half of the angle, rad, below which a side counts as this wide: a float could not tell its two edges apart.
#define TG_MIN_HALF_ANGLE float(1.0e-4)

// half sizes of 0 and above. A light thinner than TG_MIN_HALF_ANGLE is widened to it; a lamp of given power keeps it if
// its radiance is taken from the area of the light that is returned.
TG_FN FlatLight flat_light(vec3 centre, vec3 u, vec3 v, float half_u, float half_v) {
    FlatLight light;
    float least = TG_MIN_HALF_ANGLE * length(centre);
    light.centre = centre;
    light.u = u;
    light.v = v;
    light.half_u = max(half_u, least);
    light.half_v = max(half_v, least);
    return light;
}

// Height of the shaded point over the light's front, in the light's length; at most 0 behind it.
TG_FN float flat_light_height(FlatLight light) {
    return -dot(light.centre, cross(light.u, light.v));
}

// Where the lobe is strongest on the light's plane, and how the facet moves there: what slices are laid out by.
struct FlatFootprint {
    float u;
    float v;
    vec3 half_vector;
    vec3 turn_u;   // dH/du, dH/dv
    vec3 turn_v;
    vec2 z;        // facet and its derivatives in standard deviations of D
    vec2 z_u;
    vec2 z_v;
};

TG_FN vec2 whitened_facet(TangentFrame axes, LobeForm form, vec3 h) {
    float x = dot(h, axes.tangent);
    float y = dot(h, axes.bitangent);
    float k = sqrt(float(2.0) / form.xx);
    return vec2(k * (form.xx * x + form.xy * y), k * form.scale * y);
}

TG_FN FlatFootprint flat_footprint_at(FlatLight light, TangentFrame axes, vec3 view, LobeForm form, float u, float v) {
    FlatFootprint f;
    f.u = u;
    f.v = v;
    vec3 p = light.centre + light.u * u + light.v * v;
    float inv_r = float(1.0) / max(length(p), float(1.0e-20));
    vec3 direction = p * inv_r;
    vec3 sum = direction + view;
    float inv_s = float(1.0) / max(length(sum), float(1.0e-4));
    f.half_vector = sum * inv_s;
    vec3 du = (light.u - direction * dot(direction, light.u)) * (inv_r * inv_s);
    vec3 dv = (light.v - direction * dot(direction, light.v)) * (inv_r * inv_s);
    f.turn_u = du - f.half_vector * dot(f.half_vector, du);
    f.turn_v = dv - f.half_vector * dot(f.half_vector, dv);
    f.z = whitened_facet(axes, form, f.half_vector);
    f.z_u = whitened_facet(axes, form, f.turn_u);
    f.z_v = whitened_facet(axes, form, f.turn_v);
    return f;
}

// The point of the light nearest to the mirror direction, then nearest in the lobe's own measure.
TG_FN FlatFootprint flat_footprint(FlatLight light, TangentFrame axes, vec3 view, LobeForm form) {
    vec3 mirror = axes.normal * (float(2.0) * dot(axes.normal, view)) - view;
    float height = flat_light_height(light);
    float towards = -dot(mirror, cross(light.u, light.v));
    // The mirror ray may run along the light or away from it: then its point at the light's distance.
    float reach = length(light.centre);
    float s = towards * float(8.0) * reach > height ? height / towards : reach;
    vec3 hit = mirror * s - light.centre;
    float u = clamp(dot(hit, light.u), -light.half_u, light.half_u);
    float v = clamp(dot(hit, light.v), -light.half_v, light.half_v);
    FlatFootprint f = flat_footprint_at(light, axes, view, form, u, v);
    float uu = max(dot(f.z_u, f.z_u), float(1.0e-20));
    float vv = max(dot(f.z_v, f.z_v), float(1.0e-20));
    for (int i = 0; i < 2; i = i + 1) {
        vec2 z = f.z + f.z_u * (u - f.u) + f.z_v * (v - f.v);
        float next_u = clamp(u - dot(z, f.z_u) / uu, -light.half_u, light.half_u);
        z = z + f.z_u * (next_u - u);
        u = next_u;
        v = clamp(v - dot(z, f.z_v) / vv, -light.half_v, light.half_v);
    }
    return flat_footprint_at(light, axes, view, form, u, v);
}

// The pole of slices that run in the direction in which the facet turns at h.
TG_FN vec3 slice_pole(TangentFrame axes, vec3 h, vec3 turn) {
    vec3 w = turn * dot(axes.normal, h) - h * dot(axes.normal, turn);
    w = w - axes.normal * dot(axes.normal, w);
    float n2 = dot(w, w);
    float t2 = dot(turn, turn);
    return n2 > float(1.0e-12) * t2 && n2 > float(1.0e-30) ? w * (float(1.0) / sqrt(n2)) : axes.tangent;
}
