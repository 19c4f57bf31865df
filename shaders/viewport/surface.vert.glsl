// Every surface of the scene.
// Attributes: position, normal_part (normal, part id), uv, tangent. Object space, Blender units.
// Push constants model_0..2: rows of object to view space; object_state: -1 where the matrix mirrors, else 1;
// the material's number; a part id for the whole object, or -1.
#include "shared/model.glsl"

void main() {
    vec4 p = vec4(position, 1.0);
    vec3 in_view = vec3(dot(model_0, p), dot(model_1, p), dot(model_2, p));
    gl_Position = frame.projection * vec4(in_view, 1.0);
#ifdef TG_POSITION
    v_position = in_view;
#else
    v_position = in_view.z;
#endif

#if defined(TG_NORMAL) || defined(TG_TANGENT)
    // Scaled to about 1: cofactors of objects in mm in a scene in km would underflow.
    float longest2 = max(max(dot(model_0.xyz, model_0.xyz), dot(model_1.xyz, model_1.xyz)), dot(model_2.xyz, model_2.xyz));
    float scale = longest2 > 0.0 ? inversesqrt(longest2) : 0.0;
    vec3 row_x = model_0.xyz * scale;
    vec3 row_y = model_1.xyz * scale;
    vec3 row_z = model_2.xyz * scale;
#endif
#ifdef TG_NORMAL
    // The cofactor matrix carries normals through shear and non-uniform scale; its sign is the determinant's.
    vec3 n = vec3(dot(cross(row_y, row_z), normal_part.xyz), dot(cross(row_z, row_x), normal_part.xyz),
                  dot(cross(row_x, row_y), normal_part.xyz)) *
             object_state.x;
    float n_length2 = dot(n, n);
    v_normal = n_length2 > 0.0 ? n * inversesqrt(n_length2) : vec3(0.0, 0.0, 1.0);
#endif
#ifdef TG_TANGENT
    vec3 t = vec3(dot(row_x, tangent), dot(row_y, tangent), dot(row_z, tangent));
    float t_length2 = dot(t, t);
    v_tangent = t_length2 > 0.0 ? t * inversesqrt(t_length2) : vec3(0.0);
#endif
#ifdef TG_UV
    v_uv = uv;
#endif
#ifdef TG_PART
    v_part = normal_part.w;
#endif
}
