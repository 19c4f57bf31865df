// A ray against a surface that lies as a tree of boxes in a row of texels (cpp_core/mesh/ray_tree.hpp). Who includes this says
// what TG_TREE_TEXEL(i) is, texel i as vec4. Nodes lie in the order in which a search visits them, each with the number of
// the node that follows where its box is missed: no stack.
//   node      low.xyz, next after a miss; high.xyz, leaf: 0, or 1 + 8 (first triangle) + (its triangles - 1)
//   triangle  corner a, group; b - a, 0; c - a, 0; packed normals of a, b, c, 0

struct TreePlace {
    int nodes;      // texel of the first node
    int node_count;
    int triangles;  // texel of the first triangle
};

struct TreeHit {
    float distance; // in lengths of the ray's direction
    int triangle;   // texel of it; -1: nothing is hit
    float at_b;     // barycentric
    float at_c;
};

// Where a slab test would divide by zero it divides by almost nothing: boxes have some thickness (ray_tree.cpp).
TG_FN float ray_inverse(float x) {
    float least = float(1.0e-18);
    return float(1.0) / (abs(x) > least ? x : (x < float(0.0) ? -least : least));
}

TG_FN bool ray_meets_box(vec3 low, vec3 high, vec3 origin, vec3 inverse, float reach) {
    vec3 a = (low - origin) * inverse;
    vec3 b = (high - origin) * inverse;
    float enters = max(max(min(a.x, b.x), min(a.y, b.y)), max(min(a.z, b.z), float(0.0)));
    float leaves = min(min(max(a.x, b.x), max(a.y, b.y)), min(max(a.z, b.z), reach));
    return enters <= leaves;
}

// Moeller and Trumbore 1997, from both sides.
TG_FN TreeHit ray_meets_triangle(TreeHit so_far, int texel, vec3 origin, vec3 direction) {
    vec4 corner = TG_TREE_TEXEL(texel);
    vec4 side_b = TG_TREE_TEXEL(texel + 1);
    vec4 side_c = TG_TREE_TEXEL(texel + 2);
    vec3 e1 = vec3(side_b.x, side_b.y, side_b.z);
    vec3 e2 = vec3(side_c.x, side_c.y, side_c.z);
    vec3 p = cross(direction, e2);
    float det = dot(e1, p);
    TreeHit hit = so_far;
    if (abs(det) > float(1.0e-30)) {
        float inv = float(1.0) / det;
        vec3 from = origin - vec3(corner.x, corner.y, corner.z);
        float b = dot(from, p) * inv;
        vec3 q = cross(from, e1);
        float c = dot(direction, q) * inv;
        float along = dot(e2, q) * inv;
        if (b >= float(0.0) && c >= float(0.0) && b + c <= float(1.0) && along > float(0.0) && along < so_far.distance) {
            hit.distance = along;
            hit.triangle = texel;
            hit.at_b = b;
            hit.at_c = c;
        }
    }
    return hit;
}

// The first thing that the ray meets within `reach`, or with first_will_do whatever it meets.
TG_FN TreeHit ray_meets_tree(TreePlace place, vec3 origin, vec3 direction, float reach, bool first_will_do) {
    TreeHit hit;
    hit.distance = reach;
    hit.triangle = -1;
    hit.at_b = float(0.0);
    hit.at_c = float(0.0);
    vec3 inverse = vec3(ray_inverse(direction.x), ray_inverse(direction.y), ray_inverse(direction.z));
    int node = 0;
    while (node < place.node_count) {
        vec4 low = TG_TREE_TEXEL(place.nodes + 2 * node);
        vec4 high = TG_TREE_TEXEL(place.nodes + 2 * node + 1);
        bool met = ray_meets_box(vec3(low.x, low.y, low.z), vec3(high.x, high.y, high.z), origin, inverse, hit.distance);
        int leaf = met ? int(high.w) : 0;
        int first = (leaf - 1) / 8;
        int count = leaf > 0 ? leaf - 8 * first : 0;
        for (int i = 0; i < count; i = i + 1) {
            hit = ray_meets_triangle(hit, place.triangles + 4 * (first + i), origin, direction);
        }
        node = met ? node + 1 : int(low.w);
        node = first_will_do && hit.triangle >= 0 ? place.node_count : node;
    }
    return hit;
}

// A unit vector as an octahedron unfolded (Meyer et al. 2010), 12 bits to an axis, in a number that a float holds exactly.
TG_FN vec3 unpack_unit(float code) {
    float row = floor(code / float(4096.0));
    float x = (code - row * float(4096.0)) / float(4095.0) * float(2.0) - float(1.0);
    float y = row / float(4095.0) * float(2.0) - float(1.0);
    float z = float(1.0) - abs(x) - abs(y);
    float under = max(-z, float(0.0));
    vec3 n = vec3(x + (x >= float(0.0) ? -under : under), y + (y >= float(0.0) ? -under : under), z);
    return n * (float(1.0) / sqrt(dot(n, n)));
}

// The surface's smooth normal at a hit, in the tree's own space; not of unit length.
TG_FN vec3 tree_normal(TreeHit hit) {
    vec4 codes = TG_TREE_TEXEL(hit.triangle + 3);
    return unpack_unit(codes.x) * (float(1.0) - hit.at_b - hit.at_c) + unpack_unit(codes.y) * hit.at_b +
           unpack_unit(codes.z) * hit.at_c;
}

TG_FN int tree_group(TreeHit hit) {
    return int(TG_TREE_TEXEL(hit.triangle).w);
}
