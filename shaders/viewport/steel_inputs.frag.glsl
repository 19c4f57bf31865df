// The inputs of the model as steel_light gets them, for accuracy tests: the reference computes from these.
#include "shared/model.glsl"
#include "viewport/steel_pixel.glsl"

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 surface = texelFetch(surface_buffer, at, 0);
#ifdef TG_MANY
    if (steel_number(surface) != int(object_state.y + 0.5)) {
        discard;
    }
#endif
    SteelPixel p = steel_pixel(surface, at);
    Lobe hadori;
#ifdef TG_HADORI
    hadori = p.hadori;
#else
    hadori.ln_mu_deg = 0.0;
    hadori.e1 = 0.0;
    hadori.e2 = 0.0;
#endif
    // Blender binds six targets at most, so the hadori's lobe fills what the others leave free.
    out_normal = vec4(p.axes.normal, hadori.e1);
    out_tangent = vec4(p.axes.tangent, 1.0 + float(p.part) + 8.0 * object_state.y);
    out_view = vec4(p.view, hadori.e2);
    out_position = vec4(p.position, p.h);
    out_ji = vec4(p.ji.ln_mu_deg, p.ji.e1, p.ji.e2, p.w);
    out_ha = vec4(p.ha.ln_mu_deg, p.ha.e1, p.ha.e2, hadori.ln_mu_deg);
}
