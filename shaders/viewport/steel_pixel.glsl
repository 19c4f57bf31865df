#ifdef TG_FILTERED
#include "viewport/pixel_step.glsl"
#endif

// Of the number that steel_surface leaves: the material's.
int steel_number(vec4 surface) {
    return (int(abs(surface.w) - 0.5) / 8) % TG_STEEL_CAPACITY;
}

// What steel_surface left in a pixel.
struct SteelPixel {
    int part;
    int own; // number among the scene's things that hide lamps, or -1
    vec3 position;
    vec3 view;
    TangentFrame axes;
    Lobe ji;
    Lobe ha;
    Lobe hadori;
    float w;
    float h;
    float chi;
    float beta_ha;
    float beta_hadori;
#ifdef TG_FILTERED
    PixelStep right;
    PixelStep up;
#endif
#ifdef TG_NORMAL_MAP
    Facet spread_a;
    Facet spread_b;
#endif
};

// The lobe's azimuth from the axes that the pixel keeps. mirror: the object's own azimuths run the other way round.
Lobe turned(vec4 stored, vec2 turn, float mirror) {
    Lobe lobe;
    float e2 = stored.z * mirror;
    lobe.ln_mu_deg = stored.x;
    lobe.e1 = stored.y * turn.x - e2 * turn.y;
    lobe.e2 = stored.y * turn.y + e2 * turn.x;
    return lobe;
}

SteelPixel steel_pixel(vec4 surface, ivec2 at) {
    SteelPixel p;
    vec2 ray = gl_FragCoord.xy * frame.ray.xy + frame.ray.zw;
    bool orthographic = frame.view.x > 0.5;
    p.position = orthographic ? vec3(ray, -surface.z) : vec3(ray * surface.z, -surface.z);
    p.view = orthographic ? vec3(0.0, 0.0, 1.0) : normalize(vec3(-ray, 1.0));
    p.axes = smooth_frame(unfold_normal(surface.xy));
#ifdef TG_FILTERED
    vec4 bend = texelFetch(bend_buffer, at, 0);
    p.right = pixel_step(p.axes, p.view, vec3(frame.ray.x, 0.0, 0.0), bend.xy, surface.z, orthographic);
    p.up = pixel_step(p.axes, p.view, vec3(0.0, frame.ray.y, 0.0), bend.zw, surface.z, orthographic);
#endif
#ifdef TG_NORMAL_MAP
    vec4 spread = texelFetch(spread_buffer, at, 0);
    p.spread_a.dx = spread.x;
    p.spread_a.dy = spread.y;
    p.spread_b.dx = spread.z;
    p.spread_b.dy = spread.w;
#endif
    float mirror = surface.w < 0.0 ? -1.0 : 1.0;
    int number = int(abs(surface.w) + 0.5) - 1;
    p.part = number - 8 * (number / 8);
    p.own = number / (8 * TG_STEEL_CAPACITY) - 1;
    vec2 turn = vec2(1.0, 0.0);
#ifdef TG_ANISOTROPIC
    turn = texelFetch(turn_buffer, at, 0).xy;
#endif
#ifdef TG_MAPS
    vec4 map = texelFetch(map_buffer, at, 0);
    vec4 ji = steel.ji_of_part[p.part];
    vec4 ha = steel.ha;
    p.chi = ji.w;
    p.beta_ha = ha.w;
#ifdef TG_SHAPE
    vec4 shape = texelFetch(shape_buffer, at, 0);
    ji = vec4(map.x, shape.xy, 0.0);
    ha = vec4(map.y, shape.zw, 0.0);
#else
    ji.x = map.x;
    ha.x = map.y;
#endif
    p.ji = turned(ji, turn, mirror);
    p.ha = turned(ha, turn, mirror);
    p.w = map.z;
    p.h = 0.0;
#ifdef TG_HADORI
    p.h = map.w;
    p.hadori = turned(steel.hadori, turn, mirror);
    p.beta_hadori = steel.hadori.w;
#endif
#else
    vec4 own = steel.part[p.part];
    vec4 rough = steel.rough_part[p.part / 4];
    p.ji = turned(own, turn, mirror);
    p.ha = p.ji;
    p.w = rough[p.part - 4 * (p.part / 4)];
    p.h = 0.0;
    p.chi = own.w;
    p.beta_ha = own.w;
#endif
    return p;
}
