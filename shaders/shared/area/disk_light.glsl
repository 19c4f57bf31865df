// Lights with a round outline, by slices of the lobe (lobe_slices.glsl): the disk and the ellipse, flat; the sphere and the
// sun, which are round cones of directions.

struct DiskSlices {
    LobePencil pencil;
    SliceRange range;
    float scale;
    float brightest; // alpha of the point of the light where the lobe is strongest
    vec3 axis;      // towards the centre, unit
    float cosine;   // round cones: of the half angle; flat lights: 2
    float sine_of_half;  // round cones: sin(angle/2)
    // Flat lights: a direction L meets the disk where (L.u)^2 + (L.v)^2 <= (L.n)^2.
    vec3 cone_u;
    vec3 cone_v;
    vec3 cone_n;
};

// d(alpha) along u and v at a point of the plane of a flat light.
TG_FN vec3 slice_angle_gradient(LobePencil p, FlatFootprint f) {
    float o = dot(f.half_vector, p.outward);
    float n = dot(f.half_vector, p.normal);
    float inv = float(1.0) / max(o * o + n * n, float(1.0e-12));
    float gu = (dot(f.turn_u, p.outward) * n - dot(f.turn_u, p.normal) * o) * inv;
    float gv = (dot(f.turn_v, p.outward) * n - dot(f.turn_v, p.normal) * o) * inv;
    return vec3(atan(o / max(n, float(1.0e-6))), gu, gv);
}

// Slices across the rim where the lobe is nearest to it: they meet it steeply, and its curvature is left to the sum over slices.
// light: half_u, half_v of the ellipse that has these directions.
TG_FN DiskSlices disk_layout(FlatLight light, TangentFrame axes, vec3 view, LobeForm form) {
    vec3 mirror = axes.normal * (float(2.0) * dot(axes.normal, view)) - view;
    float height = flat_light_height(light);
    float towards = -dot(mirror, cross(light.u, light.v));
    float reach = length(light.centre);
    float s = towards * float(8.0) * reach > height ? height / towards : reach;
    vec3 hit = mirror * s - light.centre;
    float u = dot(hit, light.u) / light.half_u;
    float v = dot(hit, light.v) / light.half_v;
    float shrink = float(1.0) / max(sqrt(u * u + v * v), float(1.0));
    u = u * shrink * light.half_u;
    v = v * shrink * light.half_v;
    FlatFootprint f = flat_footprint_at(light, axes, view, form, u, v);
    // The outline in the lobe's measure: centre + a cos + b sin.
    vec2 a = f.z_u * light.half_u;
    vec2 b = f.z_v * light.half_v;
    vec2 centre = f.z - f.z_u * u - f.z_v * v;
    // (E E^T) of it, and its inverse's product with the way from the centre to the lobe: across the rim there.
    float xx = a.x * a.x + b.x * b.x;
    float xy = a.x * a.y + b.x * b.y;
    float yy = a.y * a.y + b.y * b.y;
    float det = max(xx * yy - xy * xy, float(1.0e-12) * (xx + yy) * (xx + yy));
    vec2 rim = vec2(yy * centre.x - xy * centre.y, xx * centre.y - xy * centre.x);
    // The short axis, for a lobe at the centre.
    float half_difference = float(0.5) * (xx - yy);
    float root = sqrt(half_difference * half_difference + xy * xy);
    vec2 shorter = half_difference > float(0.0) ? vec2(-xy, half_difference + root) : vec2(root - half_difference, -xy);
    shorter = dot(shorter, shorter) > float(1.0e-20) * (xx + yy) * (xx + yy) ? shorter : vec2(float(1.0), float(0.0));
    // Distance of the lobe from the centre in radii of the outline, squared.
    float away = dot(rim, centre) / det;
    vec2 normal = away > float(0.2) ? rim : shorter;
    // Back to a turn of H.
    float c_u = normal.x * f.z_v.y - normal.y * f.z_v.x;
    float c_v = f.z_u.x * normal.y - f.z_u.y * normal.x;
    float inv = float(1.0) / max(max(abs(c_u), abs(c_v)), float(1.0e-30));
    vec3 turn = f.turn_u * (c_u * inv) + f.turn_v * (c_v * inv);
    DiskSlices r;
    r.pencil = lobe_pencil(axes, view, form, slice_pole(axes, f.half_vector, turn));
    r.brightest = slice_angle_gradient(r.pencil, f).x;
    return r;
}

