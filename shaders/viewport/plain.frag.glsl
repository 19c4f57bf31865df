// What is not polished steel: the nakago, the stand, the cloth (shared/plain.glsl).
// In the table, every texel of a row is the light's own RGB: colour enters as an albedo.
#include "shared/model.glsl"
#include "viewport/lights.glsl"

vec3 light_rgb(int row) {
    return table.rgb[row * TG_TABLE_SIZE].xyz;
}

vec3 reflect_light(Arriving a, TangentFrame f, vec3 view, LobeForm form) {
    LightGeometry g = light_geometry(f.normal, f.tangent, f.bitangent, view, a.direction);
    float metallic = plain.gloss.y;
    vec3 albedo = plain.albedo.xyz;
    vec3 diffuse = albedo * (plain_diffuse(g) * (1.0 - metallic));
    vec3 gloss = vec3(plain_gloss(form, g, plain.albedo.w) * (1.0 - metallic)) +
                 albedo * (hamon_reflection(form, g, -1.0) * metallic);
    return a.colour * light_rgb(a.row) * (diffuse + gloss);
}

void main() {
    vec3 view = view_direction(v_position);
    // The gloss is isotropic: any tangent will do.
    TangentFrame f = tangent_frame(facing_normal(v_normal), vec3(model_0.x, model_1.x, model_2.x));
    LobeForm form = lobe_form_isotropic(plain.gloss.x);
    vec3 sum = vec3(0.0);
    int first = 0;
#ifdef TG_POINTS
    int points = int(frame.counts.x);
    for (int i = 0; i < points; ++i) {
        sum += reflect_light(arriving_point(i, v_position), f, view, form);
    }
    first += points;
#endif
#ifdef TG_SPOTS
    int spot_count = int(frame.counts.y);
    for (int i = 0; i < spot_count; ++i) {
        sum += reflect_light(arriving_spot(first + i, i, v_position), f, view, form);
    }
    first += spot_count;
#endif
#ifdef TG_SUNS
    int suns = int(frame.counts.z);
    for (int i = 0; i < suns; ++i) {
        sum += reflect_light(arriving_sun(first + i), f, view, form);
    }
#endif
#ifdef TG_WORLD
    float cos_r = dot(f.normal, view);
    if (cos_r > TG_MIN_COS) {
        float metallic = plain.gloss.y;
        vec3 share = plain.albedo.xyz + vec3(fresnel_conductor(plain.albedo.w, 0.0, cos_r) * (1.0 - metallic));
        sum += frame.world.xyz * light_rgb(int(frame.world.w)) * share;
    }
#endif
    out_colour = vec4(finite_output(sum), 1.0);
#ifdef TG_AUX
    out_depth = dot(frame.depth_row.xyz, v_position) + frame.depth_row.w;
    out_part = object_state.z < 0.0 ? floor(v_part + 0.5) : object_state.z;
#endif
}
