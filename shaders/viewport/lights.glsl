// Where a lamp stands from a point. Its colour comes after the question whether the surface reflects it at all.
struct Towards {
    vec3 direction; // unit
    float distance_squared;
    float nearness; // 1/distance, of a sun 0
};

Towards towards_point(int index, vec3 position) {
    // To the same bits in every program that asks.
    TG_PRECISE vec3 to_light = lights.light[index].place.xyz - position;
    TG_PRECISE float distance_squared = max(dot(to_light, to_light), TG_MIN_DISTANCE_SQUARED);
    float nearness = inversesqrt(distance_squared);
    TG_PRECISE vec3 direction = to_light * nearness;
    Towards t;
    t.direction = direction;
    t.distance_squared = distance_squared;
    t.nearness = nearness;
    return t;
}

Towards towards_sun(int index) {
    Towards t;
    t.direction = lights.light[index].place.xyz;
    t.distance_squared = 1.0;
    t.nearness = 0.0;
    return t;
}

int lamp_row(int index) {
    return int(lights.light[index].colour.w);
}

// Irradiance on a surface facing the lamp, times the lamp's RGB.
vec3 point_colour(int index, Towards t) {
    return lights.light[index].colour.xyz * (light_point_intensity(1.0) * light_distance_falloff(t.distance_squared));
}

#ifdef TG_SPOTS
vec3 spot_colour(int index, int spot_index, Towards t) {
    TgSpot spot = spots.spot[spot_index];
    vec3 in_lamp = -vec3(dot(spot.axis_x.xyz, t.direction), dot(spot.axis_y.xyz, t.direction),
                         dot(spot.axis_z.xyz, t.direction));
    float cos_angle = in_lamp.z * inversesqrt(max(dot(in_lamp, in_lamp), 1.0e-20));
    return point_colour(index, t) * light_spot_blend(cos_angle, spot.axis_y.w, spot.axis_x.w);
}
#endif

vec3 sun_colour(int index) {
    return lights.light[index].colour.xyz;
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
