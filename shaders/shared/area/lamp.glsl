// Blender's amounts (shared/light.glsl) of lamps that have a size, as radiance. An area lamp of power P and area A has
// P/(pi A) to the one side that it shines to, which is P/(pi d^2) on a facing surface far off.

// Radiance of a flat lamp of this area.
TG_FN float light_area_radiance(float power_w, float area) {
    return power_w / (TG_PI * max(area, float(1.0e-30)));
}

// Radiance of a sphere or a sun of this half angle that gives the irradiance to a surface facing it.
TG_FN float light_cone_radiance(float irradiance, float half_angle_rad) {
    float s = sin(half_angle_rad);
    return irradiance / (TG_PI * max(s * s, float(1.0e-16)));
}

// Share of a flat lamp's radiance at an angle of this tangent from its axis; tan_half: of half its spread, of which
// normalising is 1/(tan_half - angle). The lamp's power is kept.
TG_FN float light_area_spread(float tangent, float tan_half, float normalising) {
    return max((tan_half - tangent) * normalising, float(0.0));
}
