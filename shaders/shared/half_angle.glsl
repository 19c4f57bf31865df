// The half vector against the surface, to the last bits of a float: where a lobe of 0.2 degrees falls to 1e-4 of its
// peak, an error of 1e-7 rad in phi is already 1e-4 of the value. So H is never normalised. S = L + V is kept as the
// exact sum of two floats, and N x S, whose terms nearly cancel, is made of products that are exact in a float.
// Source: Knuth's TwoSum; the splitting after Dekker, on a fixed grid because the vectors' lengths are known.
//
// TG_PRECISE forbids the compiler to reorder. TG_PLAIN_HALF_ANGLE: the same without the lost parts, for doubles whose
// derivatives cost more than their last bits are worth (cpp_core/fit): an error of 1e-16 rad.

struct HalfAngle {
    vec3 across; // N x S: |S| sin(phi), perpendicular to N and to S
    float along; // N . S: |S| cos(phi)
    float size;  // |S| = 2 cos(theta_H)
};

// atan(x)/x from x^2 in [0, 1].
TG_FN float atan_over_x(float x2) {
#ifdef TG_DOUBLE
    float x = sqrt(x2);
    return x > float(0.0) ? atan(x) / x : float(1.0);
#else
    // Minimax, 2e-8 of the value; drivers' atan is 2e-5.
    float p = float(0.00292066001);
    p = p * x2 + float(-0.0163678014);
    p = p * x2 + float(0.0432116591);
    p = p * x2 + float(-0.0755219759);
    p = p * x2 + float(0.10665997);
    p = p * x2 + float(-0.142110534);
    p = p * x2 + float(0.199937726);
    p = p * x2 + float(-0.333331527);
    return p * x2 + float(1.0);
#endif
}

// The multiples of 1/4096 nearest to a vector of unit length: 12 bits.
TG_FN vec3 coarse_normal(vec3 normal) {
    TG_PRECISE vec3 shifted = normal + vec3(float(3072.0), float(3072.0), float(3072.0));
    TG_PRECISE vec3 coarse = shifted - vec3(float(3072.0), float(3072.0), float(3072.0));
    return coarse;
}

// The multiples of 1/1024 nearest to a sum of two such vectors: 12 bits again.
TG_FN vec3 coarse_sum(vec3 sum) {
    TG_PRECISE vec3 shifted = sum + vec3(float(12288.0), float(12288.0), float(12288.0));
    TG_PRECISE vec3 coarse = shifted - vec3(float(12288.0), float(12288.0), float(12288.0));
    return coarse;
}

// a x b in the order that is written. GLSL's own cross() may be merged with what stands around it.
TG_FN vec3 plain_cross(vec3 a, vec3 b) {
    TG_PRECISE vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}

TG_FN HalfAngle half_angle(vec3 normal, vec3 view, vec3 light) {
    TG_PRECISE vec3 sum = view + light;
#ifdef TG_PLAIN_HALF_ANGLE
    TG_PRECISE vec3 across = plain_cross(normal, sum);
#else
    TG_PRECISE vec3 light_part = sum - view;
    TG_PRECISE vec3 view_part = sum - light_part;
    TG_PRECISE vec3 view_lost = view - view_part;
    TG_PRECISE vec3 light_lost = light - light_part;
    vec3 coarse_n = coarse_normal(normal);
    vec3 coarse_s = coarse_sum(sum);
    TG_PRECISE vec3 fine_n = normal - coarse_n;
    TG_PRECISE vec3 fine_s = (sum - coarse_s) + (view_lost + light_lost);
    TG_PRECISE vec3 fine = plain_cross(normal, fine_s) + plain_cross(fine_n, coarse_s);
    TG_PRECISE vec3 across = plain_cross(coarse_n, coarse_s) + fine;
#endif
    HalfAngle half_vector;
    half_vector.across = across;
    half_vector.along = dot(normal, sum);
    half_vector.size = sqrt(dot(sum, sum));
    return half_vector;
}

// phi/|N x S|: turns N x S into phi times a unit vector, smoothly through phi = 0. By half of phi, whose tangent is
// |N x S|/(|S| + N.S); acos(N.H) is 18 % wrong in D at mu = 0.1 degrees in float. No lit point has phi beyond 90 degrees.
TG_FN float facet_stretch(HalfAngle half_vector) {
    float reach = max(half_vector.size + half_vector.along, float(1.0e-20));
    float tan2 = dot(half_vector.across, half_vector.across) / (reach * reach);
    return float(2.0) * atan_over_x(min(tan2, float(1.0))) / reach;
}

// Error in float: 3e-7 of the angle.
TG_FN Facet facet_of(HalfAngle half_vector, vec3 tangent, vec3 bitangent) {
    float stretch = facet_stretch(half_vector);
    Facet facet;
    facet.dx = dot(half_vector.across, bitangent) * stretch;
    facet.dy = -dot(half_vector.across, tangent) * stretch;
    return facet;
}

// What remains of it for lobes without a direction: phi alone.
TG_FN Facet facet_isotropic(HalfAngle half_vector) {
    Facet facet;
    facet.dx = length(half_vector.across) * facet_stretch(half_vector);
    facet.dy = float(0.0);
    return facet;
}
