// One level of an HDRI: the level before it under a round Gaussian, on the sphere, border included.
//   sizes  width and height of this level and of the one before, without their borders of one texel
//   blur   standard deviation in rad; taps to each side of the middle
#include "shared/constants.glsl"
#include "viewport/equirect.glsl"

void main() {
    vec2 place = (gl_FragCoord.xy - 1.0) / sizes.xy;
    vec3 middle = equirect_direction(place);
    float longitude = (0.5 - place.x) * 2.0 * TG_PI;
    vec3 east = vec3(-sin(longitude), cos(longitude), 0.0);
    vec3 north = cross(middle, east);
    int reach = int(blur.y);
    float pitch = 2.8 * blur.x / float(reach);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int i = -reach; i <= reach; ++i) {
        for (int j = -reach; j <= reach; ++j) {
            vec2 at = vec2(float(i), float(j)) * pitch;
            float angle = length(at);
            if (angle < 3.1) {
                float sine_share = angle > 1.0e-4 ? sin(angle) / angle : 1.0;
                float weight = exp(-0.5 * angle * angle / (blur.x * blur.x)) * sine_share;
                vec3 direction = middle * cos(angle) + (east * at.x + north * at.y) * sine_share;
                vec2 texel = equirect_place(direction) * sizes.zw + 1.0;
                sum += textureLod(before, texel / (sizes.zw + 2.0), 0.0).xyz * weight;
                weights += weight;
            }
        }
    }
    out_colour = vec4(sum / weights, 1.0);
}
