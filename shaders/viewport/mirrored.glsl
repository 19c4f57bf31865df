// Other things in the blade's mirror: the nearest one along a ray, lit by all lamps as a matt surface of its colour.
// A blade in another blade is dark. Behind areas.glsl, whose lobes and nodes it shares.

struct MirroredThing {
    bool found;
    vec3 place;
    vec3 normal; // unit, towards where the ray came from
    vec3 albedo;
};

MirroredThing mirrored_thing(int mask, vec3 start, vec3 direction) {
    TreeHit best;
    best.distance = TG_FAR;
    best.triangle = -1;
    best.at_b = 0.0;
    best.at_c = 0.0;
    int which = 0;
    int rest = mask;
    for (int c = 0; rest != 0; ++c) {
        int times = rest - 2 * (rest / 2);
        for (int once = 0; once < times; ++once) {
            TreeHit hit = caster_hit(casters.caster[c], start, direction, best.distance, false);
            which = hit.triangle >= 0 ? c : which;
            if (hit.triangle >= 0) {
                best = hit;
            }
        }
        rest = rest / 2;
    }
    MirroredThing thing;
    thing.found = best.triangle >= 0;
    thing.place = start + direction * best.distance;
    thing.normal = -direction;
    thing.albedo = vec3(0.0);
    if (thing.found) {
        TgCaster caster = casters.caster[which];
        vec3 own = tree_normal(best);
        // Normals go from the tree to the viewer by the transposed matrix of the way there.
        vec3 normal = caster.row_x.xyz * own.x + caster.row_y.xyz * own.y + caster.row_z.xyz * own.z;
        normal = unit_or_zero(normal);
        thing.normal = dot(normal, direction) > 0.0 ? -normal : normal;
        int colours = int(casters.count.z);
        thing.albedo = casters.colour[min(int(caster.shown.z) + tree_group(best), colours - 1)].xyz;
    }
    return thing;
}

vec3 row_rgb(int row, LightNode node, AreaLobe q) {
    return table_rgb(row, q.at_theta_i ? node.n_dot_l : node.v_dot_h);
}

// What the facet of the node reflects of the thing. number: of the ray among the pixel's.
vec3 mirrored_light(MirroredThing thing, LightNode node, AreaLobe q, int number) {
    vec3 sum = vec3(0.0);
    vec3 start = above_surface(thing.place, thing.normal);
#if defined(TG_POINTS) || defined(TG_SPOTS) || defined(TG_SUNS)
    int points = int(frame.counts.x);
    int spots_end = points + int(frame.counts.y);
    int all = spots_end + int(frame.counts.z);
    for (int i = 0; i < all; ++i) {
        Towards t = towards_point(i, thing.place);
        if (i >= spots_end) {
            t = towards_sun(i);
        }
        float cosine = dot(thing.normal, t.direction);
        if (cosine > 0.0) {
            vec3 colour = sun_colour(i);
            if (i < points) {
                colour = point_colour(i, t);
            }
#ifdef TG_SPOTS
            if (i >= points && i < spots_end) {
                colour = spot_colour(i, i - points, t);
            }
#endif
#ifdef TG_SHADOWS
            colour *= lamp_seen(i, t, start, -1);
#endif
            sum += colour * cosine * row_rgb(lamp_row(i), node, q);
        }
    }
#endif
#if defined(TG_RECTANGLES) || defined(TG_ROUNDS)
    int area_count = int(frame.view.y);
    for (int i = 0; i < area_count; ++i) {
        TgArea area = areas.area[i];
        AreaSeen seen = area_seen(area, thing.place);
        float irradiance = seen.radiance > 0.0 ? area_irradiance(area, seen, thing.normal) : 0.0;
        if (irradiance > 0.0) {
#ifdef TG_SHADOWS
            irradiance *= area_share_seen(area, area_seen_past(seen, area, start, -1), thing.normal, 1, float(number));
#endif
            vec3 colour = area.colour.xyz * irradiance;
#ifdef TG_PICTURES
            colour *= matt_picture(area, seen, thing.normal);
#endif
            sum += colour * row_rgb(int(area.colour.w), node, q);
        }
    }
#endif
    sum = sum / TG_PI;
#ifdef TG_ENVIRONMENT
    sum += environment_matt(thing.normal) * frame.world.xyz * row_rgb(int(frame.world.w), node, q);
#endif
#ifdef TG_WORLD
    sum += frame.world.xyz * row_rgb(int(frame.world.w), node, q);
#endif
    return sum * thing.albedo * shadowed_node(node, q);
}
