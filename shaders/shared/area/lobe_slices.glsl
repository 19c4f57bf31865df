// Light from a range of directions on the Gaussian lobe, exact in the lobe: the half vectors are cut into slices, and
// each slice into two points at which the caller evaluates what varies slowly (Fresnel, G, emission).
//
// Where is the light? In the space of half vectors H the lobe D is a Gaussian for any view, and L = 2(V.H)H - V gives
//
//     integral over directions of D f = integral over H of D f 4(V.H):
//
// neither 1/r^2 nor the light's own cosine is left; a light of even radiance enters by its outline only. Along a great
// circle H(y) = Hc + y A (y the tangent of the angle from Hc) an outline n.L = 0, a plane through the shaded point, is
//
//     2(V.h)(n.h) - (n.V)(h.h) = c0 + c1 y + c2 y^2,    h = Hc + y A:
//
// edges of polygons, the horizon, and with a constant beside it the rim of a sphere, all by a square root.
//
// Slices: great circles through the pole `along`, one for every angle alpha from N towards `outward`; the angle on the
// slice from its meeting with the (N, outward) plane is t. H = (sin alpha cos t, sin t, cos alpha cos t), of solid
// angle cos t dalpha dt. On a slice D is a Gaussian in t about its ridge, cut off by the outline: closed form. Over the
// slices, Gauss-Legendre quadrature between the ends of the outline.
//
// Use:    pencil = lobe_pencil(...); range = <light>_range(...); for each k of count: slice = <light>_slice(...)
//         radiance += weight * sum over both nodes of measure * F * shadowing_over_cos_r(...)
//
// Derived for this project.

struct LobePencil {
    vec3 normal;
    vec3 outward;
    vec3 along;
    vec3 view;
    // Exponent of D in d = (d.outward, d.along): oo do^2 + 2 oa do da + aa da^2.
    float oo;
    float oa;
    float aa;
    // Standard deviation of alpha under D, rad.
    float sigma;
};

// alpha = centre + half_width sin(theta), theta in [begin, end]: slices crowd where the outline closes like a circle.
struct SliceRange {
    float centre;
    float half_width;
    float begin;
    float end;
};

// What the caller needs of one direction.
struct LightNode {
    vec3 direction;  // L, unit
    float measure;   // sr: integral of D over the directions that this node stands for
    float n_dot_l;
    float n_dot_h;
    float v_dot_h;   // also L.H: the angle of F for the hamon
};

struct LightSlice {
    LightNode first;
    LightNode second;
};

// One slice: its great circle, and the part of it that is lit, in y.
struct SliceCut {
    vec3 ridge;      // Hc, unit: where D is largest on the slice
    vec3 along;      // A, unit, perpendicular to it: direction of growing t
    vec3 mirrored;   // 2(V.Hc)Hc - V
    vec3 turned;     // half of dL/dy at the ridge
    vec3 bent;       // L(y)(1 + y^2) = mirrored + 2 turned y + bent y^2
    float spread;    // standard deviation of D along the slice, rad
    float exponent;  // of D at the ridge
    float cos_across;  // cos t at the ridge
    float lo;
    float hi;
    float hole_lo;   // a stretch inside [lo, hi] that the outline leaves out; none where hole_hi <= hole_lo
    float hole_hi;
};

// Reach of the lobe in standard deviations: 5e-4 of its energy lies beyond on a line.
#define TG_SLICE_REACH float(3.5)

// How many standard deviations so many slices are spread over: Gauss-Hermite's nodes where they are few.
TG_FN float slice_reach(int count) {
    return count < 3 ? float(1.75) : count < 4 ? float(2.25) : count < 6 ? float(2.75) : count < 8 ? float(3.2) : TG_SLICE_REACH;
}

