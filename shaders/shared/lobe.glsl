// The anisotropic Gaussian lobe of facet angles, D = exp(-ln2 phi^2 (cos^2 psi/mu_t^2 + sin^2 psi/mu_b^2)).
//
// | quantity        | unit  | meaning |
// |-----------------|-------|---------|
// | phi             | rad   | angle between N and H |
// | psi             | rad   | azimuth of H about N, from the lobe's wide axis |
// | mu_t >= mu_b    | rad   | half widths at half maximum along the wide and the narrow axis |
// | rho             | rad   | azimuth of the wide axis, counter-clockwise from T seen from outside, in [0, pi) |
// | ln_mu_deg       | ln deg| ln(sqrt(mu_t mu_b) / 1 degree): the stored size |
// | e1, e2          | -     | ln sqrt(mu_t/mu_b) times (cos 2rho, sin 2rho): the stored shape |
//
// D(0) = 1. The stored form averages and interpolates without the jump of an angle at 180 degrees.

struct Lobe {
    float ln_mu_deg;
    float e1;
    float e2;
};

// The lobe as a quadratic form of d = phi (cos, sin): exponent = xx dx^2 + 2 xy dx dy + yy dy^2,
// with D = exp(-exponent); scale = ln2/(mu_t mu_b) = sqrt(det), in 1/rad^2.
struct LobeForm {
    float xx;
    float xy;
    float yy;
    float scale;
};

// Half vector in the tangent frame, as the log-map d = phi (cos, sin) about N, in rad.
struct Facet {
    float dx;
    float dy;
};

TG_FN Lobe lobe_from_mu(float mu_t_rad, float mu_b_rad, float rho_rad) {
    Lobe lobe;
    float r = float(0.5) * log(mu_t_rad / mu_b_rad);
    lobe.ln_mu_deg = float(0.5) * (log(mu_t_rad) + log(mu_b_rad)) - TG_LN_RAD_PER_DEG;
    lobe.e1 = r * cos(float(2.0) * rho_rad);
    lobe.e2 = r * sin(float(2.0) * rho_rad);
    return lobe;
}

TG_FN LobeForm lobe_form(Lobe lobe) {
    LobeForm form;
    float r2 = lobe.e1 * lobe.e1 + lobe.e2 * lobe.e2;
    float r = sqrt(r2);
    float up = exp(r + r);
    float down = float(1.0) / up;
    float c = float(0.5) * (up + down);
    // sinh(2r)/r; below r = 0.03 its series, whose next term is 4e-9 of the first.
    float k = r > float(0.03) ? float(0.5) * (up - down) / r
                              : float(2.0) + r2 * (float(4.0) / float(3.0) + r2 * (float(4.0) / float(15.0)));
    form.scale = TG_LN2 * exp(float(-2.0) * (lobe.ln_mu_deg + TG_LN_RAD_PER_DEG));
    form.xx = form.scale * (c - k * lobe.e1);
    form.yy = form.scale * (c + k * lobe.e1);
    form.xy = -form.scale * k * lobe.e2;
    return form;
}

// What remains where no anisotropy is in the scene.
TG_FN LobeForm lobe_form_isotropic(float ln_mu_deg) {
    LobeForm form;
    form.scale = TG_LN2 * exp(float(-2.0) * (ln_mu_deg + TG_LN_RAD_PER_DEG));
    form.xx = form.scale;
    form.yy = form.scale;
    form.xy = float(0.0);
    return form;
}

// phi by atan2(|N x H|, N.H): acos(N.H) is 18 % wrong in D at mu = 0.1 degrees in float.
TG_FN Facet facet_of_half_vector(vec3 half_vector, vec3 normal, vec3 tangent, vec3 bitangent) {
    Facet facet;
    float hx = dot(half_vector, tangent);
    float hy = dot(half_vector, bitangent);
    float hz = dot(half_vector, normal);
    float l = sqrt(hx * hx + hy * hy);
    float stretch = l > float(0.0) ? atan(l, hz) / l : float(1.0);
    facet.dx = hx * stretch;
    facet.dy = hy * stretch;
    return facet;
}

TG_FN float lobe_value(LobeForm form, Facet facet) {
    float exponent = form.xx * facet.dx * facet.dx + float(2.0) * form.xy * facet.dx * facet.dy +
                     form.yy * facet.dy * facet.dy;
    return exp(-max(exponent, float(0.0)));
}

// Weight that keeps the reflected energy when the roughness changes: ln2/(4 pi mu_t mu_b).
TG_FN float lobe_normalised_weight(LobeForm form) {
    return form.scale / (float(4.0) * TG_PI);
}
