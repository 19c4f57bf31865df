// Second half of polished steel: each pixel under any number of lamps.
//   TG_ONE_LOBE   no maps: a part has one lobe, smooth or rough   TG_MAPS  both lobes, w and h from maps
//   TG_HADORI     the map has hadori                              TG_SHAPE, TG_ANISOTROPIC  as named
//   TG_POINTS, TG_SPOTS, TG_SUNS, TG_WORLD                        what the scene has
//   TG_RECTANGLES, TG_ROUNDS, TG_FINE                             lamps of a size (areas.glsl)
//   TG_ENVIRONMENT                                                an HDRI (environment.glsl)
//   TG_SHADOWS    things may hide the lamps                      TG_MIRRORED  things near the blade are mirrored (mirrored.glsl)
//   TG_MANY       other steels are in the picture
//   TG_FILTERED   highlights are the mean over the pixel's facets, not the value at its centre
//   TG_NORMAL_MAP the lobes are wider by the texels of a normal map that a pixel covers
#include "shared/model.glsl"
#include "viewport/lights.glsl"
#include "viewport/casters.glsl"
#ifdef TG_PICTURES
#include "viewport/pictures.glsl"
#endif
#include "viewport/steel_pixel.glsl"
#ifdef TG_NORMAL_MAP
#include "viewport/spread.glsl"
#endif

#if defined(TG_ANISOTROPIC) || defined(TG_FILTERED) || defined(TG_NORMAL_MAP)
#define TG_LONG_LOBES
#endif

// Where a lobe's exponent is above this its value is below 1e-13 of its peak, and the lamp is skipped.
#define TG_DARK_EXPONENT 30.0

struct Steel {
    vec3 view;
    TangentFrame axes;
    LobeForm ji;
    LobeForm ha;
    LobeForm hadori;
    float w;
    float h;
    float chi;
    float beta_ha;
    float beta_hadori;
    float n_dot_v;
#if defined(TG_SHADOWS) || defined(TG_MIRRORED)
    vec3 place;
    int own;
#endif
#ifdef TG_FILTERED
    PixelStep right;
    PixelStep up;
    float reach_rad; // facets up to this far from N reflect anything
    float step;      // what the half vector turns by in the pixel towards a lamp at distance 1
#else
    float reach; // (N.H)^2 from which on a lobe reflects anything
#endif
};

LobeForm form_of(Lobe lobe) {
#ifdef TG_ANISOTROPIC
    return lobe_form(lobe);
#else
    return lobe_form_isotropic(lobe.ln_mu_deg);
#endif
}

// A lower bound of the form's smaller eigenvalue: of the exponent over phi^2.
float least(LobeForm form) {
#ifdef TG_LONG_LOBES
    float d = 0.5 * (form.xx - form.yy);
    // By the product of the two: their difference loses the smaller one in a long lobe.
    return form.scale * form.scale / (0.5 * (form.xx + form.yy) + sqrt(d * d + form.xy * form.xy));
#else
    return form.scale;
#endif
}

#ifdef TG_BENCH_61
// The paper's own form: no table, the sum over wavelengths in each pixel, with the reflectance computed once for each
// light, wavelength and model. Only for measuring what the table saves.
vec3 spectral_sum(int row, float cos_i, float cos_h, float at_theta_i, float at_theta_h) {
    vec3 sum = vec3(0.0);
    for (int k = 0; k < TG_WAVELENGTHS; ++k) {
        vec2 nk = wavelengths.nk[k].xy;
        float f = fresnel_conductor(nk.x, nk.y, cos_i) * at_theta_i;
        f += fresnel_conductor(nk.x, nk.y, cos_h) * at_theta_h;
        sum += wavelengths.rgb[row * TG_WAVELENGTHS + k].xyz * f;
    }
    return sum;
}
#endif

// Whether any lobe of the pixel reflects this lamp: phi >= sin(phi), and what is left out is below 1e-13 of the peak.
// Cheap and a little generous; light_geometry_at() has the last word.
int reached(Towards t, Steel s) {
#ifdef TG_EVERY_LAMP
    // Only for measuring what this saves.
    return 1;
#else
    vec3 half_vector = s.view + t.direction;
    float along = dot(s.axes.normal, half_vector);
#ifdef TG_FILTERED
    float rad = s.reach_rad + s.step * t.nearness;
    float reach = 1.0 - 2.0e-6 - rad * rad;
#else
    float reach = s.reach;
#endif
    return along > s.n_dot_v && along * along > reach * dot(half_vector, half_vector) ? 1 : 0;
#endif
}