// (L.n)^2 - (L.u)^2 - (L.v)^2 along the slice and its first two derivatives, up to the factor (1 + y^2)^2.
TG_FN vec3 disk_inside(vec3 u, vec3 v, vec3 n, float y) {
    float lu = u.x + y * (float(2.0) * u.y + y * u.z);
    float lv = v.x + y * (float(2.0) * v.y + y * v.z);
    float ln = n.x + y * (float(2.0) * n.y + y * n.z);
    float du = float(2.0) * (u.y + y * u.z);
    float dv = float(2.0) * (v.y + y * v.z);
    float dn = float(2.0) * (n.y + y * n.z);
    return vec3(ln * ln - lu * lu - lv * lv, float(2.0) * (ln * dn - lu * du - lv * dv),
                float(2.0) * (dn * dn - du * du - dv * dv) + float(4.0) * (ln * n.z - lu * u.z - lv * v.z));
}

// Of the double cone only the half with the light: cone_n points away from it. Negative where the slice is outside.
TG_FN vec3 disk_depth(vec3 u, vec3 v, vec3 n, float y) {
    vec3 f = disk_inside(u, v, n, y);
    bool ahead = n.x + y * (float(2.0) * n.y + y * n.z) < float(0.0);
    return ahead ? f : vec3(-abs(f.x), float(0.0), float(0.0));
}

// The rim between a point inside and the slice's end, by Newton's method that may not leave what it has bracketed.
TG_FN float disk_rim(vec3 u, vec3 v, vec3 n, float inside, float end, float guess) {
    float a = inside;
    float b = end;
    vec3 at_end = disk_depth(u, v, n, b);
    if (at_end.x >= float(0.0)) {
        return end;
    }
    float y = guess;
    for (int i = 0; i < 8; i = i + 1) {
        // What has converged may step out by rounding.
        float slack = float(0.001) * abs(b - a);
        float kept = clamp(y, min(a, b), max(a, b));
        y = abs(kept - y) <= slack ? kept : float(0.5) * (a + b);
        vec3 f = disk_depth(u, v, n, y);
        a = f.x >= float(0.0) ? y : a;
        b = f.x >= float(0.0) ? b : y;
        y = abs(f.y) > float(1.0e-30) ? y - f.x / f.y : float(0.5) * (a + b);
    }
    return clamp(y, min(a, b), max(a, b));
}

