// Polished steel under any number of lamps.
//   TG_ONE_LOBE   no maps: each part has one lobe, smooth or rough
//   TG_MAPS       lobes, w and h from an atlas        TG_SHAPE  shapes from a second one
//   TG_HADORI     the map has hadori                  TG_ANISOTROPIC, TG_TANGENT  as named
//   TG_POINTS, TG_SPOTS, TG_SUNS, TG_WORLD            what the scene has
#include "shared/model.glsl"
#include "viewport/lights.glsl"
#ifdef TG_MAPS
#include "viewport/atlas.glsl"
#endif

struct Steel {
    LobeForm ji;
    LobeForm ha;
    LobeForm hadori;
    float w;
    float h;
    float chi;
    float beta_ha;
    float beta_hadori;
};

#ifdef TG_BENCH_61
// The paper's own form: no table, the sum over wavelengths in each pixel, with the reflectance computed once for each
// light, wavelength and model. Only for measuring what the table saves.
vec3 colour_of(int row, float cos_i, float cos_h, float at_theta_i, float at_theta_h) {
    vec3 sum = vec3(0.0);
    for (int k = 0; k < TG_WAVELENGTHS; ++k) {
        vec2 nk = wavelengths.nk[k].xy;
#ifdef TG_ONE_LOBE
        float f = fresnel_conductor(nk.x, nk.y, cos_i) * at_theta_i;
#else
        float f = fresnel_conductor(nk.x, nk.y, cos_i) * at_theta_i + fresnel_conductor(nk.x, nk.y, cos_h) * at_theta_h;
#endif
        sum += wavelengths.rgb[row * TG_WAVELENGTHS + k].xyz * f;
    }
    return sum;
}
#endif

vec3 reflect_light(Arriving a, TangentFrame f, vec3 view, Steel s) {
    LightGeometry g = light_geometry(f.normal, f.tangent, f.bitangent, view, a.direction);
#ifdef TG_ONE_LOBE
    bool rough = s.w > 0.5;
    float amount = rough ? hamon_reflection(s.ji, g, s.chi) : ji_reflection(s.ji, g, s.chi);
    float cosine = rough ? g.cos_h : g.cos_i;
#ifdef TG_BENCH_61
    return a.colour * colour_of(a.row, cosine, 0.0, amount, 0.0);
#else
    return a.colour * (table_rgb(a.row, cosine) * amount);
#endif
#else
    float hadori = 0.0;
#ifdef TG_HADORI
    hadori = hamon_reflection(s.hadori, g, s.beta_hadori);
#endif
    Reflection r = blend_reflection(ji_reflection(s.ji, g, s.chi), hadori, hamon_reflection(s.ha, g, s.beta_ha), s.w, s.h);
#ifdef TG_BENCH_61
    return a.colour * colour_of(a.row, g.cos_i, g.cos_h, r.at_theta_i, r.at_theta_h);
#else
    return a.colour * (table_rgb(a.row, g.cos_i) * r.at_theta_i + table_rgb(a.row, g.cos_h) * r.at_theta_h);
#endif
#endif
}

LobeForm form_of(vec3 stored) {
#ifdef TG_ANISOTROPIC
    Lobe lobe;
    lobe.ln_mu_deg = stored.x;
    lobe.e1 = stored.y;
    lobe.e2 = stored.z * object_state.x;
    return lobe_form(lobe);
#else
    return lobe_form_isotropic(stored.x);
#endif
}

void main() {
    vec3 view = view_direction(v_position);
#ifdef TG_TANGENT
    vec3 along = v_tangent;
#else
    // No tangents on the mesh: the object's own x axis, which is a generated blade's length.
    vec3 along = vec3(model_0.x, model_1.x, model_2.x);
#endif
    TangentFrame f = tangent_frame(facing_normal(v_normal), along);

    Steel s;
#ifdef TG_ONE_LOBE
    s.ji.xx = v_form.x;
    s.ji.xy = v_form.y;
    s.ji.yy = v_form.z;
    s.ji.scale = v_form.w;
#ifndef TG_ANISOTROPIC
    s.ji.xy = 0.0;
    s.ji.xx = s.ji.scale;
    s.ji.yy = s.ji.scale;
#endif
    s.chi = v_weight.x;
    s.w = v_weight.y;
#endif
#ifdef TG_MAPS
    int part = clamp(int(v_part + 0.5), 0, TG_PART_COUNT - 1);
    vec2 at = atlas_coordinate(v_uv);
    vec4 map = texture(lobes_atlas, at);
    s.w = map.z;
    s.h = map.w;
#ifdef TG_SHAPE
    vec4 shape = texture(shape_atlas, at);
    vec3 stored_ji = vec3(map.x, shape.x, shape.y);
    vec3 stored_ha = vec3(map.y, shape.z, shape.w);
#else
    vec3 stored_ji = vec3(map.x, steel.ji_of_part[part].yz);
    vec3 stored_ha = vec3(map.y, steel.ha.yz);
#endif
    s.ji = form_of(stored_ji);
    s.ha = form_of(stored_ha);
    s.chi = steel.ji_of_part[part].w;
    s.beta_ha = steel.ha.w;
#ifdef TG_HADORI
    s.hadori = form_of(steel.hadori.xyz);
    s.beta_hadori = steel.hadori.w;
#else
    s.h = 0.0;
#endif
#endif

    vec3 sum = vec3(0.0);
    int first = 0;
#ifdef TG_POINTS
    int points = int(frame.counts.x);
    for (int i = 0; i < points; ++i) {
        sum += reflect_light(arriving_point(i, v_position), f, view, s);
    }
    first += points;
#endif
#ifdef TG_SPOTS
    int spot_count = int(frame.counts.y);
    for (int i = 0; i < spot_count; ++i) {
        sum += reflect_light(arriving_spot(first + i, i, v_position), f, view, s);
    }
    first += spot_count;
#endif
#ifdef TG_SUNS
    int suns = int(frame.counts.z);
    for (int i = 0; i < suns; ++i) {
        sum += reflect_light(arriving_sun(first + i), f, view, s);
    }
#endif
#ifdef TG_WORLD
    // A uniform room: the lobes gather the same radiance from everywhere, so what is left is F at theta_r.
    float cos_r = dot(f.normal, view);
    if (cos_r > TG_MIN_COS) {
        sum += frame.world.xyz * table_rgb(int(frame.world.w), cos_r);
    }
#endif
    out_colour = vec4(finite_output(sum), 1.0);
#ifdef TG_AUX
    out_depth = dot(frame.depth_row.xyz, v_position) + frame.depth_row.w;
    out_part = object_state.z < 0.0 ? floor(v_part + 0.5) : object_state.z;
#endif
}
