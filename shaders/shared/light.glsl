// Blender's lamps as irradiance on a surface that faces the lamp, in W/m^2 of a light whose spectrum has
// luminance 1: what the model multiplies its 1/sr by (E in shared/surface.glsl).
//
// | lamp  | Blender's number     | irradiance at distance d                     |
// |-------|----------------------|----------------------------------------------|
// | point | power P (W)          | P/(4 pi d^2): P spread evenly over a sphere  |
// | spot  | power P (W)          | the point's, times the cone's blend: the cone takes light away, it does not gather it |
// | sun   | strength S (W/m^2)   | S at any distance                            |
// | area  | power P (W)          | shared/area/lamp.glsl                        |
//
// A point lamp is a sphere of radius r and radiance L = P/(4 pi^2 r^2), which gives pi L r^2/d^2 whatever r is,
// as long as the whole sphere is above the horizon. With Blender's soft falloff it is a disk that faces each point: P/(4 pi (d^2 + r^2)). A grey card of albedo a then has the radiance a E/pi.
// Checked against Cycles for each lamp, with distance, blend, colour and exposure: tests/blender/test_engine_light_units.py.

// A lamp nearer than this counts as this far: 1e-6 of Blender's units.
#define TG_MIN_DISTANCE_SQUARED float(1.0e-12)

// Radiant intensity of a point or spot lamp, W/sr.
TG_FN float light_point_intensity(float power_w) {
    return power_w / (float(4.0) * TG_PI);
}

TG_FN float light_distance_falloff(float distance_squared) {
    return float(1.0) / max(distance_squared, TG_MIN_DISTANCE_SQUARED);
}

// Blend of a spot lamp's edge. cos_angle: between the lamp's axis and the direction to the point, in the
// lamp's own (scaled) frame; cos_half: of half the cone's angle; blend in [0, 1], the soft share of 1 - cos_half.
TG_FN float light_spot_blend(float cos_angle, float cos_half, float blend) {
    float t = clamp((cos_angle - cos_half) / max((float(1.0) - cos_half) * blend, float(1.0e-4)), float(0.0), float(1.0));
    return t * t * (float(3.0) - float(2.0) * t);
}