TG_FN SliceCut cut_disk(SliceCut slice, DiskSlices r) {
    SliceCut s = slice;
    // cone_u and cone_v are perpendicular to the axis: from there, for to a float all directions of a small light are the same.
    vec3 off = s.mirrored - r.axis;
    vec3 u = vec3(dot(r.cone_u, off), dot(r.cone_u, s.turned), dot(r.cone_u, s.bent));
    vec3 v = vec3(dot(r.cone_v, off), dot(r.cone_v, s.turned), dot(r.cone_v, s.bent));
    vec3 n = vec3(dot(r.cone_n, s.mirrored), dot(r.cone_n, s.turned), dot(r.cone_n, s.bent));
    // Deepest inside: from where the slice comes nearest to the centre, or from the lobe's ridge.
    float c0 = dot(r.axis, s.mirrored);
    float c1 = dot(r.axis, s.turned);
    float c2 = dot(r.axis, s.bent);
    float y = clamp(tan(float(0.5) * atan(float(2.0) * c1, c0 - c2)), s.lo, s.hi);
    float at_ridge = disk_depth(u, v, n, float(0.0)).x;
    float at_centre = disk_depth(u, v, n, y).x;
    y = at_centre < float(0.0) && at_ridge > at_centre ? float(0.0) : y;
    vec3 f = vec3(float(-1.0), float(0.0), float(0.0));
    for (int attempt = 0; attempt < 2 && f.x < float(0.0); attempt = attempt + 1) {
        float best = float(-1.0e30);
        for (int k = 0; k < 12 * attempt; k = k + 1) {
            // A light seen from its edge is not deepest near its centre: from the best of some places along the slice.
            float place = s.lo + (s.hi - s.lo) * ((float(k) + float(0.5)) / float(12.0));
            float scale = float(1.0) / (float(1.0) + place * place);
            float depth = disk_depth(u, v, n, place).x * scale * scale;
            y = depth > best ? place : y;
            best = max(best, depth);
        }
        float next = y;
        f = vec3(float(-1.0e30), float(0.0), float(0.0));
        for (int i = 0; i < 5; i = i + 1) {
            vec3 g = disk_depth(u, v, n, next);
            y = g.x > f.x ? next : y;
            f = g.x > f.x ? g : f;
            next = clamp(f.z < float(0.0) ? y - f.y / f.z : y, s.lo, s.hi);
        }
    }
    if (f.x < float(0.0)) {
        s.hi = s.lo;
        return s;
    }
    float half_chord = f.z < float(0.0) ? sqrt(float(-2.0) * f.x / f.z) : s.hi - s.lo;
    vec2 rim = vec2(s.lo, s.hi);
    for (int side = 0; side < 2; side = side + 1) {
        float sign = side == 0 ? float(-1.0) : float(1.0);
        float found = disk_rim(u, v, n, y, side == 0 ? s.lo : s.hi, y + sign * half_chord);
        rim = side == 0 ? vec2(found, rim.y) : vec2(rim.x, found);
    }
    s.lo = rim.x;
    s.hi = rim.y;
    return s;
}

// The slice at alpha without what the light leaves dark.
TG_FN SliceCut disk_slice_cut(DiskSlices r, float alpha) {
    SliceCut s = slice_at(r.pencil, alpha);
    if (r.cosine > float(1.5)) {
        s = cut_disk(s, r);
    } else {
        s = cut_cone(s, r.axis, r.sine_of_half, r.cosine);
    }
    return cut_plane(s, r.pencil.normal);
}

// An end of alpha, moved on in growing steps (step: 1 or -1) while the slice beyond it is lit. With slices enough for it to count,
// an end that the light does not reach is brought back to it, and one that is found too near is moved on: the light's outline
// may close between two steps, or at the horizon. brightest: a lit slice. One loop, for programs hold every call in full.
TG_FN float disk_end(DiskSlices r, float end, float limit, float step, float brightest, float least, int count) {
    bool exact = count >= 8;
    float found = (limit - end) * step < float(0.0) ? limit : end;
    float beyond = float(0.1) * r.pencil.sigma;
    // What counts as having found it.
    float margin = step * min(float(0.5) * beyond, float(0.05) * abs(found - brightest));
    float faint = float(0.04) * least;
    float lit = brightest;
    float dark = found;
    // 0: just inside the end; 1: steps outwards; 2: just outside the last lit one; 3: halving between lit and dark.
    int phase = exact ? 0 : 1;
    int done = 0;
    for (int i = 0; i < 16; i = i + 1) {
        float next = found + step * beyond;
        if (phase == 1 && (limit - next) * step <= float(0.0)) {
            return done > 0 ? limit : end;
        }
        float place = phase == 0 ? found - margin : phase == 1 ? next : phase == 2 ? found + margin : float(0.5) * (lit + dark);
        float light = slice_light(disk_slice_cut(r, place));
        float between = done > 0 ? found + float(0.5) * step * beyond : found;
        if (phase == 0) {
            dark = place;
            phase = light < faint ? 3 : 1;
        } else if (phase == 1) {
            if (light >= least) {
                found = next;
                beyond = float(2.0) * beyond;
                done = done + 1;
                if (done == 6) {
                    return limit;
                }
            } else if (exact) {
                dark = next;
                phase = 2;
            } else {
                return between;
            }
        } else if (phase == 2) {
            if (light < least) {
                return between;
            }
            lit = place;
            phase = 3;
            done = 0;
        } else {
            lit = light >= faint ? place : lit;
            dark = light >= faint ? dark : place;
            done = done + 1;
            if (done == 6) {
                return dark;
            }
        }
    }
    return found;
}

