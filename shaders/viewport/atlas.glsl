// A map with its mip levels side by side in one texture: the levels average covariances, which no hardware
// filter does (design, "Frame and maps"). One bilinear fetch from the nearest level.
vec2 atlas_coordinate(vec2 uv) {
    vec2 size = steel.level[0].zw;
    vec2 dx = dFdx(uv) * size;
    vec2 dy = dFdy(uv) * size;
    // log2 of the footprint's longer side in texels of level 0.
    float lod = 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1.0e-12)) + frame.counts.w;
    int level = clamp(int(lod + 0.5), 0, int(steel.atlas.z) - 1);
    vec4 rect = steel.level[level];
    return (rect.xy + clamp(uv, vec2(0.0), vec2(1.0)) * rect.zw) * steel.atlas.xy;
}
