// A rectangle that emits evenly, by slices of the lobe (lobe_slices.glsl).

struct RectangleSlices {
    LobePencil pencil;
    SliceRange range;
    // Planes of the four edges through the shaded point, the light on the positive side: u and v at +, at -.
    vec3 edge_0;
    vec3 edge_1;
    vec3 edge_2;
    vec3 edge_3;
    float scale;  // makes the slices' Gaussian weights add up to their integral
};

TG_FN float slice_angle(LobePencil p, vec3 direction) {
    vec3 sum = direction + p.view;
    return atan(dot(sum, p.outward) / max(dot(sum, p.normal), float(1.0e-6)));
}

TG_FN vec3 unit_or_zero(vec3 a) {
    float n2 = dot(a, a);
    return n2 > float(1.0e-30) ? a * (float(1.0) / sqrt(n2)) : vec3(float(0.0), float(0.0), float(0.0));
}

// ends, widened by what a side of the light takes of alpha as far as the lobe reaches along it: the line p + s axis, s in
// [lo, hi]. limit: where the slices end on that side if this part of it is below the horizon.
TG_FN vec2 widen_by_side(LobePencil pencil, vec2 ends, float limit, vec3 p, vec3 axis, float lo, float hi) {
    float height = dot(pencil.normal, p);
    float rise = dot(pencil.normal, axis);
    float cut = abs(rise) > float(1.0e-12) ? -height / rise : float(0.0);
    bool below_lo = height + rise * lo <= float(0.0);
    bool below_hi = height + rise * hi <= float(0.0);
    if (below_lo && below_hi) {
        return vec2(min(ends.x, limit), max(ends.y, limit));
    }
    float first = below_lo ? cut : lo;
    float last = below_hi ? cut : hi;
    float x = slice_angle(pencil, unit_or_zero(p + axis * first));
    float y = slice_angle(pencil, unit_or_zero(p + axis * last));
    float m = slice_angle(pencil, unit_or_zero(p + axis * (float(0.5) * (first + last))));
    // The side is a curve there: its bulge by a parabola.
    float bend = x + y - float(2.0) * m;
    float turn = float(0.25) * (x - y) / (abs(bend) > float(1.0e-9) ? bend : float(1.0e-9));
    float top = abs(turn) < float(0.5) ? m - float(0.5) * bend * turn * turn : m;
    return vec2(min(ends.x, min(min(x, y), top)), max(ends.y, max(max(x, y), top)));
}

// D < 1e-6: what happens at this half vector changes nothing.
TG_FN bool beyond_lobe(LobePencil p, vec3 h) {
    return pencil_exponent(p, dot(h, p.outward), dot(h, p.along), dot(h, p.normal)) > float(14.0);
}

// The horizon may close the light: where it meets the line from a to b.
TG_FN vec2 widen_by_crossing(LobePencil pencil, vec2 ends, vec3 a, vec3 b) {
    float ha = dot(pencil.normal, a);
    float hb = dot(pencil.normal, b);
    if (ha * hb >= float(0.0)) {
        return ends;
    }
    vec3 h = unit_or_zero(unit_or_zero(a + (b - a) * (ha / (ha - hb))) + pencil.view);
    if (beyond_lobe(pencil, h)) {
        return ends;
    }
    float x = atan(dot(h, pencil.outward) / max(dot(h, pencil.normal), float(1.0e-6)));
    return vec2(min(ends.x, x), max(ends.y, x));
}

// Is the point in which the horizon touches its last slice (upper: towards growing alpha) inside the light?
TG_FN bool touches_horizon(RectangleSlices r, bool upper) {
    // There H lies at t of the slice where N.L has its double root: L is on the horizon, its P component -V.P.
    float v_out = dot(r.pencil.view, r.pencil.outward);
    float v_normal = max(dot(r.pencil.view, r.pencil.normal), TG_MIN_COS);
    float tangent = (v_out + (upper ? float(1.0) : float(-1.0))) / v_normal;
    float c = float(1.0) / sqrt(float(1.0) + tangent * tangent);
    vec3 h = r.pencil.outward * (tangent * c) + r.pencil.normal * c;
    float vh = dot(r.pencil.view, h);
    float va = dot(r.pencil.view, r.pencil.along);
    // N.L(y) = 0: c0 + 2 c1 y + c2 y^2 at y = -c1/c2, with c1 = va N.h and c2 = -V.N.
    float y = va * c / v_normal;
    vec3 direction = h * (float(2.0) * vh) - r.pencil.view + (r.pencil.along * vh + h * va) * (float(2.0) * y) +
                     (r.pencil.along * (float(2.0) * va) - r.pencil.view) * (y * y);
    vec3 touched = unit_or_zero(h + r.pencil.along * y);
    return !beyond_lobe(r.pencil, touched) && dot(r.edge_0, direction) > float(0.0) && dot(r.edge_1, direction) > float(0.0) &&
           dot(r.edge_2, direction) > float(0.0) && dot(r.edge_3, direction) > float(0.0);
}

