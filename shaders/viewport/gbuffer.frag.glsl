// What the GPU itself interpolated, for accuracy tests: the reference computes from these.
#include "shared/model.glsl"
#include "viewport/lights.glsl"
#ifdef TG_MAPS
#include "viewport/atlas.glsl"
#endif

void main() {
    vec3 view = view_direction(v_position);
#ifdef TG_TANGENT
    vec3 along = v_tangent;
#else
    vec3 along = vec3(model_0.x, model_1.x, model_2.x);
#endif
    TangentFrame f = tangent_frame(facing_normal(v_normal), along);
    int part = clamp(int(v_part + 0.5), 0, TG_PART_COUNT - 1);
#ifdef TG_MAPS
    vec2 at = atlas_coordinate(v_uv);
    vec4 map = texture(lobes_atlas, at);
    vec4 shape = vec4(steel.ji_of_part[part].yz, steel.ha.yz);
#ifdef TG_SHAPE
    shape = texture(shape_atlas, at);
#endif
#else
    vec4 rough = steel.rough_part[part / 4];
    float w = rough[part - 4 * (part / 4)];
    vec4 map = vec4(steel.part[part].x, steel.part[part].x, w, 0.0);
    vec4 shape = vec4(steel.part[part].yz, steel.part[part].yz);
#endif
#ifndef TG_ANISOTROPIC
    shape = vec4(0.0);
#endif
#ifndef TG_HADORI
    map.w = 0.0;
#endif
    shape.y *= object_state.x;
    shape.w *= object_state.x;
    out_normal = vec4(f.normal, 1.0);
    out_tangent = vec4(f.tangent, float(part));
    out_view = vec4(view, dot(frame.depth_row.xyz, v_position) + frame.depth_row.w);
    out_position = vec4(v_position, object_state.y);
    out_ji = vec4(map.x, shape.x, shape.y, map.z);
    out_ha = vec4(map.y, shape.z, shape.w, map.w);
}
