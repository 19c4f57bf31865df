// The HDRI where nothing stands before it. Push constant origin: its colour.
#include "shared/constants.glsl"
#include "viewport/environment_read.glsl"

void main() {
    vec2 ray = gl_FragCoord.xy * frame.ray.xy + frame.ray.zw;
    vec3 direction = frame.view.x > 0.5 ? vec3(0.0, 0.0, -1.0) : normalize(vec3(ray, -1.0));
    vec3 colour = environment_texel(environment.level[0], equirect_place(in_picture(direction))) * origin.xyz;
    out_colour = vec4(min(colour, vec3(TG_OUTPUT_MAX)), 1.0);
}
