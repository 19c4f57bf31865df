// Second half of polished steel: each pixel under any number of lamps.
//   TG_ONE_LOBE   no maps: a part has one lobe, smooth or rough   TG_MAPS  both lobes, w and h from maps
//   TG_HADORI     the map has hadori                              TG_SHAPE, TG_ANISOTROPIC  as named
//   TG_POINTS, TG_SPOTS, TG_SUNS, TG_WORLD                        what the scene has
//   TG_MANY       other steels are in the picture
#include "shared/model.glsl"
#include "viewport/lights.glsl"
#include "viewport/steel_pixel.glsl"

// Where a lobe's exponent is above this its value is below 1e-13 of its peak, and the lamp is skipped.
#define TG_DARK_EXPONENT 30.0

struct Steel {
    vec3 view;
    TangentFrame axes;
    LobeForm ji;
    LobeForm ha;
    LobeForm hadori;
    float w;
    float h;
    float chi;
    float beta_ha;
    float beta_hadori;
    float widest; // smallest exponent per sin^2 phi of all lobes
};

LobeForm form_of(Lobe lobe) {
#ifdef TG_ANISOTROPIC
    return lobe_form(lobe);
#else
    return lobe_form_isotropic(lobe.ln_mu_deg);
#endif
}

// A lower bound of the form's smaller eigenvalue: of the exponent over phi^2.
float least(LobeForm form) {
#ifdef TG_ANISOTROPIC
    float d = 0.5 * (form.xx - form.yy);
    return max(0.5 * (form.xx + form.yy) - sqrt(d * d + form.xy * form.xy), 0.0);
#else
    return form.scale;
#endif
}

#ifdef TG_BENCH_61
// The paper's own form: no table, the sum over wavelengths in each pixel, with the reflectance computed once for each
// light, wavelength and model. Only for measuring what the table saves.
vec3 spectral_sum(int row, float cos_i, float cos_h, float at_theta_i, float at_theta_h) {
    vec3 sum = vec3(0.0);
    for (int k = 0; k < TG_WAVELENGTHS; ++k) {
        vec2 nk = wavelengths.nk[k].xy;
        float f = fresnel_conductor(nk.x, nk.y, cos_i) * at_theta_i;
        f += fresnel_conductor(nk.x, nk.y, cos_h) * at_theta_h;
        sum += wavelengths.rgb[row * TG_WAVELENGTHS + k].xyz * f;
    }
    return sum;
}
#endif

vec3 reflect_light(Arriving a, Steel s) {
    vec3 sum = vec3(0.0);
    vec3 half_vector = half_vector_of(s.view, a.direction);
    vec3 n_cross_h = cross(s.axes.normal, half_vector);
    float n_dot_h = dot(s.axes.normal, half_vector);
    // phi >= sin(phi), so this is dark where the lobe is. H behind the surface needs no test: one of the cosines
    // is negative there. A loop, because some compilers turn a plain branch into two sides that are both computed.
    float exponent = s.widest * dot(n_cross_h, n_cross_h);
    int times = exponent < TG_DARK_EXPONENT && n_dot_h > 0.0 && dot(s.axes.normal, a.direction) > TG_MIN_COS ? 1 : 0;
#ifdef TG_EVERY_LAMP
    // Only for measuring what this saves.
    times = 1;
#endif
    for (int once = 0; once < times; ++once) {
#ifdef TG_ANISOTROPIC
        Facet facet = facet_of_half_vector(half_vector, s.axes.normal, s.axes.tangent, s.axes.bitangent);
#else
        Facet facet = facet_isotropic(half_vector, s.axes.normal);
#endif
        LightGeometry g = light_geometry_at(s.axes.normal, s.view, a.direction, half_vector, facet);
#ifdef TG_ONE_LOBE
        bool rough = s.w > 0.5;
        float amount = rough ? hamon_reflection(s.ji, g, s.chi) : ji_reflection(s.ji, g, s.chi);
        float cosine = rough ? g.cos_h : g.cos_i;
#ifdef TG_BENCH_61
        sum += a.colour * spectral_sum(a.row, g.cos_i, g.cos_h, rough ? 0.0 : amount, rough ? amount : 0.0);
#else
        sum += a.colour * (table_rgb(a.row, cosine) * amount);
#endif
#else
        float hadori = 0.0;
#ifdef TG_HADORI
        hadori = hamon_reflection(s.hadori, g, s.beta_hadori);
#endif
        Reflection r =
            blend_reflection(ji_reflection(s.ji, g, s.chi), hadori, hamon_reflection(s.ha, g, s.beta_ha), s.w, s.h);
#ifdef TG_BENCH_61
        sum += a.colour * spectral_sum(a.row, g.cos_i, g.cos_h, r.at_theta_i, r.at_theta_h);
#else
        sum += a.colour * (table_rgb(a.row, g.cos_i) * r.at_theta_i + table_rgb(a.row, g.cos_h) * r.at_theta_h);
#endif
#endif
    }
    return sum;
}

#define TG_REFLECT(arriving) reflect_light(arriving, s)

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 surface = texelFetch(surface_buffer, at, 0);
#ifdef TG_MANY
    if (int(abs(surface.w) - 0.5) / 8 != int(object_state.y + 0.5)) {
        discard;
    }
#endif
    SteelPixel p = steel_pixel(surface, at);
    vec3 place = p.position;
    Steel s;
    s.view = p.view;
    s.axes = p.axes;
    s.w = p.w;
    s.h = p.h;
    s.chi = p.chi;
    s.ji = form_of(p.ji);
    s.widest = least(s.ji);
#ifndef TG_ONE_LOBE
    s.ha = form_of(p.ha);
    s.beta_ha = p.beta_ha;
    s.widest = p.w > 0.0 ? min(s.widest, least(s.ha)) : s.widest;
#ifdef TG_HADORI
    s.hadori = form_of(p.hadori);
    s.beta_hadori = p.beta_hadori;
    s.widest = p.h > 0.0 ? min(s.widest, least(s.hadori)) : s.widest;
#endif
#endif
    vec3 sum = vec3(0.0);
#include "viewport/loop.glsl"
#ifdef TG_WORLD
    // A uniform room: the lobes gather the same radiance from everywhere, so what is left is F at theta_r.
    float cos_r = dot(s.axes.normal, s.view);
    if (cos_r > TG_MIN_COS) {
        sum += frame.world.xyz * table_rgb(int(frame.world.w), cos_r);
    }
#endif
    out_colour = vec4(finite_output(sum), 1.0);
}
