// The lobe as a pixel sees it: the mean of D over the facets that the pixel's normals sweep. It widens the lobe and lowers its
// peak by the same factor, so that a highlight narrower than a pixel keeps its energy whatever its position in the pixel is.
//
// Facets in rad (struct Facet, lobe.glsl); a turn is the change of the facet from one edge of the pixel to the other: of the
// half vector in the pixel's own tangent frame, from derivatives of the position and the normal, or from geometry.
//
// | function             | pixel's normals                           | cost |
// |----------------------|-------------------------------------------|------|
// | lobe_form_widened    | any covariance: a Gaussian of it          | no exp; the lobe of normal-map mips and of far distances |
// | lobe_value_box       | a strip or a parallelogram of two turns   | 2 exp a node; exact for one turn |
// | lobe_value_ridge     | two planes and the rounded edge between   | 4 exp |
//
// Errors against 4096 samples a pixel: docs/light.md. Sources: Kaplanyan, Hill, Patney, Lefohn 2016; Tokuyoshi, Kaplanyan 2019 (the Gaussian);
// the box and the ridge were derived for this project.

// The facet in standard deviations of D, D = exp(-z.z/2).
TG_FN vec2 facet_whitened(LobeForm form, Facet facet) {
    float k = sqrt(float(2.0) / form.xx);
    return vec2(k * (form.xx * facet.dx + form.xy * facet.dy), k * form.scale * facet.dy);
}

// The Gaussian that is wider by `share` times x x^T + y y^T: 1/12 is a pixel's own variance, 1/4 hides the pixel's edges.
// lobe_value of the result times lobe_normalised_weight of the result keeps the energy; where the weight is a measured
// constant, multiply it by result.scale/form.scale.
TG_FN LobeForm lobe_form_widened(LobeForm form, Facet x, Facet y, float share) {
    vec2 a = facet_whitened(form, x);
    vec2 b = facet_whitened(form, y);
    // I + C in the whitened plane, its inverse, and back.
    float cxx = float(1.0) + share * (a.x * a.x + b.x * b.x);
    float cyy = float(1.0) + share * (a.y * a.y + b.y * b.y);
    float cxy = share * (a.x * a.y + b.x * b.y);
    // det(I + C) = 1 + tr C + det C, of which the last is a square: no difference of large numbers.
    float cross_ab = share * (a.x * b.y - a.y * b.x);
    float det = float(1.0) + share * (dot(a, a) + dot(b, b)) + cross_ab * cross_ab;
    float inv = float(1.0) / det;
    float k = float(1.0) / sqrt(form.xx);
    float p = form.xx * k;
    float q = form.xy * k;
    float r = form.scale * k;
    LobeForm wide;
    wide.xx = p * p * cyy * inv;
    wide.xy = (p * q * cyy - p * r * cxy) * inv;
    wide.yy = (q * q * cyy - float(2.0) * q * r * cxy + r * r * cxx) * inv;
    wide.scale = form.scale * sqrt(inv);
    return wide;
}

// Mean of exp(-|z + t i|^2/2) over t in [-1/2, 1/2], widened by a Gaussian of covariance o o^T/12.
TG_FN float filtered_box(vec2 z, vec2 i, vec2 o) {
    float o2 = dot(o, o);
    float inv_o = float(1.0) / (float(12.0) + o2);
    float det = float(12.0) * inv_o;
    float io = dot(i, o);
    float zo = dot(z, o);
    float a = dot(i, i) - io * io * inv_o;
    float b = dot(i, z) - io * zo * inv_o;
    float q = dot(z, z) - zo * zo * inv_o;
    if (a < float(1.0e-4)) {
        return sqrt(det) * normal_bump(sqrt(max(q, float(0.0))));
    }
    // q - b^2/a without the difference of near numbers.
    float across = i.x * z.y - i.y * z.x;
    float rest = det * across * across / a;
    float root = sqrt(a);
    float middle = b / root;
    float share = normal_part(middle - float(0.5) * root, middle + float(0.5) * root).share;
    return sqrt(det) * normal_bump(sqrt(rest)) * share / (TG_INV_SQRT_TAU * root);
}

// Mean of D over the parallelogram facet + s x + t y, |s|, |t| <= 1/2: exact along the longer turn; across it in `nodes` Gaussians
// (1 where the surface is curved one way, 4 where both ways and the lobe is narrow).
TG_FN float lobe_value_box(LobeForm form, Facet facet, Facet x, Facet y, int nodes) {
    vec2 z = facet_whitened(form, facet);
    vec2 a = facet_whitened(form, x);
    vec2 b = facet_whitened(form, y);
    bool x_longer = dot(a, a) >= dot(b, b);
    vec2 i = x_longer ? a : b;
    vec2 o = x_longer ? b : a;
    float share = float(1.0) / float(nodes);
    float sum = float(0.0);
    for (int k = 0; k < nodes; k = k + 1) {
        float at = (float(k) + float(0.5)) * share - float(0.5);
        sum = sum + filtered_box(z + o * at, i, o * share);
    }
    return sum * share;
}

// Mean of D over a pixel [-1/2, 1/2] across a rounded edge: one plane up to `begin`, the rounding, whose facet turns evenly, from begin to
// end, then the other plane; in pixels, end > begin. from, to: the facets of the two planes. An edge far narrower than a
// pixel has end - begin near 0: its light is then (end - begin) times the mean over its facets, as it should be.
TG_FN float lobe_value_ridge(LobeForm form, Facet from, Facet to, float begin, float end) {
    float first = clamp(begin, float(-0.5), float(0.5));
    float last = clamp(end, float(-0.5), float(0.5));
    float span = max(end - begin, float(1.0e-9));
    vec2 z0 = facet_whitened(form, from);
    vec2 z1 = facet_whitened(form, to);
    vec2 turn = z1 - z0;
    float s0 = (first - begin) / span;
    float s1 = (last - begin) / span;
    vec2 none = vec2(float(0.0), float(0.0));
    float rounding = last > first ? filtered_box(z0 + turn * (float(0.5) * (s0 + s1)), turn * (s1 - s0), none) : float(0.0);
    float before = normal_bump(sqrt(dot(z0, z0)));
    float after = normal_bump(sqrt(dot(z1, z1)));
    return (first + float(0.5)) * before + (last - first) * rounding + (float(0.5) - last) * after;
}
