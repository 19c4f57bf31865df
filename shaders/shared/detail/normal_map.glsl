// A normal map's texel on a surface: the bent normal, and how the finer texels that it stands for are spread about it.
//
// | quantity    | meaning |
// |-------------|---------|
// | lean        | (nx, ny)/nz of the map's normal: the normal leans towards +u and +v of the map |
// | sd          | standard deviation of the lean over the area of the texel, along u and v |
// | correlation | of the two, -1 to 1; outside it is clamped |
//
// Leans average as slopes do: the mean lean of an area is the lean of its mean surface, and lobes add by the leans' covariance.

struct NormalTexel {
    vec2 lean;
    vec2 sd;
    float correlation;
};

// spread_a a^T + spread_b b^T is the covariance of the normals about `normal`, rad^2, for lobe_form_widened with a share of 1: the part of a
// and b in the plane perpendicular to `normal` counts.
struct BentNormal {
    vec3 normal;
    vec3 spread_a;
    vec3 spread_b;
};

// along_u, along_v: unit, perpendicular to `geometric`; the map's axes on the surface.
TG_FN BentNormal bent_normal(vec3 geometric, vec3 along_u, vec3 along_v, NormalTexel texel) {
    BentNormal bent;
    vec3 leaning = geometric + along_u * texel.lean.x + along_v * texel.lean.y;
    // At least 1 long. What is longer turns less for the same change of the lean.
    float inv_length = float(1.0) / sqrt(dot(leaning, leaning));
    bent.normal = leaning * inv_length;
    float r = clamp(texel.correlation, float(-1.0), float(1.0));
    // Cholesky's root of the covariance.
    bent.spread_a = (along_u * texel.sd.x + along_v * (texel.sd.y * r)) * inv_length;
    bent.spread_b = along_v * (texel.sd.y * sqrt(float(1.0) - r * r) * inv_length);
    return bent;
}

// A bent normal whose mirror direction would run into the surface, turned back towards the surface's own normal until it leaves it:
// so far that the mirrored ray stands 0.01 (or 0.9 of the viewer's own height, if that is less) over it. What is seen from so low is the
// slope's upper edge, not its dark foot, and a normal that faces away from the viewer would be a black dot. No turn where none is
// needed. The result faces the viewer wherever the surface does. All unit; where the surface faces away, its own normal.
TG_FN vec3 normal_mirroring_outwards(vec3 bent, vec3 geometric, vec3 view) {
    float c = dot(geometric, view);
    float along = dot(bent, geometric);
    if (!(c > float(0.0))) {
        return geometric;
    }
    float limit = min(float(0.9) * c, float(0.01));
    if (along > float(0.0) && float(2.0) * dot(bent, view) * along - c >= limit) {
        return bent;
    }
    // In the plane of the two normals, N = cos(a) geometric + sin(a) side: the mirrored ray stands r cos(2 a - b) high.
    vec3 side = bent - geometric * along;
    float sine = sqrt(dot(side, side));
    if (!(sine > float(1.0e-6))) {
        return geometric;
    }
    side = side * (float(1.0) / sine);
    float x = dot(side, view);
    float r = sqrt(c * c + x * x);
    float a = float(0.5) * (atan(x, c) + acos(clamp(limit / r, float(-1.0), float(1.0))));
    return geometric * cos(a) + side * sin(a);
}
