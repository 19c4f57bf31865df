// Rectangles that shine with a picture (core/lamp_pictures.py).

vec3 picture_level(int number, int level, vec2 place) {
    vec4 rect = pictures.picture[number].level[level];
    return textureLod(pictures_atlas, (rect.xy + clamp(place, 0.0, 1.0) * rect.zw) * pictures.atlas.xy, 0.0).xyz;
}

// place: 0 to 1; spread: standard deviation of what is asked for, in texels. Level l, read between its texels, is blurred by
// sqrt(4^l/4 - 1/12) texels.
vec3 picture_at(int number, vec2 place, float spread) {
    float last = pictures.picture[number].info.x - 1.0;
    float level = clamp(log2(max(2.0 * spread, 1.0e-6)), 0.0, last);
    int lower = int(level);
    int upper = min(lower + 1, int(last));
    return mix(picture_level(number, lower, place), picture_level(number, upper, place), level - float(lower));
}
