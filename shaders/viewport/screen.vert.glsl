// A rectangle of the screen at the far end of the depth range: with the test GREATER it covers what was drawn.
// Push constant rect: left, bottom, right, top in clip space.
void main() {
    gl_Position = vec4(mix(rect.xy, rect.zw, position), 1.0, 1.0);
}
