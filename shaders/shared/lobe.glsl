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

// Half widths of the axes, as people state them.
struct LobeAxes {
    float mu_t_rad;
    float mu_b_rad;
    float rho_rad;
};

// Second moments of the facets of a lobe, up to the factor 1/(2 ln2): in deg^2, so that a lobe of 1 degree has 1.
// Lobes that share a pixel add by these (mip levels).
struct LobeMoments {
    float xx;
    float xy;
    float yy;
};

// A stored lobe brought into the range that the model evaluates. Nothing that a map can hold leads to NaN or
// infinity behind this function.
//
// | stored value | result |
// |--------------|--------|
// | ln_mu_deg below ln 0.001 or above ln 80, infinite | the nearer end |
// | ln_mu_deg NaN | 0, that is 1 degree |
// | (e1, e2) longer than ln 10 (aspect 100:1) | shortened to ln 10 in the same direction |
// | (e1, e2) NaN, infinite, or longer than 1e15 | (0, 0), isotropic |
TG_FN Lobe sanitise_lobe(Lobe lobe) {
    Lobe valid;
    // Each chain of comparisons ends in the branch that NaN takes.
    valid.ln_mu_deg = lobe.ln_mu_deg >= TG_MIN_LN_MU_DEG ? min(lobe.ln_mu_deg, TG_MAX_LN_MU_DEG)
                      : lobe.ln_mu_deg < TG_MIN_LN_MU_DEG ? TG_MIN_LN_MU_DEG
                                                          : float(0.0);
    float r2 = lobe.e1 * lobe.e1 + lobe.e2 * lobe.e2;
    float shorten = r2 > TG_MAX_E * TG_MAX_E ? TG_MAX_E / sqrt(r2) : float(1.0);
    bool usable = r2 < float(1.0e30);
    valid.e1 = usable ? lobe.e1 * shorten : float(0.0);
    valid.e2 = usable ? lobe.e2 * shorten : float(0.0);
    return valid;
}

// A half width in the range 0.001 to 80 degrees; zero and negative give the lower end, NaN 1 degree.
TG_FN float sanitise_mu_rad(float mu_rad) {
    float lowest = float(0.001) * TG_RAD_PER_DEG;
    return mu_rad >= lowest ? min(mu_rad, float(80.0) * TG_RAD_PER_DEG)
           : mu_rad < lowest ? lowest
                             : TG_RAD_PER_DEG;
}

// mu_t < mu_b is the same lobe with its wide axis at rho + 90 degrees. rho NaN or infinite: isotropic.
TG_FN Lobe lobe_from_mu(float mu_t_rad, float mu_b_rad, float rho_rad) {
    Lobe lobe;
    float ln_t = log(sanitise_mu_rad(mu_t_rad));
    float ln_b = log(sanitise_mu_rad(mu_b_rad));
    float r = float(0.5) * (ln_t - ln_b);
    lobe.ln_mu_deg = float(0.5) * (ln_t + ln_b) - TG_LN_RAD_PER_DEG;
    lobe.e1 = r * cos(float(2.0) * rho_rad);
    lobe.e2 = r * sin(float(2.0) * rho_rad);
    return sanitise_lobe(lobe);
}

// The inverse: mu_t >= mu_b, rho in [0, pi), 0 where the lobe is isotropic.
TG_FN LobeAxes lobe_axes(Lobe stored) {
    Lobe lobe = sanitise_lobe(stored);
    LobeAxes axes;
    float r = sqrt(lobe.e1 * lobe.e1 + lobe.e2 * lobe.e2);
    axes.mu_t_rad = exp(lobe.ln_mu_deg + TG_LN_RAD_PER_DEG + r);
    axes.mu_b_rad = exp(lobe.ln_mu_deg + TG_LN_RAD_PER_DEG - r);
    float rho = r > float(0.0) ? float(0.5) * atan(lobe.e2, lobe.e1) : float(0.0);
    rho = rho < float(0.0) ? rho + TG_PI : rho;
    axes.rho_rad = rho < TG_PI ? rho : float(0.0);
    return axes;
}

// cosh(2r) and sinh(2r)/r of the shape: all that the quadratic form needs of it.
struct LobeShape {
    float cosh_2r;
    float sinh_2r_over_r;
};

TG_FN LobeShape lobe_shape(float e1, float e2) {
    LobeShape shape;
    float r2 = e1 * e1 + e2 * e2;
    float r = sqrt(r2);
    float up = exp(r + r);
    float down = float(1.0) / up;
    shape.cosh_2r = float(0.5) * (up + down);
    // Below r = 0.03 the series, whose next term is 4e-9 of the first.
    shape.sinh_2r_over_r =
        r > float(0.03) ? float(0.5) * (up - down) / r
                        : float(2.0) + r2 * (float(4.0) / float(3.0) + r2 * (float(4.0) / float(15.0)));
    return shape;
}

