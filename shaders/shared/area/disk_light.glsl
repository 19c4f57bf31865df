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
    vec3 u = vec3(dot(r.cone_u, s.mirrored), dot(r.cone_u, s.turned), dot(r.cone_u, s.bent));
    vec3 v = vec3(dot(r.cone_v, s.mirrored), dot(r.cone_v, s.turned), dot(r.cone_v, s.bent));
    vec3 n = vec3(dot(r.cone_n, s.mirrored), dot(r.cone_n, s.turned), dot(r.cone_n, s.bent));
    // Deepest inside: from where the slice comes nearest to the centre, or from the lobe's ridge.
    float c0 = dot(r.axis, s.mirrored);
    float c1 = dot(r.axis, s.turned);
    float c2 = dot(r.axis, s.bent);
    float y = clamp(tan(float(0.5) * atan(float(2.0) * c1, c0 - c2)), s.lo, s.hi);
    vec3 f = disk_depth(u, v, n, y);
    vec3 at_ridge = disk_depth(u, v, n, float(0.0));
    if (f.x < float(0.0) && at_ridge.x > f.x) {
        y = float(0.0);
        f = at_ridge;
    }
    for (int i = 0; i < 4; i = i + 1) {
        float next = clamp(f.z < float(0.0) ? y - f.y / f.z : y, s.lo, s.hi);
        vec3 g = disk_depth(u, v, n, next);
        y = g.x > f.x ? next : y;
        f = g.x > f.x ? g : f;
    }
    if (f.x < float(0.0)) {
        s.hi = s.lo;
        return s;
    }
    float half_chord = f.z < float(0.0) ? sqrt(float(-2.0) * f.x / f.z) : s.hi - s.lo;
    float lo = disk_rim(u, v, n, y, s.lo, y - half_chord);
    float hi = disk_rim(u, v, n, y, s.hi, y + half_chord);
    s.lo = lo;
    s.hi = hi;
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

// An end of alpha, moved on in growing steps (step: 1 or -1) while the slice beyond it is lit.
TG_FN float disk_end(DiskSlices r, float end, float limit, float step, float least) {
    float found = end;
    float beyond = float(0.1) * r.pencil.sigma;
    for (int i = 0; i < 6; i = i + 1) {
        float next = found + step * beyond;
        if ((limit - next) * step <= float(0.0) || slice_light(disk_slice_cut(r, next)) < least) {
            return i > 0 ? found + float(0.5) * step * beyond : found;
        }
        found = next;
        beyond = float(2.0) * beyond;
    }
    return limit;
}

TG_FN DiskSlices disk_finish(DiskSlices slices, vec2 ends, int count) {
    DiskSlices r = slices;
    float widths = slice_reach(count);
    vec2 reach = pencil_reach(r.pencil, widths);
    vec2 all = vec2(min(min(ends.x, ends.y), r.brightest), max(max(ends.x, ends.y), r.brightest));
    // Against the slice of the brightest point: a light beside the lobe has only its tail.
    float least = max(float(0.005) * slice_light(disk_slice_cut(r, r.brightest)), float(1.0e-6));
    all.x = disk_end(r, all.x, reach.x, float(-1.0), least);
    all.y = disk_end(r, all.y, reach.y, float(1.0), least);
    r.range = slice_range(all, reach);
    r.scale = slice_range_scale(r.range, reach, float(0.0), r.pencil.sigma, count);
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
            float slope = (an * c + ao * s) / sqrt(float(1.0) - ap * ap) + (vn * c + vo * s) / sqrt(float(1.0) - vp * vp);
            float miss = asin(ap) + asin(vp) + sign * wide;
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
