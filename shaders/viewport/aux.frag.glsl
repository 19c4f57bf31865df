// Depth along the view axis and part id, for the passes of a final render.
void main() {
    out_depth = -v_position;
    out_part = object_state.z < 0.0 ? floor(v_part + 0.5) : object_state.z;
}
