// The tangent frame of a shaded point: N, T made perpendicular to it, B = N x T.
// Where T is parallel to N, zero or NaN, T is a fixed direction perpendicular to N: the lobe's axes are
// then arbitrary but finite, and an isotropic lobe is not touched by it.

struct TangentFrame {
    vec3 normal;
    vec3 tangent;
    vec3 bitangent;
};

TG_FN TangentFrame tangent_frame(vec3 normal, vec3 tangent) {
    TangentFrame f;
    f.normal = normalize(normal);
    vec3 t = tangent - f.normal * dot(f.normal, tangent);
    float length2 = dot(t, t);
    // Written so that NaN takes the second branch.
    if (length2 > float(1.0e-12)) {
        f.tangent = t * (float(1.0) / sqrt(length2));
    } else {
        vec3 axis = abs(f.normal.x) < float(0.5) ? vec3(float(1.0), float(0.0), float(0.0))
                                                 : vec3(float(0.0), float(1.0), float(0.0));
        f.tangent = normalize(cross(axis, f.normal));
    }
    f.bitangent = cross(f.normal, f.tangent);
    return f;
}