// Great circles through `along` (perpendicular to N, unit).
TG_FN LobePencil lobe_pencil(TangentFrame axes, vec3 view, LobeForm form, vec3 along) {
    LobePencil p;
    p.normal = axes.normal;
    p.along = along;
    p.outward = plain_cross(along, axes.normal);
    p.view = view;
    float ot = dot(p.outward, axes.tangent);
    float ob = dot(p.outward, axes.bitangent);
    // Cofactors of a turn: along = (-ob, ot) up to rounding. Whitened first, as lobe_value is.
    float inv = float(1.0) / sqrt(form.xx);
    float o1 = (form.xx * ot + form.xy * ob) * inv;
    float o2 = form.scale * ob * inv;
    float a1 = (form.xy * ot - form.xx * ob) * inv;
    float a2 = form.scale * ot * inv;
    p.oo = o1 * o1 + o2 * o2;
    p.oa = o1 * a1 + o2 * a2;
    p.aa = a1 * a1 + a2 * a2;
    p.sigma = sqrt(float(0.5) * p.aa) / form.scale;
    return p;
}

// phi/sin(phi) of cos(phi) in [0, 1].
TG_FN float arc_over_sine(float cosine) {
    float c = clamp(cosine, float(0.0), float(1.0));
    return float(2.0) * atan_over_x((float(1.0) - c) / (float(1.0) + c)) / (float(1.0) + c);
}

// The exponent of D at sin(alpha)cos(t) = out_part, sin(t) = along_part.
TG_FN float pencil_exponent(LobePencil p, float out_part, float along_part, float cosine) {
    float k = arc_over_sine(cosine);
    float o = k * out_part;
    float a = k * along_part;
    return p.oo * o * o + float(2.0) * p.oa * o * a + p.aa * a * a;
}

// How far the lobe reaches in alpha to either side of N.
TG_FN float pencil_width(LobePencil p, float widths) {
    return min(widths * p.sigma, float(1.5));
}

// Range of alpha in which light is above the horizon and D is not negligible.
TG_FN vec2 pencil_reach(LobePencil p, float widths) {
    float reach = pencil_width(p, widths);
    float v_out = dot(p.view, p.outward);
    float v_normal = max(dot(p.view, p.normal), TG_MIN_COS);
    float v_along = dot(p.view, p.along);
    // tan(alpha) of the two slices that touch the horizon, (v_out -+ 1)/v_normal, the nearer without a difference of near numbers.
    float rest = v_normal * v_normal + v_along * v_along;
    float below = v_out > float(0.0) ? rest / (v_normal * (v_out + float(1.0))) : (float(1.0) - v_out) / v_normal;
    float above = v_out > float(0.0) ? (v_out + float(1.0)) / v_normal : rest / (v_normal * (float(1.0) - v_out));
    return vec2(max(-reach, -atan(below)), min(reach, atan(above)));
}

// ends: of the outline, in alpha; reach: pencil_reach; stretch: 1 or more, how much wider an outline the slices are laid out for
// within those ends.
TG_FN SliceRange slice_range(vec2 ends, vec2 reach, float stretch) {
    SliceRange r;
    r.centre = float(0.5) * (ends.x + ends.y);
    r.half_width = max(float(0.5) * (ends.y - ends.x), float(0.0)) * stretch;
    float w = max(r.half_width, float(1.0e-12));
    float lo = clamp((max(ends.x, reach.x) - r.centre) / w, float(-1.0), float(1.0));
    float hi = clamp((min(ends.y, reach.y) - r.centre) / w, float(-1.0), float(1.0));
    r.begin = asin(lo);
    r.end = max(asin(hi), r.begin);
    return r;
}

// Slice k of count: alpha and the width that it stands for, rad.
TG_FN vec2 slice_place(SliceRange r, int count, int k) {
    vec2 node = gauss_node(count, k);
    float half_span = float(0.5) * (r.end - r.begin);
    if (count < 8) {
        // Too few to resolve the sine: evenly in alpha.
        float lo = sin(r.begin);
        float hi = sin(r.end);
        float at = float(0.5) * (lo + hi) + float(0.5) * (hi - lo) * node.x;
        return vec2(r.centre + r.half_width * at, r.half_width * float(0.5) * (hi - lo) * node.y);
    }
    float theta = float(0.5) * (r.begin + r.end) + half_span * node.x;
    return vec2(r.centre + r.half_width * sin(theta), r.half_width * cos(theta) * half_span * node.y);
}

