// The inputs of the model as steel_light gets them, for accuracy tests: the reference computes from these.
#include "shared/model.glsl"
#include "viewport/steel_pixel.glsl"

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 surface = texelFetch(surface_buffer, at, 0);
#ifdef TG_MANY
    if (int(abs(surface.w) - 0.5) / 8 != int(object_state.y + 0.5)) {
        discard;
    }
#endif
    SteelPixel p = steel_pixel(surface, at);
    out_normal = vec4(p.axes.normal, 1.0);
    out_tangent = vec4(p.axes.tangent, float(p.part));
    out_view = vec4(p.view, object_state.y);
    out_position = vec4(p.position, p.h);
    out_ji = vec4(p.ji.ln_mu_deg, p.ji.e1, p.ji.e2, p.w);
    out_ha = vec4(p.ha.ln_mu_deg, p.ha.e1, p.ha.e2, 0.0);
#ifdef TG_HADORI
    out_hadori = vec4(p.hadori.ln_mu_deg, p.hadori.e1, p.hadori.e2, 0.0);
#else
    out_hadori = vec4(0.0);
#endif
}
