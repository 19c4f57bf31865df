// From one pixel to the next (of a gathered sample: over its share of one): how the surface and what is seen in it turn.
// The shared filter (shared/area/lobe_filter.glsl) then takes the mean of a lobe over the pixel's facets.
#include "shared/area/gaussian_part.glsl"
#include "shared/area/lobe_filter.glsl"

// Longest turn of a normal in a pixel, rad: what a silhouette has. Not beyond: its square must stay finite.
#define TG_MAX_TURN 2.0

struct PixelStep {
    vec3 place;  // change of the position, along the surface
    vec3 view;   // of the direction to the viewer
    vec2 normal; // of the normal, in the smooth frame
};

// ray: change of a pixel's (x, y)/depth, in an orthographic view of (x, y).
PixelStep pixel_step(TangentFrame axes, vec3 view, vec3 ray, vec2 bend, float depth, bool orthographic) {
    PixelStep s;
    float width = frame.view.w;
    vec3 across = ray * (orthographic ? width : depth * width);
    // Along the line of sight to where the tangent plane is met.
    float facing = max(dot(axes.normal, view), 0.02);
    s.place = across - view * (dot(axes.normal, across) / facing);
    // The point's distance is depth over the cosine to the view's axis.
    s.view = orthographic ? vec3(0.0) : (view * dot(view, across) - across) * (view.z / max(depth, 1.0e-20));
    float size2 = dot(bend, bend);
    // NaN fails both comparisons.
    float share = size2 <= TG_MAX_TURN * TG_MAX_TURN ? 1.0 : size2 < 1.0e30 ? TG_MAX_TURN * inversesqrt(size2) : 0.0;
    s.normal = share > 0.0 ? bend * (share * width) : vec2(0.0);
    return s;
}

// The change of the facet for a light in this direction at 1/nearness.
Facet facet_turn(TangentFrame axes, vec3 view, vec3 light, float nearness, PixelStep s) {
    vec3 sum = view + light;
    float inv = inversesqrt(max(dot(sum, sum), 1.0e-8));
    vec3 h = sum * inv;
    vec3 turn = (s.view + (light * dot(light, s.place) - s.place) * nearness) * inv;
    turn -= h * dot(h, turn);
    Facet facet;
    facet.dx = dot(turn, axes.tangent) - s.normal.x;
    facet.dy = dot(turn, axes.bitangent) - s.normal.y;
    return facet;
}

// Mean of D over the pixel, with as many Gaussians across the longer turn as the shorter one needs.
float pixel_lobe_value(LobeForm form, Facet facet, Facet right, Facet up) {
    vec2 a = facet_whitened(form, right);
    vec2 b = facet_whitened(form, up);
    float shorter = min(dot(a, a), dot(b, b));
    return lobe_value_box(form, facet, right, up, shorter < 4.0 ? 1 : 4);
}