// What the widths are to be multiplied by, so that a Gaussian of alpha (mean, sigma) comes out exactly between the ends
// of the outline or at the horizon; ends at `open`, where only the slices end and not the light, count as infinite. From twelve
// slices on the quadrature needs no such help.
TG_FN float slice_range_scale(SliceRange r, vec2 open, float mean, float sigma, int count) {
    if (count > 8) {
        return float(1.0);
    }
    float sum = float(0.0);
    float inv = float(1.0) / max(sigma, float(1.0e-9));
    for (int k = 0; k < count; k = k + 1) {
        vec2 slice = slice_place(r, count, k);
        sum = sum + slice.y * inv * TG_INV_SQRT_TAU * normal_bump((slice.x - mean) * inv);
    }
    float lo = r.centre + r.half_width * sin(r.begin);
    float hi = r.centre + r.half_width * sin(r.end);
    float rounding = float(0.02) * sigma;
    float exact = normal_part(lo <= open.x + rounding ? float(-1.0e3) : (lo - mean) * inv,
                              hi >= open.y - rounding ? float(1.0e3) : (hi - mean) * inv).share;
    // Far from 1 it is the Gaussian that is wrong: a light that is bent in the lobe's measure.
    float least = count < 6 ? float(0.5) : float(0.9);
    return sum > float(1.0e-9) ? clamp(exact / sum, least, float(1.0) / least) : float(1.0);
}

// The slice at alpha, nothing cut off yet but where D is negligible.
TG_FN SliceCut slice_at(LobePencil p, float alpha) {
    SliceCut s;
    float sa = sin(alpha);
    float ca = cos(alpha);
    // Newton from the ridge of the plane's Gaussian to that of the sphere's.
    float t = -p.oa / p.aa * alpha;
    float st = float(0.0);
    float ct = float(1.0);
    float slope = float(0.0);
    for (int i = 0; i < 3; i = i + 1) {
        t = clamp(t, float(-1.2), float(1.2));
        st = sin(t);
        ct = cos(t);
        float c = ca * ct;
        float k = arc_over_sine(c);
        float s2 = float(1.0) - c * c;
        // d(phi/sin phi)/d(cos phi), its series below phi = 0.14.
        float dk = s2 > float(0.02) ? (c * k - float(1.0)) / s2
                                    : float(-1.0) / float(3.0) - s2 * (float(2.0) / float(15.0) + s2 * float(8.0) / float(105.0));
        float o = k * sa * ct;
        float a = k * st;
        float turn = -dk * ca * st;
        float o1 = turn * sa * ct - k * sa * st;
        float a1 = turn * st + k * ct;
        float q1 = p.oo * o * o1 + p.oa * (o * a1 + a * o1) + p.aa * a * a1;
        float q2 = p.oo * o1 * o1 + float(2.0) * p.oa * o1 * a1 + p.aa * a1 * a1;
        slope = q2;
        s.exponent = p.oo * o * o + float(2.0) * p.oa * o * a + p.aa * a * a;
        if (i < 2) {
            t = t - q1 / q2;
        }
    }
    s.cos_across = ct;
    s.spread = sqrt(float(0.5) / slope);
    s.ridge = p.outward * (sa * ct) + p.along * st + p.normal * (ca * ct);
    s.along = p.along * ct - p.outward * (sa * st) - p.normal * (ca * st);
    float vh = dot(p.view, s.ridge);
    float va = dot(p.view, s.along);
    s.mirrored = s.ridge * (float(2.0) * vh) - p.view;
    s.turned = s.along * vh + s.ridge * va;
    s.bent = s.along * (float(2.0) * va) - p.view;
    float reach = tan(min(TG_SLICE_REACH * float(1.3) * s.spread, float(1.4)));
    s.lo = -reach;
    s.hi = reach;
    s.hole_lo = float(0.0);
    s.hole_hi = float(0.0);
    return s;
}

