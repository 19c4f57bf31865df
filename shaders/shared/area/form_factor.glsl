// What a light of a size gives to a matt surface: the integral of N.L over its directions above the horizon, in sr. Times
// the light's radiance this is the irradiance.
//
// | function        | error |
// |-----------------|-------|
// | flat_irradiance | rectangle: exact (Lambert's sum over the edges, clipped at the horizon); ellipse: as the polygon of
//                     12 sides and the same area, 0.4 % where the light fills half of the sky, less elsewhere; lights
//                     below 0.02 rad: as a point, 0.05 % |
// | cone_irradiance | exact: sphere and sun, above, across and below the horizon |
//
// Sources: Lambert 1760; Baum, Rushmeier, Winget 1989 (the polygon); Snyder 1996, Lagarde & de Rousiers 2014 (the sphere).

// Of one edge of the outline; a, b: unit.
TG_FN float edge_irradiance(vec3 a, vec3 b, vec3 normal) {
    vec3 c = cross(a, b);
    float s = length(c);
    float stretch = s > float(1.0e-4) ? atan(s, dot(a, b)) / s : float(1.0);
    return float(0.5) * dot(c, normal) * stretch;
}

// Corner k of count; round: of the ellipse's polygon.
TG_FN vec3 flat_corner(FlatLight light, bool round_light, int k) {
    float angle = float(k) * (TG_PI / float(6.0));
    // sqrt(pi/3): twelve sides of the circle's area.
    float u = round_light ? float(1.0233267079464884) * cos(angle) : (k == 1 || k == 2 ? float(-1.0) : float(1.0));
    float v = round_light ? float(1.0233267079464884) * sin(angle) : (k > 1 ? float(-1.0) : float(1.0));
    return light.centre + light.u * (u * light.half_u) + light.v * (v * light.half_v);
}

TG_FN float flat_irradiance(FlatLight light, bool round_light, vec3 normal) {
    float height = flat_light_height(light);
    if (height <= float(0.0)) {
        return float(0.0);
    }
    float d2 = dot(light.centre, light.centre);
    if (light.half_u * light.half_u + light.half_v * light.half_v < float(4.0e-4) * d2) {
        float area = light.half_u * light.half_v * (round_light ? TG_PI : float(4.0));
        return max(dot(light.centre, normal), float(0.0)) * height * area / (d2 * d2);
    }
    int count = round_light ? 12 : 4;
    float sum = float(0.0);
    bool crossed = false;
    vec3 enter = normal;
    vec3 leave = normal;
    vec3 p = flat_corner(light, round_light, count - 1);
    float hp = dot(p, normal);
    for (int k = 0; k < count; k = k + 1) {
        vec3 q = flat_corner(light, round_light, k);
        float hq = dot(q, normal);
        if (hp > float(0.0) || hq > float(0.0)) {
            vec3 a = hp > float(0.0) ? p : p + (q - p) * (hp / (hp - hq));
            vec3 b = hq > float(0.0) ? q : p + (q - p) * (hp / (hp - hq));
            a = unit_or_zero(a);
            b = unit_or_zero(b);
            sum = sum + edge_irradiance(a, b, normal);
            crossed = crossed || hp <= float(0.0) || hq <= float(0.0);
            enter = hp > float(0.0) ? enter : a;
            leave = hq > float(0.0) ? leave : b;
        }
        p = q;
        hp = hq;
    }
    // The horizon closes the outline.
    sum = crossed ? sum + edge_irradiance(leave, enter, normal) : sum;
    return abs(sum);
}

// Directions within the angle of a unit axis; angle in (0, pi/2).
TG_FN float cone_irradiance(vec3 axis, float angle, vec3 normal) {
    float c = clamp(dot(axis, normal), float(-1.0), float(1.0));
    float s = sin(angle);
    float s2 = s * s;
    if (c >= s) {
        return TG_PI * s2 * c;
    }
    if (c <= -s) {
        return float(0.0);
    }
    float sine = sqrt(max(float(1.0) - c * c, float(1.0e-12)));
    float x = cos(angle) / s;
    float y = clamp(-x * c / sine, float(-1.0), float(1.0));
    float root = sine * sqrt(float(1.0) - y * y);
    return max((c * acos(y) - x * root) * s2 + atan(root, max(x, float(1.0e-12))), float(0.0));
}
