// One lamp as it arrives at a point.
struct Arriving {
    vec3 direction; // unit, to the light
    vec3 colour;    // irradiance on a surface facing the light, times the light's RGB
    int row;        // in the table
};

Arriving arriving_point(int index, vec3 position) {
    Arriving a;
    vec4 place = lights.light[index].place;
    vec4 colour = lights.light[index].colour;
    vec3 to_light = place.xyz - position;
    float distance_squared = max(dot(to_light, to_light), TG_MIN_DISTANCE_SQUARED);
    a.direction = to_light * inversesqrt(distance_squared);
    a.colour = colour.xyz * (light_point_intensity(1.0) * light_distance_falloff(distance_squared));
    a.row = int(colour.w);
    return a;
}

#ifdef TG_SPOTS
Arriving arriving_spot(int index, int spot_index, vec3 position) {
    Arriving a = arriving_point(index, position);
    TgSpot spot = spots.spot[spot_index];
    vec3 in_lamp = -vec3(dot(spot.axis_x.xyz, a.direction), dot(spot.axis_y.xyz, a.direction),
                         dot(spot.axis_z.xyz, a.direction));
    float cos_angle = in_lamp.z * inversesqrt(max(dot(in_lamp, in_lamp), 1.0e-20));
    a.colour *= light_spot_blend(cos_angle, spot.axis_y.w, spot.axis_x.w);
    return a;
}
#endif

Arriving arriving_sun(int index) {
    Arriving a;
    a.direction = lights.light[index].place.xyz;
    a.colour = lights.light[index].colour.xyz;
    a.row = int(lights.light[index].colour.w);
    return a;
}

vec3 table_rgb(int row, float cos_theta) {
    float p = fresnel_table_position(cos_theta, float(TG_TABLE_SIZE));
    int i = min(int(p), TG_TABLE_SIZE - 2);
    int at = row * TG_TABLE_SIZE + i;
    return mix(table.rgb[at].xyz, table.rgb[at + 1].xyz, p - float(i));
}

// What leaves a shader is finite and fits the target: NaN becomes 0. Negative values stay: a sodium lamp lies
// outside of Rec.709, and cutting its blue off would change its colour before the view transform sees it.
float finite_channel(float c) {
    return abs(c) < TG_OUTPUT_MAX ? c : (c > 0.0 ? TG_OUTPUT_MAX : (c < 0.0 ? -TG_OUTPUT_MAX : 0.0));
}

vec3 finite_output(vec3 c) {
    return vec3(finite_channel(c.x), finite_channel(c.y), finite_channel(c.z));
}