#ifdef TG_FILTERED
#define TG_TURNED , right, up
// D(0) is 1: the model's own weight and shadowing, with the mean of D in the pixel's place.
LightGeometry at_peak(LightGeometry g) {
    g.facet.dx = 0.0;
    g.facet.dy = 0.0;
    return g;
}

float smooth_part(LobeForm form, LightGeometry g, float chi, Facet right, Facet up) {
    return ji_reflection(form, at_peak(g), chi) * pixel_lobe_value(form, g.facet, right, up);
}

float rough_part(LobeForm form, LightGeometry g, float beta, Facet right, Facet up) {
    return hamon_reflection(form, at_peak(g), beta) * pixel_lobe_value(form, g.facet, right, up);
}
#else
#define TG_TURNED
#define smooth_part ji_reflection
#define rough_part hamon_reflection
#endif

vec3 reflect_light(Towards t, vec3 colour, int row, Steel s) {
    vec3 light = t.direction;
    HalfAngle half_vector = half_angle(s.axes.normal, s.view, light);
#ifdef TG_FILTERED
    Facet right = facet_turn(s.axes, s.view, light, t.nearness, s.right);
    Facet up = facet_turn(s.axes, s.view, light, t.nearness, s.up);
#endif
#ifdef TG_LONG_LOBES
    Facet facet = facet_of(half_vector, s.axes.tangent, s.axes.bitangent);
#else
    Facet facet = facet_isotropic(half_vector);
#endif
    LightGeometry g = light_geometry_at(s.axes.normal, s.view, light, half_vector, facet);
#ifdef TG_ONE_LOBE
    bool rough = s.w > 0.5;
    float amount = rough ? rough_part(s.ji, g, s.chi TG_TURNED) : smooth_part(s.ji, g, s.chi TG_TURNED);
    float cosine = rough ? g.cos_h : g.cos_i;
#ifdef TG_BENCH_61
    return colour * spectral_sum(row, g.cos_i, g.cos_h, rough ? 0.0 : amount, rough ? amount : 0.0);
#else
    return colour * (table_rgb(row, cosine) * amount);
#endif
#else
    float hadori = 0.0;
#ifdef TG_HADORI
    hadori = rough_part(s.hadori, g, s.beta_hadori TG_TURNED);
#endif
    Reflection r =
        blend_reflection(smooth_part(s.ji, g, s.chi TG_TURNED), hadori, rough_part(s.ha, g, s.beta_ha TG_TURNED), s.w, s.h);
#ifdef TG_BENCH_61
    return colour * spectral_sum(row, g.cos_i, g.cos_h, r.at_theta_i, r.at_theta_h);
#else
    return colour * (table_rgb(row, g.cos_i) * r.at_theta_i + table_rgb(row, g.cos_h) * r.at_theta_h);
#endif
#endif
}

#ifdef TG_AREAS
#include "viewport/areas.glsl"

vec3 node_colour(LightNode node, AreaLobe q) {
    return table_rgb(q.row, q.at_theta_i ? node.n_dot_l : node.v_dot_h) * shadowed_node(node, q);
}

#ifdef TG_ONE_LOBE
#define TG_LOBES 1
#elif defined(TG_HADORI)
#define TG_LOBES 3
#else
#define TG_LOBES 2
#endif

// Lobe 0, 1 or 2 of the pixel (ji, ha, hadori) for light of this row.
struct SteelLobe {
    AreaLobe lobe;
    float share;      // of the pixel
    float own_weight; // negative: normalised
};

SteelLobe steel_lobe(int number, int row, Steel s) {
    SteelLobe l;
    l.lobe.axes = s.axes;
    l.lobe.view = s.view;
    l.lobe.n_dot_v = s.n_dot_v;
    l.lobe.row = row;
#ifdef TG_MIRRORED
    l.lobe.place = s.place;
    l.lobe.own = s.own;
#endif
    l.lobe.form = s.ji;
    l.lobe.at_theta_i = number == 0;
    l.own_weight = s.chi;
    l.share = 1.0;
#ifdef TG_ONE_LOBE
    l.lobe.at_theta_i = s.w <= 0.5;
#else
    float w = sanitise_share(s.w);
    float h = sanitise_share(s.h);
    l.share = (1.0 - w) * (1.0 - h);
    if (number == 1) {
        l.lobe.form = s.ha;
        l.own_weight = s.beta_ha;
        l.share = w;
    }
#ifdef TG_HADORI
    if (number == 2) {
        l.lobe.form = s.hadori;
        l.own_weight = s.beta_hadori;
        l.share = (1.0 - w) * h;
    }
#endif
#endif
    l.lobe.shadowed = !l.lobe.at_theta_i || l.own_weight < 0.0;
    return l;
}

