// A picture, scaled: 1/samples when samples are gathered, 1 when a picture is put on the screen.
void main() {
    out_colour = texelFetch(picture, ivec2(gl_FragCoord.xy) - ivec2(origin.xy), 0) * origin.w;
}
