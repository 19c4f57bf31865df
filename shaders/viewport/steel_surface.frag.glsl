// First half of polished steel: which steel a pixel shows. The second half (steel_light) then runs once for each pixel,
// whereas this one runs several times where triangles are smaller than the blocks that GPUs shade.
//   out_surface  folded normal (2), depth, number: +-(8 (material + 1024 (own + 1)) + part + 1), negative where the
//                object is mirrored; own: the object's number among those that hide lamps, -1 for none
//   out_map      ln_mu of the ji and of the ha, w, h             (TG_MAPS)
//   out_turn     cosine and sine of twice the tangent's angle    (TG_ANISOTROPIC)
//   out_shape    e1, e2 of the ji and of the ha                  (TG_SHAPE)
//   out_bend     the normal's change from one pixel to the next, to the right and upwards, in the pixel's smooth
//                frame: of the triangle's own surface, whatever lies beside it            (TG_FILTERED)
//   out_spread   two turns of the normal, in the smooth frame, whose squares add up to the covariance of the normal map's
//                texels in the pixel                                                      (TG_NORMAL_MAP)
#include "shared/model.glsl"
#ifdef TG_MAPS
#include "viewport/atlas.glsl"
#endif
#ifdef TG_NORMAL_MAP
#include "viewport/normal_map.glsl"

// The map's normal on this surface. facing: -1 where the face is seen from behind; it then shows the map's other side, as dents
// where there were bumps.
BentNormal mapped_normal(vec3 normal, NormalTexel texel, float facing) {
    TangentFrame axes = tangent_frame(normal, v_tangent);
    vec2 ray = gl_FragCoord.xy * frame.ray.xy + frame.ray.zw;
    vec3 view = frame.view.x > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(vec3(-ray, 1.0));
    texel.lean *= facing;
    BentNormal bent = bent_normal(axes.normal, axes.tangent, axes.bitangent * chart_side(v_uv), texel);
    bent.normal = normal_mirroring_outwards(bent.normal, axes.normal, view);
    return bent;
}
#endif

void main() {
    // A face seen from behind shows its other side.
    float facing = gl_FrontFacing == (object_state.x > 0.0) ? 1.0 : -1.0;
    vec3 normal = v_normal * facing;
    float inv_length = inversesqrt(max(dot(normal, normal), 1.0e-20));
#ifdef TG_NORMAL_MAP
    NormalSample map = normal_map_sample(v_uv);
    BentNormal bent = mapped_normal(normal * inv_length, map.texel, facing);
    vec2 folded = fold_normal(bent.normal);
#else
    vec2 folded = fold_normal(normal * inv_length);
#endif
    float part = clamp(floor(v_part + 0.5), 0.0, float(TG_PART_COUNT - 1));
    out_surface = vec4(folded, -v_position, object_state.x * (8.0 * object_state.y + part + 1.0));
#ifdef TG_MAPS
    vec2 at = atlas_coordinate(v_uv);
    out_map = texture(lobes_atlas, at);
#ifdef TG_SHAPE
    out_shape = texture(shape_atlas, at);
#endif
#endif
#if defined(TG_FILTERED) || defined(TG_ANISOTROPIC) || defined(TG_NORMAL_MAP)
    TangentFrame smooth_axes = smooth_frame(unfold_normal(folded));
#endif
#ifdef TG_FILTERED
    vec3 to_right = dFdx(normal) * inv_length;
    vec3 upwards = dFdy(normal) * inv_length;
#ifdef TG_NORMAL_MAP
    // Coarser levels have the map's own turns within the pixel in their spread.
    to_right = mix(dFdx(bent.normal), to_right, map.coarse);
    upwards = mix(dFdy(bent.normal), upwards, map.coarse);
#endif
    out_bend = vec4(dot(to_right, smooth_axes.tangent), dot(to_right, smooth_axes.bitangent),
                    dot(upwards, smooth_axes.tangent), dot(upwards, smooth_axes.bitangent));
#endif
#ifdef TG_NORMAL_MAP
    out_spread = vec4(dot(bent.spread_a, smooth_axes.tangent), dot(bent.spread_a, smooth_axes.bitangent),
                      dot(bent.spread_b, smooth_axes.tangent), dot(bent.spread_b, smooth_axes.bitangent));
#endif
#ifdef TG_ANISOTROPIC
#ifdef TG_TANGENT
    vec3 along = v_tangent;
#else
    // No tangents on the mesh: the object's own x axis, which is a generated blade's length.
    vec3 along = vec3(model_0.x, model_1.x, model_2.x);
#endif
    TangentFrame axes = tangent_frame(smooth_axes.normal, along);
    float c = dot(axes.tangent, smooth_axes.tangent);
    float s = dot(axes.tangent, smooth_axes.bitangent);
    float unit = 1.0 / max(c * c + s * s, 1.0e-12);
    out_turn = vec2((c * c - s * s) * unit, 2.0 * c * s * unit);
#endif
}
