// The material's normal map in a pixel (TG_NORMAL_MAP): all its mip levels side by side in one texture, as atlas.glsl's.
#include "shared/detail/normal_map.glsl"

struct NormalSample {
    NormalTexel texel;
    float coarse; // 0: the map's own texels are seen; 1: what the pixel covers of the map is in the texel's spread
};

vec2 normal_map_coordinate(int level, vec2 uv) {
    vec4 rect = normal_map.level[level];
    return (rect.xy + clamp(uv, vec2(0.0), vec2(1.0)) * rect.zw) * normal_map.atlas.xy;
}

// Between two levels: a highlight that jumped from one level to the next would be seen to move.
NormalSample normal_map_sample(vec2 uv) {
    vec2 size = normal_map.level[0].zw;
    vec2 dx = dFdx(uv) * size;
    vec2 dy = dFdy(uv) * size;
    float last = normal_map.atlas.z - 1.0;
    float lod = clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1.0e-12)) + frame.counts.w, 0.0, last);
    int fine = int(lod);
    int coarse = min(fine + 1, int(last));
    float between = lod - float(fine);
    vec2 at = normal_map_coordinate(fine, uv);
    vec2 above = normal_map_coordinate(coarse, uv);
    vec4 lean_sd = mix(texture(leans_atlas, at), texture(leans_atlas, above), between);
    NormalSample s;
    s.texel.lean = lean_sd.xy;
    s.texel.sd = lean_sd.zw;
    s.texel.correlation = mix(texture(correlations_atlas, at).x, texture(correlations_atlas, above).x, between);
    s.coarse = min(lod, 1.0);
    return s;
}

// 1 where u, v and the side that is seen are right-handed, else -1: v runs the other way round on a mirrored chart.
float chart_side(vec2 uv) {
    vec2 right = dFdx(uv);
    vec2 up = dFdy(uv);
    return right.x * up.y - right.y * up.x < 0.0 ? -1.0 : 1.0;
}
