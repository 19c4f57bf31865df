// The pictures of lamps of a size, as a lobe's node and as a matt surface see them. Part of areas.glsl.
// What the lamp's picture adds to its light in this direction, blurred by so much. Lamps without one: 1.
vec3 area_picture(TgArea area, AreaSeen seen, vec3 direction, float blur_rad) {
    int number = int(area.axis_x.w + 0.5) - 1;
    int times = seen.kind == TG_AREA_RECTANGLE && number >= 0 ? 1 : 0;
    vec3 colour = vec3(1.0);
    for (int once = 0; once < times; ++once) {
        vec3 facing = cross(seen.outline.u, seen.outline.v);
        float cosine = max(-dot(direction, facing), 1.0e-3);
        float away = -dot(seen.outline.centre, facing) / cosine;
        vec3 place = direction * away - seen.outline.centre;
        vec3 at = vec3(dot(place, seen.outline.u) / seen.outline.half_u, dot(place, seen.outline.v) / seen.outline.half_v, 1.0);
        TgPicture picture = pictures.picture[number];
        float texels = picture.info.y * inversesqrt(seen.outline.half_u * seen.outline.half_v);
        colour = picture_at(number, vec2(dot(picture.to_u.xyz, at), dot(picture.to_v.xyz, at)),
                            blur_rad * away * inversesqrt(cosine) * texels);
    }
    return colour;
}

// Its mean as a matt surface sees it: over sixteen points of the lamp.
vec3 matt_picture(TgArea area, AreaSeen seen, vec3 normal) {
    bool even = seen.kind != TG_AREA_RECTANGLE || area.axis_x.w < 0.5;
    int points = even ? 0 : 16;
    vec3 sum = vec3(0.0);
    float all = 0.0;
    for (int k = 0; k < points; ++k) {
        vec2 at = vec2((float(k) + 0.5) / 8.0 - 1.0, 2.0 * fract(0.61803399 * float(k)) - 1.0);
        vec3 to_point = lamp_point(area, seen, at);
        float distance2 = max(dot(to_point, to_point), TG_MIN_DISTANCE_SQUARED);
        float away = sqrt(distance2);
        vec3 direction = to_point / away;
        float weight = max(dot(normal, direction), 0.0) * max(-dot(direction, cross(seen.outline.u, seen.outline.v)), 0.0) / distance2;
        // Each stands for a sixteenth of the lamp.
        float blur = 0.3 * sqrt(seen.outline.half_u * seen.outline.half_v) / away;
        sum += weight * area_picture(area, seen, direction, blur);
        all += weight;
    }
    return even ? vec3(1.0) : (all > 0.0 ? sum / all : vec3(0.0));
}
