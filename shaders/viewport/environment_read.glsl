// An HDRI under round Gaussians of any width: its levels are blurred by 0, 1, 2 and from there on 2 sqrt(2)^k texels.
#include "viewport/equirect.glsl"

vec3 environment_texel(vec4 rect, vec2 place) {
    return textureLod(environment_atlas, (rect.xy + place * rect.zw) * environment.atlas.xy, 0.0).xyz;
}

vec3 in_picture(vec3 direction) {
    return vec3(dot(environment.to_picture[0].xyz, direction), dot(environment.to_picture[1].xyz, direction),
                dot(environment.to_picture[2].xyz, direction));
}

// direction: unit, in view space; variance: of the Gaussian along one axis, rad^2.
vec3 environment_at(vec3 direction, float variance) {
    vec2 place = equirect_place(in_picture(direction));
    // Reading between texels is a blur of 1/6 texel squared itself.
    float texels = variance / (environment.atlas.w * environment.atlas.w);
    int last = int(environment.atlas.z) - 1;
    float first = 25.0 / 6.0; // of level 2
    float octave = floor(log2(max(texels / first, 1.0e-6)) + 1.0e-5);
    int level = 2 + int(octave);
    float low = first * exp2(octave);
    float high = 2.0 * low;
    if (texels < first) {
        level = texels < 7.0 / 6.0 ? 0 : 1;
        low = level == 0 ? 1.0 / 6.0 : 7.0 / 6.0;
        high = level == 0 ? 7.0 / 6.0 : first;
    }
    // A mixture of two Gaussians that has the variance.
    float share = clamp((texels - low) / (high - low), 0.0, 1.0);
    int lower = min(level, last);
    int upper = min(level + 1, last);
    return mix(environment_texel(environment.level[lower], place), environment_texel(environment.level[upper], place), share);
}

vec3 environment_matt(vec3 normal) {
    return environment_texel(environment.matt, equirect_place(in_picture(normal)));
}
