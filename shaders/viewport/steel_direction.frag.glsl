// The direction to one lamp (object_state.w) as steel_light computes it, for accuracy tests.
#include "shared/model.glsl"
#include "viewport/lights.glsl"
#include "viewport/steel_pixel.glsl"

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 surface = texelFetch(surface_buffer, at, 0);
    if (steel_number(surface) != int(object_state.y + 0.5)) {
        discard;
    }
    int lamp = int(object_state.w + 0.5);
    bool sun = lamp >= int(frame.counts.x + frame.counts.y);
    vec3 direction = towards_sun(lamp).direction;
    if (!sun) {
        direction = towards_point(lamp, steel_pixel(surface, at).position).direction;
    }
    out_direction = vec4(direction, 1.0);
}
