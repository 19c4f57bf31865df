// Where an angle stands in a 1-D Fresnel table (bake/fresnel_table): texel i of `size` holds
// cos(theta) = (i/(size - 1))^2, so that texels crowd towards grazing light, where F bends.

// Position in texels, in [0, size - 1]: the integer part is the left texel, the rest the weight of the right one.
TG_FN float fresnel_table_position(float cos_theta, float size) {
    return sqrt(clamp(cos_theta, float(0.0), float(1.0))) * (size - float(1.0));
}

TG_FN float fresnel_table_cosine(float position, float size) {
    float x = position / (size - float(1.0));
    return x * x;
}