// Keeps of the slice what has c0 + 2 c1 y + c2 y^2 >= 0.
TG_FN SliceCut cut_quadratic(SliceCut slice, float c0, float c1, float c2) {
    SliceCut s = slice;
    float disc = c1 * c1 - c0 * c2;
    if (disc <= float(0.0)) {
        // Never crosses: the sign of any point decides.
        s.hi = c0 < float(0.0) ? s.lo : s.hi;
        return s;
    }
    float q = c1 >= float(0.0) ? -(c1 + sqrt(disc)) : sqrt(disc) - c1;
    float near_root = c0 / q;
    float c2_safe = abs(c2) > float(1.0e-12) ? c2 : (c2 < float(0.0) ? float(-1.0e-12) : float(1.0e-12));
    float far_root = q / c2_safe;
    float r1 = min(near_root, far_root);
    float r2 = max(near_root, far_root);
    if (c2_safe < float(0.0)) {
        s.lo = max(s.lo, r1);
        s.hi = min(s.hi, r2);
    } else if (r1 <= s.lo) {
        s.lo = max(s.lo, r2);
    } else if (r2 >= s.hi) {
        s.hi = min(s.hi, r1);
    } else {
        s.hole_lo = r1;
        s.hole_hi = r2;
    }
    return s;
}

// Keeps what has n.L >= 0.
TG_FN SliceCut cut_plane(SliceCut slice, vec3 n) {
    return cut_quadratic(slice, dot(n, slice.mirrored), dot(n, slice.turned), dot(n, slice.bent));
}

// As cut_cone, for narrow cones, from the point of the slice that is nearest to the axis: seen from a ridge far away both ends of a
// narrow cone are one root to a float. Nothing is cut where the slice's whole circle of directions is about as narrow (found: false).
struct NarrowCut {
    SliceCut slice;
    bool found;
};

TG_FN NarrowCut cut_narrow_cone(SliceCut slice, vec3 axis, float sine_of_half, float cosine) {
    NarrowCut r;
    r.slice = slice;
    // L(t) = middle + first cos 2t + turned sin 2t.
    vec3 first = (slice.mirrored - slice.bent) * float(0.5);
    vec3 middle = (slice.mirrored + slice.bent) * float(0.5);
    float twice = atan(dot(axis, slice.turned), dot(axis, first));
    float c = cos(twice);
    float s = sin(twice);
    vec3 arm = first * c + slice.turned * s;
    vec3 turned = slice.turned * c - first * s;
    vec3 off = middle + arm - axis;
    float c0 = float(2.0) * sine_of_half * sine_of_half - float(0.5) * dot(off, off);
    float c1 = -dot(off, turned);
    float c2 = dot(axis, middle - arm) - cosine;
    r.found = c2 < float(-0.01);
    if (r.found) {
        float root = sqrt(max(c1 * c1 - c0 * c2, float(0.0)));
        float y = tan(float(0.5) * twice);
        float a = (root - c1) / c2;
        float b = (-root - c1) / c2;
        bool dark = c1 * c1 <= c0 * c2 || abs(twice) > float(2.8);
        r.slice.lo = dark ? slice.lo : max(slice.lo, (y + a) / max(float(1.0) - y * a, float(1.0e-3)));
        r.slice.hi = dark ? slice.lo : min(slice.hi, (y + b) / max(float(1.0) - y * b, float(1.0e-3)));
    }
    return r;
}

// Keeps what lies within the angle of a unit axis, of which the cosine and the sine of one half are given: by differences, for
// cosines of small angles are all 1 to a float.
TG_FN SliceCut cut_cone(SliceCut slice, vec3 axis, float sine_of_half, float cosine) {
    if (sine_of_half < float(0.02)) {
        NarrowCut narrow = cut_narrow_cone(slice, axis, sine_of_half, cosine);
        if (narrow.found) {
            return narrow.slice;
        }
    }
    vec3 off = slice.mirrored - axis;
    float c0 = float(2.0) * sine_of_half * sine_of_half - float(0.5) * dot(off, off);
    // dL/dy is perpendicular to L.
    return cut_quadratic(slice, c0, -dot(off, slice.turned), dot(axis, slice.bent) - cosine);
}

