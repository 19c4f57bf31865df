// What is not polished steel: the nakago, the stand, the cloth (shared/plain.glsl).
// In the table, every texel of a row is the light's own RGB: colour enters as an albedo.
#include "shared/model.glsl"
#include "viewport/lights.glsl"

vec3 light_rgb(int row) {
    return table.rgb[row * TG_TABLE_SIZE].xyz;
}

vec3 reflect_light(Arriving a, vec3 normal, vec3 view, LobeForm form) {
    vec3 half_vector = half_vector_of(view, a.direction);
    LightGeometry g = light_geometry_at(normal, view, a.direction, half_vector, facet_isotropic(half_vector, normal));
    float metallic = plain.gloss.y;
    vec3 albedo = plain.albedo.xyz;
    vec3 diffuse = albedo * (plain_diffuse(g) * (1.0 - metallic));
    vec3 gloss = vec3(plain_gloss(form, g, plain.albedo.w) * (1.0 - metallic)) +
                 albedo * (hamon_reflection(form, g, -1.0) * metallic);
    return a.colour * light_rgb(a.row) * (diffuse + gloss);
}

#define TG_REFLECT(arriving) reflect_light(arriving, normal, view, form)

void main() {
    vec3 place = v_position;
    vec3 view = frame.view.x > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(-place);
    // A face seen from behind shows its other side.
    vec3 normal = normalize(v_normal) * (gl_FrontFacing == (object_state.x > 0.0) ? 1.0 : -1.0);
    LobeForm form = lobe_form_isotropic(plain.gloss.x);
    vec3 sum = vec3(0.0);
#include "viewport/loop.glsl"
#ifdef TG_WORLD
    float cos_r = dot(normal, view);
    if (cos_r > TG_MIN_COS) {
        vec3 share = plain.albedo.xyz + vec3(fresnel_conductor(plain.albedo.w, 0.0, cos_r) * (1.0 - plain.gloss.y));
        sum += frame.world.xyz * light_rgb(int(frame.world.w)) * share;
    }
#endif
    out_colour = vec4(finite_output(sum), 1.0);
}