TG_FN DiskSlices disk_finish(DiskSlices slices, vec2 ends, int count) {
    DiskSlices r = slices;
    float widths = slice_reach(count);
    vec2 reach = pencil_reach(r.pencil, widths);
    // The brightest point is found on the plane as if the lobe were there as it is at the mirror direction: far from it the lobe's
    // own slice may be the better one.
    float brightest = float(0.0);
    float light = float(-1.0);
    float candidate = clamp(r.brightest, reach.x, reach.y);
    int candidates = abs(candidate) > r.pencil.sigma ? 2 : 1;
    for (int i = 0; i < candidates; i = i + 1) {
        float found = slice_light(disk_slice_cut(r, candidate));
        brightest = found > light ? candidate : brightest;
        light = max(light, found);
        candidate = float(0.0);
    }
    // Against the slice of the brightest point: a light beside the lobe has only its tail.
    float least = max(float(0.005) * light, float(1.0e-6));
    vec2 all = vec2(min(min(ends.x, ends.y), brightest), max(max(ends.x, ends.y), brightest));
    for (int side = 0; side < 2; side = side + 1) {
        bool lower = side == 0;
        float end = disk_end(r, lower ? all.x : all.y, lower ? reach.x : reach.y, lower ? float(-1.0) : float(1.0), brightest, least, count);
        all = lower ? vec2(end, all.y) : vec2(all.x, end);
    }
    // Where the outline closes far out on the lobe there is little light at its ends: slices that crowd there are missed in the middle.
    float half_width = float(0.5) * (all.y - all.x) / r.pencil.sigma;
    r.range = slice_range(all, reach, float(1.0) + float(0.5) * max(half_width - float(1.7), float(0.0)));
    float width = pencil_width(r.pencil, widths);
    r.scale = slice_range_scale(r.range, vec2(-width, width), float(0.0), r.pencil.sigma, count);
    return r;
}

