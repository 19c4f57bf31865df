// The tangent frame of a shaded point: N, T made perpendicular to it, B = N x T, each of unit length.
//
// | input | result |
// |-------|--------|
// | T not perpendicular to N, any length 1e-15 to 1e15 | T without its part along N (perpendicular to 1e-6) |
// | T within 0.006 degrees of N or of -N, zero, NaN or infinite | a fixed direction perpendicular to N: the lobe's axes are then arbitrary but finite; an isotropic lobe is not touched |
// | N zero, NaN or infinite | N = B = 0 and T a unit vector: every cosine to N is 0, so nothing is reflected |

struct TangentFrame {
    vec3 normal;
    vec3 tangent;
    vec3 bitangent;
};

TG_FN TangentFrame tangent_frame(vec3 normal, vec3 tangent) {
    TangentFrame f;
    // Both conditions are written so that NaN takes the second branch.
    float n2 = dot(normal, normal);
    if (n2 > float(1.0e-30) && n2 < float(1.0e30)) {
        f.normal = normal * (float(1.0) / sqrt(n2));
    } else {
        f.normal = vec3(float(0.0), float(0.0), float(0.0));
    }
    float t2 = dot(tangent, tangent);
    vec3 t = tangent - f.normal * dot(f.normal, tangent);
    float length2 = dot(t, t);
    if (length2 > float(1.0e-8) * t2 && t2 > float(1.0e-30) && t2 < float(1.0e30)) {
        t = t * (float(1.0) / sqrt(length2));
        // Once more: where T was nearly parallel to N, rounding left 1e-3 of N in t, and a lobe of
        // 0.1 degrees would see it. The length changes by less than rounding.
        f.tangent = t - f.normal * dot(f.normal, t);
    } else {
        vec3 axis = abs(f.normal.x) < float(0.5) ? vec3(float(1.0), float(0.0), float(0.0))
                                                 : vec3(float(0.0), float(1.0), float(0.0));
        // axis and N are never parallel, and axis x N is perpendicular to N = 0 too; only its length is not 1.
        vec3 c = axis - f.normal * dot(f.normal, axis);
        f.tangent = c * (float(1.0) / sqrt(dot(c, c)));
    }
    f.bitangent = cross(f.normal, f.tangent);
    return f;
}

// A unit normal as two numbers, by stereographic projection: exact to the last bits of a float, and back to a unit
// vector without a square root. Within 0.26 degrees of -z, where only the custom normals of a face seen from behind
// point, one direction 0.11 degrees from -z stands for all: it, too, reflects nothing to the viewer.
TG_FN vec2 fold_normal(vec3 normal) {
    bool away = normal.z < float(-0.99999);
    float s = float(1.0) / max(float(1.0) + normal.z, float(1.0e-6));
    return away ? vec2(float(1.0e3), float(0.0)) : vec2(normal.x * s, normal.y * s);
}

TG_FN vec3 unfold_normal(vec2 folded) {
    // To the same bits in every program that reads the pixel.
    TG_PRECISE float d = float(1.0) + folded.x * folded.x + folded.y * folded.y;
    TG_PRECISE float s = float(2.0) / d;
    TG_PRECISE vec3 normal = vec3(folded.x * s, folded.y * s, s - float(1.0));
    return normal;
}

// Two directions perpendicular to a normal of which z > -1, smooth over all of them, so that a tangent can be kept
// as its angle from the first one. Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6/1, 2017.
TG_FN TangentFrame smooth_frame(vec3 normal) {
    TangentFrame f;
    float a = float(1.0) / max(float(1.0) + normal.z, float(1.0e-6));
    float b = -normal.x * normal.y * a;
    f.normal = normal;
    f.tangent = vec3(float(1.0) - normal.x * normal.x * a, b, -normal.x);
    f.bitangent = vec3(b, float(1.0) - normal.y * normal.y * a, -normal.y);
    return f;
}