// xx and yy by what e1 leaves of r, without the difference of two near numbers that cosh(2r) - sinh(2r) e1/r is where
// the wide axis lies along T or B.
TG_FN LobeForm lobe_form(Lobe stored) {
    Lobe lobe = sanitise_lobe(stored);
    LobeShape shape = lobe_shape(lobe.e1, lobe.e2);
    float k = shape.sinh_2r_over_r;
    float r = sqrt(lobe.e1 * lobe.e1 + lobe.e2 * lobe.e2);
    float down = exp(float(-2.0) * r);
    float sum = r + abs(lobe.e1);
    float rest = sum > float(0.0) ? lobe.e2 * lobe.e2 / sum : float(0.0);
    float along = down + k * (lobe.e1 > float(0.0) ? rest : sum);
    float across = down + k * (lobe.e1 > float(0.0) ? sum : rest);
    LobeForm form;
    form.scale = TG_LN2 * exp(float(-2.0) * (lobe.ln_mu_deg + TG_LN_RAD_PER_DEG));
    form.xx = form.scale * along;
    form.yy = form.scale * across;
    form.xy = -form.scale * k * lobe.e2;
    return form;
}

// Moments of a lobe whose shape is known (it is often the same over a whole map).
TG_FN LobeMoments lobe_moments(Lobe valid, LobeShape shape) {
    LobeMoments m;
    float mu2 = exp(float(2.0) * valid.ln_mu_deg);
    float k = shape.sinh_2r_over_r;
    m.xx = mu2 * (shape.cosh_2r + k * valid.e1);
    m.yy = mu2 * (shape.cosh_2r - k * valid.e1);
    m.xy = mu2 * k * valid.e2;
    return m;
}

// The one lobe that has these moments. Moments narrower than the aspect 100:1 (or negative by rounding) are taken
// as that aspect; where xx + yy is not positive, an isotropic lobe of 1 degree.
TG_FN Lobe lobe_from_moments(LobeMoments moments) {
    bool usable = moments.xx + moments.yy > float(0.0);
    float xx = usable ? moments.xx : float(1.0);
    float yy = usable ? moments.yy : float(1.0);
    float xy = usable ? moments.xy : float(0.0);
    float mean = float(0.5) * (xx + yy);
    float d = float(0.5) * (xx - yy);
    float q = sqrt(d * d + xy * xy);
    float wide = mean + q;
    // mu_b^2 = det/mu_t^2, not mean - q: the difference of two near numbers is the determinant's only.
    float narrow = max((xx * yy - xy * xy) / wide, wide * float(1.0e-4));
    float ln_wide = log(wide);
    float ln_narrow = log(narrow);
    float r_over_q = q > float(0.0) ? float(0.25) * (ln_wide - ln_narrow) / q : float(0.0);
    Lobe lobe;
    lobe.ln_mu_deg = float(0.25) * (ln_wide + ln_narrow);
    lobe.e1 = d * r_over_q;
    lobe.e2 = xy * r_over_q;
    return lobe;
}

// What remains where no anisotropy is in the scene.
TG_FN LobeForm lobe_form_isotropic(float ln_mu_deg) {
    Lobe lobe;
    lobe.ln_mu_deg = ln_mu_deg;
    lobe.e1 = float(0.0);
    lobe.e2 = float(0.0);
    LobeForm form;
    form.scale = TG_LN2 * exp(float(-2.0) * (sanitise_lobe(lobe).ln_mu_deg + TG_LN_RAD_PER_DEG));
    form.xx = form.scale;
    form.yy = form.scale;
    form.xy = float(0.0);
    return form;
}

// D in [0, 1]. The form as a sum of squares (its determinant is scale^2), so that the large terms of an oblique narrow
// lobe meet before they are squared. Error in float: 1e-6 + 3e-7 mu_t/mu_b of the value, in the range where it is above 1e-4.
TG_FN float lobe_value(LobeForm form, Facet facet) {
    float along = form.xx * facet.dx + form.xy * facet.dy;
    float across = form.scale * facet.dy;
    return exp(-(along * along + across * across) / form.xx);
}

// Weight that keeps the reflected energy when the roughness changes: ln2/(4 pi mu_t mu_b).
TG_FN float lobe_normalised_weight(LobeForm form) {
    return form.scale / (float(4.0) * TG_PI);
}