// How far slices are worth taking, in alpha, to one side: the light is a strip of the lobe's plane, z = a o + b i with b in [b_lo, b_hi],
// and a grows with alpha where the result's sign says so. o, i: of unit length; correlation: their cosine.
TG_FN float strip_reach(float correlation, float b_lo, float b_hi, float reach) {
    float rest = sqrt(max(float(1.0) - correlation * correlation, float(1.0e-8)));
    // The b at which a reaches furthest while a^2 + 2 correlation a b + b^2 <= reach^2.
    float b = clamp(-correlation * reach / rest, b_lo, b_hi);
    return -correlation * b + sqrt(max(reach * reach - b * b * rest * rest, float(0.0)));
}

// The slice at alpha without what the light leaves dark.
TG_FN SliceCut rectangle_cut(RectangleSlices r, float alpha) {
    SliceCut s = slice_at(r.pencil, alpha);
    s = cut_plane(s, r.pencil.normal);
    s = cut_plane(s, r.edge_0);
    s = cut_plane(s, r.edge_1);
    s = cut_plane(s, r.edge_2);
    return cut_plane(s, r.edge_3);
}

// An end of alpha, moved on in growing steps (step: 1 or -1; `probes` at most) while the slice beyond it is lit.
TG_FN float rectangle_end(RectangleSlices r, float end, float limit, float step, int probes) {
    float found = end;
    float beyond = float(0.1) * r.pencil.sigma;
    for (int i = 0; i < probes; i = i + 1) {
        float next = found + step * beyond;
        if ((limit - next) * step <= float(0.0) || slice_light(rectangle_cut(r, next)) < float(0.02)) {
            return i > 0 ? found + float(0.5) * step * beyond : found;
        }
        found = next;
        beyond = float(2.0) * beyond;
    }
    return probes > 0 ? limit : end;
}

