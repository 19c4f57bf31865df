// Reflection of one blade point under one light, without its colour: what multiplies F(theta_i) and
// what multiplies F(theta_H). Everything here is free of wavelength; the caller multiplies by the
// table rows (GPU, float) or by F(n, k) E per wavelength (reference, double).
//
//   ji     C_f = chi D(mu_ji) F(theta_i) E                      (smooth, Fresnel-based)
//   hamon  C_t = beta D(mu) G/cos(theta_r) F(theta_H) E         (rough, Torrance-Sparrow)
//   point  C = (1 - w) [(1 - h) C_f + h C_t(mu_hadori)] + w C_t(mu_ha)
//
// Normalised weights: chi = ln2/(4 pi mu_t mu_b) G/cos(theta_r), beta = ln2/(4 pi mu_t mu_b).
// Measured weights: constants chi and beta as fitted (the paper's form).

// The light and the view against the surface: everything that the three lobes share.
struct LightGeometry {
    float lit;              // 1, or 0 where light or view is below TG_MIN_COS
    float cos_i;            // N.L: angle of F for the ji
    float cos_h;            // L.H: angle of F for the hamon
    float g_over_cos_r;
    Facet facet;
};

// What multiplies the two Fresnel look-ups.
struct Reflection {
    float at_theta_i;       // 1/sr, multiplies F(theta_i) E
    float at_theta_h;       // 1/sr, multiplies F(theta_H) E
};

// All vectors of unit length. Defined results where nothing is reflected: N.L or N.V <= TG_MIN_COS (so 0,
// negative and exactly 90 degrees; this covers L = -V), and any vector that is zero, NaN or infinite: lit = 0 and
// every other member 0, so that no later product meets NaN.
TG_FN LightGeometry light_geometry_at(vec3 normal, vec3 view, vec3 light, HalfAngle half_vector, Facet facet) {
    LightGeometry g;
    float n_dot_v = dot(normal, view);
    g.cos_i = dot(normal, light);
    g.cos_h = clamp(float(0.5) * half_vector.size, float(0.0), float(1.0));
    bool finite = half_vector.along > float(0.0) && half_vector.size < float(4.0);
    g.lit = (g.cos_i > TG_MIN_COS && n_dot_v > TG_MIN_COS && finite) ? float(1.0) : float(0.0);
    g.facet = facet;
    g.g_over_cos_r =
        shadowing_over_cos_r(half_vector.along / max(half_vector.size, float(1.0e-7)), max(n_dot_v, TG_MIN_COS),
                             max(g.cos_i, TG_MIN_COS), g.cos_h);
    // Comparisons with NaN are false, so lit is 0 here whatever a vector holds.
    if (g.lit < float(0.5)) {
        g.cos_i = float(0.0);
        g.cos_h = float(0.0);
        g.g_over_cos_r = float(0.0);
        g.facet.dx = float(0.0);
        g.facet.dy = float(0.0);
    }
    return g;
}

TG_FN LightGeometry light_geometry(vec3 normal, vec3 tangent, vec3 bitangent, vec3 view, vec3 light) {
    HalfAngle half_vector = half_angle(normal, view, light);
    return light_geometry_at(normal, view, light, half_vector, facet_of(half_vector, tangent, bitangent));
}

// measured < 0 asks for the normalised weight, else it is chi.
TG_FN float ji_reflection(LobeForm form, LightGeometry g, float measured_chi) {
    float weight = measured_chi < float(0.0) ? lobe_normalised_weight(form) * g.g_over_cos_r : measured_chi;
    return g.lit * weight * lobe_value(form, g.facet);
}

// measured < 0 asks for the normalised weight, else it is beta.
TG_FN float hamon_reflection(LobeForm form, LightGeometry g, float measured_beta) {
    float weight = measured_beta < float(0.0) ? lobe_normalised_weight(form) : measured_beta;
    return g.lit * weight * g.g_over_cos_r * lobe_value(form, g.facet);
}

// A share in [0, 1]: what lies outside is clamped, NaN is 0.
TG_FN float sanitise_share(float share) {
    return share > float(0.0) ? min(share, float(1.0)) : float(0.0);
}

// stored_w, stored_h: shares of the hamon and, of the rest, of the hadori, as a map holds them.
TG_FN Reflection blend_reflection(float ji, float hadori, float ha, float stored_w, float stored_h) {
    Reflection r;
    float w = sanitise_share(stored_w);
    float h = sanitise_share(stored_h);
    r.at_theta_i = (float(1.0) - w) * (float(1.0) - h) * ji;
    r.at_theta_h = (float(1.0) - w) * h * hadori + w * ha;
    return r;
}
