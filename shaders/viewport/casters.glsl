// What stands before a lamp or in the mirror: rays from a pixel's point against the scene's other surfaces.
#define TG_TREE_TEXEL(i) texelFetch(trees, ivec2((i) % TG_TREE_WIDTH, (i) / TG_TREE_WIDTH), 0)
#include "shared/trace/ray_tree.glsl"

#define TG_FAR 1.0e30
// A ray ends this much before its lamp, whose own shape may be there as a mesh.
#define TG_BEFORE_LAMP 0.9999

vec3 way_in_tree(TgCaster caster, vec3 direction) {
    return vec3(dot(caster.row_x.xyz, direction), dot(caster.row_y.xyz, direction), dot(caster.row_z.xyz, direction));
}

TreeHit caster_hit(TgCaster caster, vec3 start, vec3 direction, float reach, bool first_will_do) {
    TreePlace tree;
    tree.nodes = int(caster.tree.x);
    tree.node_count = int(caster.tree.y);
    tree.triangles = int(caster.tree.z);
    vec3 from = way_in_tree(caster, start) + vec3(caster.row_x.w, caster.row_y.w, caster.row_z.w);
    return ray_meets_tree(tree, from, way_in_tree(caster, direction), reach, first_will_do);
}

// The casters that rays from `start` within wide_rad of `axis` and shorter than `reach` may meet, a bit for each. own: the blade that
// the rays leave, or -1: a blade is convex, and its rounded normals would let its own facets hide the light. kind: TgCaster.shown.
int casters_towards(vec3 start, vec3 axis, float wide_rad, float reach, int own, vec3 kind) {
    int mask = 0;
    int count = int(casters.count.x);
    for (int c = 0; c < count; ++c) {
        TgCaster caster = casters.caster[c];
        vec3 to_middle = caster.ball.xyz - start;
        float away = length(to_middle);
        float radius = caster.ball.w;
        // 1e-3: graphics cards know asin to 1e-4 only.
        float angle = min(wide_rad + asin(min(radius / max(away, 1.0e-30), 1.0)) + 1.0e-3, TG_PI);
        bool met = away <= radius || (dot(to_middle, axis) >= away * cos(angle) && away - radius < reach);
        met = met && int(caster.tree.w) != own && dot(caster.shown.xyz, kind) > 0.5;
        mask += met ? 1 << c : 0;
    }
    return mask;
}

#define TG_CASTS vec3(1.0, 0.0, 0.0)
#define TG_SHOWS vec3(0.0, 1.0, 0.0)

bool ray_blocked(int mask, vec3 start, vec3 direction, float reach) {
    bool met = false;
    int rest = mask;
    for (int c = 0; rest != 0 && !met; ++c) {
        int times = rest - 2 * (rest / 2);
        for (int once = 0; once < times; ++once) {
            met = caster_hit(casters.caster[c], start, direction, reach, true).triangle >= 0;
        }
        rest = rest / 2;
    }
    return met;
}

// A matt surface's rays begin this much above it: its place is known to a rounding of its distance from the viewer.
vec3 above_surface(vec3 place, vec3 normal) {
    return place + normal * (2.0e-5 * (abs(place.x) + abs(place.y) + abs(place.z)) + casters.count.y);
}

#ifdef TG_SHADOWS
// 1 where lamp `index`, of no size, is seen along t from `start`, else 0.
float lamp_seen(int index, Towards t, vec3 start, int own) {
    float reach = t.nearness > 0.0 ? TG_BEFORE_LAMP / t.nearness : TG_FAR;
    int mask = lights.light[index].place.w > 0.5 ? casters_towards(start, t.direction, 0.0, reach, own, TG_CASTS) : 0;
    return ray_blocked(mask, start, t.direction, reach) ? 0.0 : 1.0;
}
#endif
