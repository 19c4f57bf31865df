// A picture, scaled: 1/samples when samples are gathered, 1 when a picture is put on the screen. origin: its corner in
// the target; side of its pixels in those of the target (above 1: drawn coarsely while something moves); factor.
void main() {
    vec2 at = gl_FragCoord.xy - origin.xy;
    if (origin.z == 1.0) {
        out_colour = texelFetch(picture, ivec2(at), 0) * origin.w;
        return;
    }
    ivec2 last = textureSize(picture, 0) - 1;
    vec2 place = at / origin.z - 0.5;
    ivec2 low = ivec2(floor(place));
    vec2 share = place - vec2(low);
    vec4 below = mix(texelFetch(picture, clamp(low, ivec2(0), last), 0),
                     texelFetch(picture, clamp(low + ivec2(1, 0), ivec2(0), last), 0), share.x);
    vec4 above = mix(texelFetch(picture, clamp(low + ivec2(0, 1), ivec2(0), last), 0),
                     texelFetch(picture, clamp(low + ivec2(1, 1), ivec2(0), last), 0), share.x);
    out_colour = mix(below, above, share.y) * origin.w;
}