#ifdef TG_FILTERED
// The lobe widened by the pixel's facets, which turn by so much to the right and upwards.
SteelLobe widened(SteelLobe own, Facet right, Facet up) {
    SteelLobe l = own;
    l.lobe.form = lobe_form_widened(own.lobe.form, right, up, 0.25);
    l.own_weight *= l.lobe.form.scale / own.lobe.form.scale;
    return l;
}
#endif

float weight_of(SteelLobe l) {
    return l.share * (l.own_weight < 0.0 ? lobe_normalised_weight(l.lobe.form) : l.own_weight);
}

// A lamp of a size and one of the pixel's lobes: number `pair` of all such.
struct AreaPair {
    AreaSeen seen;
    SteelLobe lobe;
    bool reached; // whether the lobe reflects any of the lamp
};

AreaPair area_pair(int pair, vec3 place, Steel s) {
    int lamp = pair / TG_LOBES;
    TgArea area = areas.area[lamp];
    AreaPair p;
    p.seen = area_seen(area, place);
    p.lobe = steel_lobe(pair - TG_LOBES * lamp, int(area.colour.w), s);
#ifdef TG_FILTERED
    // From the mirror direction or, where the lamp is elsewhere, from its middle.
    vec3 mirror = s.axes.normal * (2.0 * s.n_dot_v) - s.view;
    vec3 from = dot(mirror, p.seen.axis) > cos(min(p.seen.bound_rad, TG_PI)) ? mirror : p.seen.axis;
    Facet right = facet_turn(s.axes, s.view, from, p.seen.nearness, s.right);
    Facet up = facet_turn(s.axes, s.view, from, p.seen.nearness, s.up);
    p.lobe = widened(p.lobe, right, up);
#endif
    p.lobe.lobe.widest = max(least(p.lobe.lobe.form), 1.0e-6);
    p.reached = p.lobe.share > 0.0 && area_reached(p.seen, p.lobe.lobe);
    return p;
}

// What the pixel reflects of all lamps of a size. Each pixel goes from one pair that it reflects to the next: the slices are
// most of the work, and a compiler that takes both sides of a branch computes them once for each turn of the outer loop only.
vec3 reflect_areas(vec3 place, Steel s) {
    vec3 sum = vec3(0.0);
    int pairs = s.n_dot_v > TG_MIN_COS ? int(frame.view.y) * TG_LOBES : 0;
    int pair = 0;
    for (int turn = 0; turn < pairs; ++turn) {
        bool found = false;
        while (pair < pairs && !found) {
            found = area_pair(pair, place, s).reached;
            pair += found ? 0 : 1;
        }
        if (!found) {
            break;
        }
        AreaPair p = area_pair(pair, place, s);
        TgArea area = areas.area[pair / TG_LOBES];
#ifdef TG_SHADOWS
        p.seen = area_seen_past(p.seen, area, s.place, s.own);
        p.seen = seen_by_lobe(p.seen, p.lobe.lobe, s.own);
#endif
        sum += area.colour.xyz * area_reflection(area, p.seen, p.lobe.lobe, int(frame.view.z)) * weight_of(p.lobe);
        ++pair;
    }
    return sum;
}

#ifdef TG_SURROUNDINGS
#include "viewport/environment.glsl"