// The direction at angle tau from the ridge, and D there against the slice's own Gaussian (mean 0, slice.spread).
TG_FN LightNode slice_node(LobePencil p, SliceCut s, float tau, float weight) {
    LightNode node;
    float st = sin(tau);
    float ct = cos(tau);
    vec3 h = s.ridge * ct + s.along * st;
    node.v_dot_h = clamp(dot(p.view, h), float(0.0), float(1.0));
    node.n_dot_h = dot(p.normal, h);
    node.direction = h * (float(2.0) * node.v_dot_h) - p.view;
    node.n_dot_l = dot(p.normal, node.direction);
    float out_part = dot(p.outward, h);
    float along_part = dot(p.along, h);
    float x = tau / s.spread;
    float exponent = pencil_exponent(p, out_part, along_part, node.n_dot_h);
    // cos t = sqrt(1 - along_part^2).
    float cos_t = sqrt(max(float(1.0) - along_part * along_part, float(0.0)));
    float d = exp(min(float(0.5) * x * x - exponent, float(30.0)));
    bool lit = node.n_dot_l > TG_MIN_COS && node.n_dot_h > float(0.0);
    node.measure = lit ? weight * d * float(4.0) * node.v_dot_h * cos_t : float(0.0);
    return node;
}

// A hole that reaches an end is no hole.
TG_FN SliceCut close_hole(SliceCut cut) {
    SliceCut s = cut;
    bool hole = s.hole_hi > s.hole_lo;
    s.lo = hole && s.hole_lo <= s.lo ? max(s.lo, s.hole_hi) : s.lo;
    s.hi = hole && s.hole_hi >= s.hi ? min(s.hi, s.hole_lo) : s.hi;
    return s;
}

// D on the slice, relative to the lobe's best slice, times the share of it that is lit.
TG_FN float slice_light(SliceCut cut) {
    SliceCut s = close_hole(cut);
    float scale = float(1.0) / s.spread;
    float share = s.hi > s.lo ? normal_part(atan(s.lo) * scale, atan(s.hi) * scale).share : float(0.0);
    return share * exp(-min(s.exponent, float(30.0)));
}

// Two nodes for what is left of the slice; width: of the slice in alpha, rad.
TG_FN LightSlice slice_nodes(LobePencil p, SliceCut cut, float width) {
    SliceCut s = close_hole(cut);
    float scale = float(1.0) / s.spread;
    float x0 = atan(s.lo) * scale;
    float x1 = atan(s.hi) * scale;
    bool split = s.hole_hi > s.hole_lo && s.hole_lo > s.lo && s.hole_hi < s.hi;
    float full = width * s.spread / TG_INV_SQRT_TAU;
    LightSlice result;
    if (split) {
        // One node on each side.
        NormalPart before = normal_part(x0, atan(s.hole_lo) * scale);
        NormalPart after = normal_part(atan(s.hole_hi) * scale, x1);
        result.first = slice_node(p, s, before.mean * s.spread, full * before.share);
        result.second = slice_node(p, s, after.mean * s.spread, full * after.share);
    } else {
        NormalPart part = normal_part(x0, x1);
        float weight = float(0.5) * full * part.share;
        result.first = slice_node(p, s, (part.mean - part.spread) * s.spread, weight);
        result.second = slice_node(p, s, (part.mean + part.spread) * s.spread, weight);
    }
    return result;
}

// The lit part of a slice cut where G has its bends, two nodes for each part; parts may be empty, of measure 0.
struct SliceParts {
    LightSlice lower;
    LightSlice middle;
    LightSlice upper;
};

TG_FN LightSlice slice_part_nodes(LobePencil p, SliceCut s, float x0, float x1, float full) {
    NormalPart part = normal_part(x0, x1);
    float weight = float(0.5) * full * part.share;
    LightSlice result;
    result.first = slice_node(p, s, (part.mean - part.spread) * s.spread, weight);
    result.second = slice_node(p, s, (part.mean + part.spread) * s.spread, weight);
    return result;
}