TG_FN RectangleSlices rectangle_slices(FlatLight light, TangentFrame axes, vec3 view, LobeForm form, int count) {
    RectangleSlices r;
    FlatFootprint f = flat_footprint(light, axes, view, form);
    float length_u = sqrt(dot(f.z_u, f.z_u));
    float length_v = sqrt(dot(f.z_v, f.z_v));
    // Slices run along the side that is the shorter one in the lobe's measure.
    bool along_u = light.half_u * length_u < light.half_v * length_v;
    vec3 turn = along_u ? f.turn_u : f.turn_v;
    vec3 across = along_u ? f.turn_v : f.turn_u;
    r.pencil = lobe_pencil(axes, view, form, slice_pole(axes, f.half_vector, turn));
    float widths = slice_reach(count);
    vec2 reach = pencil_reach(r.pencil, widths);
    // Where the light is a strip narrower than the lobe, only its own part of the lobe counts.
    float length_i = max(along_u ? length_u : length_v, float(1.0e-12));
    float length_o = max(along_u ? length_v : length_u, float(1.0e-12));
    vec2 unit_i = (along_u ? f.z_u : f.z_v) * (float(1.0) / length_i);
    vec2 unit_o = (along_u ? f.z_v : f.z_u) * (float(1.0) / length_o);
    float correlation = dot(unit_i, unit_o);
    // z = z0 + (da) o + (db) i; written from the lobe's centre: a o + b i.
    float rest2 = max(float(1.0) - correlation * correlation, float(1.0e-6));
    float zo = dot(f.z, unit_o);
    float zi = dot(f.z, unit_i);
    float a0 = (zo - correlation * zi) / rest2;
    float b0 = (zi - correlation * zo) / rest2;
    float half_i = along_u ? light.half_u : light.half_v;
    float at_i = along_u ? f.u : f.v;
    float b_lo = b0 - (half_i + at_i) * length_i;
    float b_hi = b0 + (half_i - at_i) * length_i;
    float strip = float(1.06) * widths;
    float a_hi = strip_reach(correlation, b_lo, b_hi, strip);
    float a_lo = -strip_reach(correlation, -b_hi, -b_lo, strip);
    float ho = dot(f.half_vector, r.pencil.outward);
    float hn = dot(f.half_vector, r.pencil.normal);
    float alpha = atan(ho / max(hn, float(1.0e-6)));
    float per_a = (dot(across, r.pencil.outward) * hn - dot(across, r.pencil.normal) * ho) / (max(ho * ho + hn * hn, float(1.0e-12)) * length_o);
    float x = alpha + (a_lo - a0) * per_a;
    float y = alpha + (a_hi - a0) * per_a;
    float width = pencil_width(r.pencil, widths);
    vec2 open = vec2(max(-width, min(x, y)), min(width, max(x, y)));
    reach = vec2(max(reach.x, open.x), min(reach.y, open.y));
    vec3 du = light.u * light.half_u;
    vec3 dv = light.v * light.half_v;
    r.edge_0 = unit_or_zero(cross(light.v, light.centre + du));
    r.edge_1 = unit_or_zero(cross(light.centre + dv, light.u));
    r.edge_2 = unit_or_zero(cross(light.centre - du, light.v));
    r.edge_3 = unit_or_zero(cross(light.u, light.centre - dv));
    // The two sides along the slices, each as far as the lobe sees it.
    vec2 ends = vec2(float(2.0), float(-2.0));
    float half_o = along_u ? light.half_v : light.half_u;
    float at_o = along_u ? f.v : f.u;
    vec3 axis_i = along_u ? light.u : light.v;
    vec3 axis_o = along_u ? light.v : light.u;
    for (int side = 0; side < 2; side = side + 1) {
        float o = side == 0 ? -half_o : half_o;
        vec2 z = f.z + unit_o * (length_o * (o - at_o));
        float s = clamp(at_i - dot(z, unit_i) / length_i, -half_i, half_i);
        FlatFootprint g = flat_footprint_at(light, axes, view, form, along_u ? s : o, along_u ? o : s);
        vec2 g_i = along_u ? g.z_u : g.z_v;
        float inv_i = float(1.0) / sqrt(max(dot(g_i, g_i), float(1.0e-20)));
        s = clamp(s - dot(g.z, g_i) * inv_i * inv_i, -half_i, half_i);
        float span = (float(3.0) + float(15.0) * r.pencil.sigma) * inv_i;
        float limit = o * per_a > float(0.0) ? reach.y : reach.x;
        ends = widen_by_side(r.pencil, ends, limit, light.centre + axis_o * o, axis_i, max(s - span, -half_i), min(s + span, half_i));
    }
    vec3 lo_i = light.centre - axis_i * half_i;
    vec3 hi_i = light.centre + axis_i * half_i;
    ends = widen_by_crossing(r.pencil, ends, lo_i - axis_o * half_o, lo_i + axis_o * half_o);
    ends = widen_by_crossing(r.pencil, ends, hi_i - axis_o * half_o, hi_i + axis_o * half_o);
    ends.x = touches_horizon(r, false) ? min(ends.x, reach.x) : ends.x;
    ends.y = touches_horizon(r, true) ? max(ends.y, reach.y) : ends.y;
    // Its brightest point is in the light whatever its sides say.
    ends = vec2(min(ends.x, alpha), max(ends.y, alpha));
    // Where a bent light goes on beyond the ends that its sides gave: only one that is large from here and near the horizon.
    bool large = max(light.half_u, light.half_v) > float(0.2) * length(light.centre);
    bool low = dot(axes.normal, light.centre) < float(1.5) * (light.half_u + light.half_v);
    int probes = large && low ? 6 : 0;
    ends.x = rectangle_end(r, ends.x, reach.x, float(-1.0), probes);
    ends.y = rectangle_end(r, ends.y, reach.y, float(1.0), probes);
    if (flat_light_height(light) <= float(0.0)) {
        ends = vec2(float(0.0), float(0.0));
    }
    r.range = slice_range(ends, reach, float(1.0));
    float mean = alpha + (float(0.5) * (a_lo + a_hi) - a0) * per_a;
    r.scale = slice_range_scale(r.range, open, mean, float(0.5) * (a_hi - a_lo) * abs(per_a) / strip, count);
    return r;
}

TG_FN LightSlice rectangle_slice(RectangleSlices r, int count, int k) {
    vec2 slice = slice_place(r.range, count, k);
    return slice_nodes(r.pencil, rectangle_cut(r, slice.x), slice.y * r.scale);
}

TG_FN SliceParts rectangle_slice_fine(RectangleSlices r, int count, int k) {
    vec2 slice = slice_place(r.range, count, k);
    return slice_nodes_fine(r.pencil, rectangle_cut(r, slice.x), slice.y * r.scale);
}