// What the pixel reflects of the surroundings, and in which share of it no thing is.
vec4 reflect_surroundings(Steel s) {
    vec4 sum = vec4(0.0);
#ifdef TG_FILTERED
    vec3 mirror = s.axes.normal * (2.0 * s.n_dot_v) - s.view;
    Facet right = facet_turn(s.axes, s.view, mirror, 0.0, s.right);
    Facet up = facet_turn(s.axes, s.view, mirror, 0.0, s.up);
#endif
    for (int number = 0; number < TG_LOBES; ++number) {
        SteelLobe l = steel_lobe(number, int(frame.world.w), s);
#ifdef TG_FILTERED
        l = widened(l, right, up);
#endif
        l.lobe.widest = 1.0;
        int times = l.share > 0.0 ? 1 : 0;
        for (int once = 0; once < times; ++once) {
            SurroundingsSeen seen = surroundings_reflection(l.lobe);
            sum += vec4((seen.world * frame.world.xyz + seen.things) * weight_of(l), seen.open * l.share);
        }
    }
    return sum;
}
#endif
#endif

#define TG_REACHED(towards) reached(towards, s)
#define TG_REFLECT(towards, colour, row) reflect_light(towards, colour, row, s)
#ifdef TG_SHADOWS
#define TG_SEEN(index, towards) lamp_seen(index, towards, s.place, s.own)
#else
#define TG_SEEN(index, towards) 1.0
#endif

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 surface = texelFetch(surface_buffer, at, 0);
#ifdef TG_MANY
    if (steel_number(surface) != int(object_state.y + 0.5)) {
        discard;
    }
#endif
    SteelPixel p = steel_pixel(surface, at);
    vec3 place = p.position;
    Steel s;
    s.view = p.view;
#if defined(TG_SHADOWS) || defined(TG_MIRRORED)
    s.place = place;
    s.own = p.own;
#endif
    s.axes = p.axes;
    s.w = p.w;
    s.h = p.h;
    s.chi = p.chi;
    s.ji = form_of(p.ji);
#ifdef TG_NORMAL_MAP
    LobeForm own_ji = s.ji;
    s.ji = spread_lobe(own_ji, p);
    s.chi = spread_weight(s.chi, own_ji, s.ji);
#endif
    float widest = least(s.ji); // smallest exponent over phi^2 of all lobes
#ifndef TG_ONE_LOBE
    s.ha = form_of(p.ha);
    s.beta_ha = p.beta_ha;
#ifdef TG_NORMAL_MAP
    LobeForm own_ha = s.ha;
    s.ha = spread_lobe(own_ha, p);
    s.beta_ha = spread_weight(s.beta_ha, own_ha, s.ha);
#endif
    widest = p.w > 0.0 ? min(widest, least(s.ha)) : widest;
#ifdef TG_HADORI
    s.hadori = form_of(p.hadori);
    s.beta_hadori = p.beta_hadori;
#ifdef TG_NORMAL_MAP
    LobeForm own_hadori = s.hadori;
    s.hadori = spread_lobe(own_hadori, p);
    s.beta_hadori = spread_weight(s.beta_hadori, own_hadori, s.hadori);
#endif
    widest = p.h > 0.0 ? min(widest, least(s.hadori)) : widest;
#endif
#endif
    s.n_dot_v = dot(s.axes.normal, s.view);
#ifdef TG_FILTERED
    s.right = p.right;
    s.up = p.up;
    // Half a pixel to each side and the filter's own tails; |V + L| is N.V at least where a lobe reflects.
    float half_inv = 1.0 / max(s.n_dot_v, 0.02);
    s.reach_rad = sqrt(TG_DARK_EXPONENT / max(widest, 1.0e-6)) + length(s.right.normal) + length(s.up.normal) +
                  (length(s.right.view) + length(s.up.view)) * half_inv;
    s.step = (length(s.right.place) + length(s.up.place)) * half_inv;
#else
    s.reach = 1.0 - 2.0e-6 - TG_DARK_EXPONENT / max(widest, 1.0e-6);
#endif
    vec3 sum = vec3(0.0);
#include "viewport/loop.glsl"
#ifdef TG_AREAS
    sum += reflect_areas(place, s);
#endif
    float open = 1.0;
#ifdef TG_SURROUNDINGS
    if (s.n_dot_v > TG_MIN_COS) {
        vec4 surroundings = reflect_surroundings(s);
        sum += surroundings.xyz;
        open = surroundings.w;
    }
#endif
#ifdef TG_WORLD
    // A uniform room: the lobes gather the same radiance from everywhere that no thing is, so what is left is F at theta_r.
    float cos_r = dot(s.axes.normal, s.view);
    if (cos_r > TG_MIN_COS) {
        sum += frame.world.xyz * table_rgb(int(frame.world.w), cos_r) * open;
    }
#endif
    out_colour = vec4(finite_output(sum), 1.0);
}
