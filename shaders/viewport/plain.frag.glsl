// What is not polished steel: the nakago, the stand, the cloth (shared/plain.glsl).
// In the table, every texel of a row is the light's own RGB: colour enters as an albedo.
#include "shared/model.glsl"
#include "viewport/lights.glsl"
#include "viewport/casters.glsl"
#ifdef TG_PICTURES
#include "viewport/pictures.glsl"
#endif

vec3 light_rgb(int row) {
    return table.rgb[row * TG_TABLE_SIZE].xyz;
}

vec3 reflect_light(vec3 light, vec3 colour, int row, vec3 normal, vec3 view, LobeForm form) {
    HalfAngle half_vector = half_angle(normal, view, light);
    LightGeometry g = light_geometry_at(normal, view, light, half_vector, facet_isotropic(half_vector));
    float metallic = plain.gloss.y;
    vec3 albedo = plain.albedo.xyz;
    vec3 diffuse = albedo * (plain_diffuse(g) * (1.0 - metallic));
    vec3 gloss = vec3(plain_gloss(form, g, plain.albedo.w) * (1.0 - metallic)) +
                 albedo * (hamon_reflection(form, g, -1.0) * metallic);
    return colour * light_rgb(row) * (diffuse + gloss);
}

#ifdef TG_AREAS
#define TG_DARK_EXPONENT 30.0
// ln of 5 degrees.
#define TG_BROAD_GLOSS 1.6
#include "viewport/areas.glsl"

vec3 node_colour(LightNode node, AreaLobe q) {
    float metallic = plain.gloss.y;
    float coat = fresnel_conductor(plain.albedo.w, 0.0, node.v_dot_h) * (1.0 - metallic);
    return (vec3(coat) + plain.albedo.xyz * metallic) * shadowed_node(node, q);
}

// The matt part by the lamp's form factor, the gloss by slices of its lobe as on steel.
vec3 reflect_area(TgArea area, AreaSeen seen, AreaLobe q) {
    vec3 matt = plain.albedo.xyz * ((1.0 - plain.gloss.y) / TG_PI);
    vec3 sum = seen.radiance > 0.0 ? matt * area_irradiance(area, seen, q.axes.normal) : vec3(0.0);
#ifdef TG_PICTURES
    sum *= matt_picture(area, seen, q.axes.normal);
#endif
    AreaSeen glossy = seen;
    float share = 1.0;
#ifdef TG_SHADOWS
    if (seen.radiance > 0.0) {
        share = area_share_seen(area, seen, q.axes.normal, int(frame.series.z), frame.series.w);
        sum *= share;
    }
    // A broad gloss sees as much of the lamp as the matt part does: rays of its own only for a mirror.
    glossy.before = plain.gloss.x > TG_BROAD_GLOSS ? 0 : seen.before;
    share = plain.gloss.x > TG_BROAD_GLOSS ? share : 1.0;
#endif
    // And shows none of its outline's detail.
    int slices = plain.gloss.x > TG_BROAD_GLOSS ? 4 : int(frame.view.z);
    bool shines = plain.albedo.w > 1.0 || plain.gloss.y > 0.0;
    int times = shines && area_reached(seen, q) ? 1 : 0;
    for (int once = 0; once < times; ++once) {
        sum += area_reflection(area, glossy, q, slices) * (share * lobe_normalised_weight(q.form));
    }
    return area.colour.xyz * light_rgb(int(area.colour.w)) * sum;
}

#ifdef TG_ENVIRONMENT
#include "viewport/environment.glsl"
#endif
#endif

#define TG_REACHED(towards) (dot(normal, towards.direction) > TG_MIN_COS ? 1 : 0)
#define TG_REFLECT(towards, colour, row) reflect_light(towards.direction, colour, row, normal, view, form)
#ifdef TG_SHADOWS
#define TG_SEEN(index, towards) lamp_seen(index, towards, start, own)
#else
#define TG_SEEN(index, towards) 1.0
#endif

void main() {
    vec3 place = v_position;
    vec3 view = frame.view.x > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(-place);
    // A face seen from behind shows its other side.
    vec3 normal = normalize(v_normal) * (gl_FrontFacing == (object_state.x > 0.0) ? 1.0 : -1.0);
    LobeForm form = lobe_form_isotropic(plain.gloss.x);
    vec3 sum = vec3(0.0);
#ifdef TG_SHADOWS
    // The facet's own plane: a smooth normal may lean behind it.
    vec3 plane = cross(dFdx(place), dFdy(place));
    plane *= (dot(plane, view) < 0.0 ? -1.0 : 1.0) * inversesqrt(max(dot(plane, plane), 1.0e-38));
    vec3 start = above_surface(place, plane);
    // Of a blade's nakago: the blade's own number.
    int own = int(object_state.y + 0.5) - 1;
#endif
#include "viewport/loop.glsl"
#ifdef TG_AREAS
    AreaLobe q;
    q.form = form;
    q.axes = smooth_frame(normal);
    q.view = view;
    q.n_dot_v = dot(normal, view);
    q.widest = form.scale;
    q.at_theta_i = false;
    q.shadowed = true;
    q.row = 0;
    int area_count = q.n_dot_v > TG_MIN_COS ? int(frame.view.y) : 0;
    for (int i = 0; i < area_count; ++i) {
        AreaSeen seen = area_seen(areas.area[i], place);
#ifdef TG_SHADOWS
        seen = area_seen_past(seen, areas.area[i], start, own);
#endif
        sum += reflect_area(areas.area[i], seen, q);
    }
#endif
#ifdef TG_ENVIRONMENT
    if (q.n_dot_v > TG_MIN_COS) {
        vec3 matt = plain.albedo.xyz * (1.0 - plain.gloss.y) * environment_matt(normal);
        sum += frame.world.xyz * light_rgb(int(frame.world.w)) *
               (matt + surroundings_reflection(q).world * lobe_normalised_weight(form));
    }
#endif
#ifdef TG_WORLD
    float cos_r = dot(normal, view);
    if (cos_r > TG_MIN_COS) {
        vec3 share = plain.albedo.xyz + vec3(fresnel_conductor(plain.albedo.w, 0.0, cos_r) * (1.0 - plain.gloss.y));
        sum += frame.world.xyz * light_rgb(int(frame.world.w)) * share;
    }
#endif
#ifdef TG_SHINES
    // Once, however many passes over the lamps there are.
    vec3 shine = object_state.z > -1.5 ? plain.shine.xyz : vec3(0.0);
#ifdef TG_UV
    vec2 texels = vec2(length(dFdx(v_uv)), length(dFdy(v_uv))) * pictures.picture[int(plain.shine.w) - 1].level[0].z;
    shine *= picture_at(int(plain.shine.w) - 1, v_uv, 0.3 * max(texels.x, texels.y));
#endif
    sum += shine;
#endif
    out_colour = vec4(finite_output(sum), 1.0);
}