// The y on the slice at which G leaves 1: 2 (N.H)(N.L) = V.H, that is (V.h)(4 (N.h)^2 - h.h) = 2 (N.h)(N.V)(h.h); by Newton's
// method from the given y. Anything may come out where there is none.
TG_FN float shadow_edge(LobePencil p, SliceCut s, float start) {
    float n0 = dot(p.normal, s.ridge);
    float n1 = dot(p.normal, s.along);
    float v0 = dot(p.view, s.ridge);
    float v1 = dot(p.view, s.along);
    float nv = dot(p.normal, p.view);
    float y = start;
    for (int i = 0; i < 4; i = i + 1) {
        float n = n0 + n1 * y;
        float v = v0 + v1 * y;
        float h2 = float(1.0) + y * y;
        float g = v * (float(4.0) * n * n - h2) - float(2.0) * n * nv * h2;
        float slope = v1 * (float(4.0) * n * n - h2) + v * (float(8.0) * n * n1 - float(2.0) * y) -
                      float(2.0) * nv * (n1 * h2 + float(2.0) * n * y);
        y = abs(slope) > float(1.0e-6) ? clamp(y - g / slope, float(-10.0), float(10.0)) : float(10.0);
    }
    return y;
}

// The y at which G's other two terms meet, 2 (N.H)(N.V) = V.H: the light grazes less than the view there.
TG_FN float masking_edge(LobePencil p, SliceCut s) {
    vec3 w = p.normal * (float(2.0) * dot(p.normal, p.view)) - p.view;
    float slope = dot(w, s.along);
    return abs(slope) > float(1.0e-6) ? clamp(-dot(w, s.ridge) / slope, float(-10.0), float(10.0)) : float(10.0);
}

// As slice_nodes, with up to three times the nodes: for the level of quality at which a picture rests.
TG_FN SliceParts slice_nodes_fine(LobePencil p, SliceCut cut, float width) {
    SliceCut s = close_hole(cut);
    float scale = float(1.0) / s.spread;
    float x0 = atan(s.lo) * scale;
    float x1 = max(atan(s.hi) * scale, x0);
    bool split = s.hole_hi > s.hole_lo && s.hole_lo > s.lo && s.hole_hi < s.hi;
    float full = width * s.spread / TG_INV_SQRT_TAU;
    NormalPart all = normal_part(x0, x1);
    float shadow = clamp(atan(shadow_edge(p, s, tan(all.mean * s.spread))) * scale, x0, x1);
    float mask = clamp(atan(masking_edge(p, s)) * scale, x0, x1);
    // Bends outside the lit part, or so far off that little light is beyond them, leave their cuts to its smooth rest.
    bool no_shadow = shadow <= x0 || shadow >= x1 || abs(shadow - all.mean) > float(2.6) * all.spread;
    bool no_mask = mask <= x0 || mask >= x1;
    // The masking's bend is a slight one: from far off its cut serves the light between.
    mask = clamp(mask, all.mean - float(1.5) * all.spread, all.mean + float(1.5) * all.spread);
    shadow = no_shadow ? all.mean + (no_mask ? float(0.55) * all.spread : float(0.0)) : shadow;
    mask = no_mask ? all.mean - (no_shadow ? float(0.55) * all.spread : float(0.0)) : mask;
    float first = clamp(min(shadow, mask), x0, x1);
    float second = clamp(max(shadow, mask), x0, x1);
    SliceParts result;
    if (split) {
        float lo = atan(s.hole_lo) * scale;
        float hi = atan(s.hole_hi) * scale;
        result.lower = slice_part_nodes(p, s, x0, lo, full);
        result.middle = slice_part_nodes(p, s, hi, hi, full);
        result.upper = slice_part_nodes(p, s, hi, x1, full);
    } else {
        result.lower = slice_part_nodes(p, s, x0, first, full);
        result.middle = slice_part_nodes(p, s, first, second, full);
        result.upper = slice_part_nodes(p, s, second, x1, full);
    }
    return result;
}