// The round cone of half angle `angle` about `axis`: a sphere of radius r at distance d has sin(angle) = r/d, a sun half of the angle
// that it is seen under. angle below TG_MIN_HALF_ANGLE is widened to it (cosine says what is used); at most 1.5.
TG_FN DiskSlices cone_slices(vec3 axis, float angle, TangentFrame axes, vec3 view, LobeForm form, int count) {
    float wide = clamp(angle, TG_MIN_HALF_ANGLE, float(1.5));
    vec3 some = abs(axis.x) < float(0.6) ? vec3(float(1.0), float(0.0), float(0.0)) : vec3(float(0.0), float(1.0), float(0.0));
    TangentFrame around = tangent_frame(axis * float(-1.0), some);
    FlatLight flat_part;
    flat_part.centre = axis;
    flat_part.u = around.tangent;
    flat_part.v = around.bitangent;
    flat_part.half_u = tan(min(wide, float(1.4)));
    flat_part.half_v = flat_part.half_u;
    DiskSlices r = disk_layout(flat_part, axes, view, form);
    r.axis = axis;
    r.cosine = cos(wide);
    r.sine_of_half = sin(float(0.5) * wide);
    r.cone_u = around.tangent;
    r.cone_v = around.bitangent;
    r.cone_n = axis;
    // Slices that touch the rim: asin(axis.P) + asin(V.P) = -+angle for the slice's own normal P.
    float ao = dot(axis, r.pencil.outward);
    float an = dot(axis, r.pencil.normal);
    float vo = dot(view, r.pencil.outward);
    float vn = dot(view, r.pencil.normal);
    vec2 ends = vec2(float(0.0), float(0.0));
    for (int side = 0; side < 2; side = side + 1) {
        float sign = side == 0 ? float(-1.0) : float(1.0);
        float alpha = atan((ao + vo) / max(an + vn, float(1.0e-4)));
        for (int i = 0; i < 5; i = i + 1) {
            float c = cos(alpha);
            float s = sin(alpha);
            float ap = clamp(ao * c - an * s, float(-0.9999), float(0.9999));
            float vp = clamp(vo * c - vn * s, float(-0.9999), float(0.9999));
            float ac = sqrt(float(1.0) - ap * ap);
            float vc = sqrt(float(1.0) - vp * vp);
            float slope = (an * c + ao * s) / ac + (vn * c + vo * s) / vc;
            // asin(ap) + asin(vp), of near opposite numbers where the light is small: by their sum, and without asin, of which
            // graphics cards know 1e-4.
            float sum = (ao + vo) * c - (an + vn) * s;
            float sine = sum * (vc - vp * (ap - vp) / (ac + vc));
            float miss = atan(sine, ac * vc - ap * vp) + sign * wide;
            alpha = clamp(alpha + miss / max(slope, float(0.05)), float(-1.5), float(1.5));
        }
        ends = side == 0 ? vec2(alpha, ends.y) : vec2(ends.x, alpha);
    }
    return disk_finish(r, ends, count);
}

TG_FN DiskSlices ellipse_slices(FlatLight light, TangentFrame axes, vec3 view, LobeForm form, int count) {
    DiskSlices r = disk_layout(light, axes, view, form);
    vec3 n = cross(light.u, light.v);
    float cn = dot(light.centre, n);
    r.axis = unit_or_zero(light.centre);
    r.cosine = float(2.0);
    r.sine_of_half = float(0.0);
    r.cone_u = (light.u * cn - n * dot(light.centre, light.u)) * (float(1.0) / light.half_u);
    r.cone_v = (light.v * cn - n * dot(light.centre, light.v)) * (float(1.0) / light.half_v);
    r.cone_n = n;
    vec2 ends = vec2(float(0.0), float(0.0));
    for (int side = 0; side < 2; side = side + 1) {
        float sign = side == 0 ? float(-1.0) : float(1.0);
        float u = float(0.0);
        float v = float(0.0);
        for (int i = 0; i < 5; i = i + 1) {
            vec3 g = slice_angle_gradient(r.pencil, flat_footprint_at(light, axes, view, form, u, v));
            float gu = g.y * light.half_u;
            float gv = g.z * light.half_v;
            float inv = sign / max(sqrt(gu * gu + gv * gv), float(1.0e-20));
            u = gu * inv * light.half_u;
            v = gv * inv * light.half_v;
        }
        float alpha = slice_angle_gradient(r.pencil, flat_footprint_at(light, axes, view, form, u, v)).x;
        // An end below the horizon is not the end that counts.
        vec3 p = light.centre + light.u * u + light.v * v;
        alpha = dot(p, axes.normal) > float(0.0) ? alpha : sign * float(1.5);
        ends = side == 0 ? vec2(alpha, ends.y) : vec2(ends.x, alpha);
    }
    r = disk_finish(r, ends, count);
    r.scale = flat_light_height(light) > float(0.0) ? r.scale : float(0.0);
    return r;
}

TG_FN LightSlice disk_slice(DiskSlices r, int count, int k) {
    vec2 slice = slice_place(r.range, count, k);
    return slice_nodes(r.pencil, disk_slice_cut(r, slice.x), slice.y * r.scale);
}

TG_FN SliceParts disk_slice_fine(DiskSlices r, int count, int k) {
    vec2 slice = slice_place(r.range, count, k);
    return slice_nodes_fine(r.pencil, disk_slice_cut(r, slice.x), slice.y * r.scale);
}
