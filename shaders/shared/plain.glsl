// What is not polished steel: the rusted nakago, the stand, the cloth. A dielectric (n = 1.5) over a
// Lambertian ground, with the blade's own lobe for its gloss. Colour enters as an RGB albedo, which is
// enough for surfaces whose spectra nobody measured.
// Both in 1/sr; irradiance on a surface facing the light multiplies them.

TG_FN float plain_diffuse(LightGeometry g) {
    return g.lit * g.cos_i / TG_PI;
}

TG_FN float plain_gloss(LobeForm form, LightGeometry g, float ior) {
    return hamon_reflection(form, g, float(-1.0)) * fresnel_conductor(ior, float(0.0), g.cos_h);
}
