// Torrance-Sparrow's shadowing and masking over cos(theta_r), as one expression:
//   G/cos(theta_r) = min(1, 2 (N.H)(N.V)/(V.H), 2 (N.H)(N.L)/(V.H)) / (N.V)
// which stays finite at grazing view, where G and cos(theta_r) vanish together.
// All cosines in (0, 1]; the caller has refused light and view below TG_MIN_COS, so the result is at most
// 1/TG_MIN_COS = 1e4.
// Source: Torrance & Sparrow 1967; Cook & Torrance 1982, eq. for G.

TG_FN float shadowing_over_cos_r(float n_dot_h, float n_dot_v, float n_dot_l, float v_dot_h) {
    float two_h = float(2.0) * n_dot_h / max(v_dot_h, float(1.0e-7));
    return min(min(float(1.0) / n_dot_v, two_h), two_h * n_dot_l / n_dot_v);
}
