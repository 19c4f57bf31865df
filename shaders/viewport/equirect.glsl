// Equirectangular pictures as Blender lays them out.
vec2 equirect_place(vec3 direction) {
    float longitude = abs(direction.x) + abs(direction.y) > 0.0 ? atan(direction.y, direction.x) : 0.0;
    return vec2(0.5 - longitude / (2.0 * TG_PI), 0.5 + atan(direction.z, length(vec2(direction.x, direction.y))) / TG_PI);
}

// Beyond the edges it goes on round the sphere and over its poles.
vec3 equirect_direction(vec2 place) {
    float longitude = (0.5 - place.x) * 2.0 * TG_PI;
    float latitude = (place.y - 0.5) * TG_PI;
    return vec3(cos(latitude) * cos(longitude), cos(latitude) * sin(longitude), sin(latitude));
}
