// What the add-on uploads (addon/togishi/core/packing.py writes the same layouts, std140, vec4 only).
// Everything is in view space: the viewer is the origin and looks along -z. The matrices are multiplied in
// double precision before they come here, so a blade a kilometre from the origin is as sharp as one at the origin.

struct TgFrame {
    mat4 projection;
    vec4 ray;    // a pixel's (x, y)/depth, for an orthographic view its (x, y): gl_FragCoord * ray.xy + ray.zw
    vec4 view;   // 1 for an orthographic view, else 0; lamps of a size; slices of the lobe for each of them; width of
                 // what a sample stands for, in pixels
    vec4 world;  // rgb of the surroundings before its spectrum, row in the table
    vec4 counts; // points, spots, suns, level-of-detail bias
    vec4 series; // of a picture gathered from samples that are known beforehand: this sample's number, how many; else 0, 1;
                 // rays to each lamp of a size from a matt surface, and the number of the first of them
};

// Points, then spots, then suns.
struct TgLight {
    vec4 place;  // position; sun: unit vector to the light. w: 1 where things hide it
    vec4 colour; // rgb times W; sun: rgb times W/m^2. w: row in the table
};

struct TgSpot {
    vec4 axis_x; // lamp's x axis over its scale, blend
    vec4 axis_y; // lamp's y axis over its scale, cosine of half the cone
    vec4 axis_z; // the way the lamp shines, over its scale
};

// A lamp of a size. kind: 0 rectangle, 1 ellipse, 2 sphere, 3 sphere with a spot's cone, 4 sun.
struct TgArea {
    vec4 place;  // centre; sun: unit vector to it; kind
    vec4 colour; // as TgLight's
    vec4 axis_x; // flat: unit axis of half_u; spot: as TgSpot's. w: number of its picture, from 1; 0 for none
    vec4 axis_y; // flat: unit axis of half_v, it shines towards x cross y; spot: as TgSpot's. w: the caster that it is itself, from 1
    vec4 axis_z; // spot: as TgSpot's. w: 1 where things hide the lamp
    vec4 size;   // flat: half_u, half_v, tangent of half its spread (0: all directions), 1/(that less the angle);
                 // sphere: radius, 1 where its falloff is soft; spot: the same, blend, cosine of half the cone; sun: half angle
};

// An HDRI (core/surroundings.py, atlas_of).
struct TgEnvironment {
    vec4 to_picture[3]; // rows of view space to the picture's own space
    vec4 atlas;         // 1/width, 1/height, number of levels, width of a texel of level 0 in rad
    vec4 matt;          // x, y, width, height in texels: what a white matt surface of each normal shines with
    vec4 level[TG_ENVIRONMENT_LEVELS]; // x, y, width, height in texels, without the border of one
};

// A thing that hides lamps or is mirrored (core/casters.py).
struct TgCaster {
    vec4 row_x; // view space to the space of its tree
    vec4 row_y;
    vec4 row_z;
    vec4 tree;  // texel of its first node, number of nodes, texel of its first triangle, its number among the scene's things
    vec4 ball;  // that holds it: middle in view space, radius
    vec4 shown; // 1 where it hides lamps, 1 where it is mirrored, the first of its colours
};

struct TgCasters {
    vec4 count; // casters, least height of a ray's start above a matt surface, colours
    TgCaster caster[TG_CASTER_CAPACITY];
    vec4 colour[TG_CASTER_COLOURS]; // albedo
};

struct TgPicture {
    vec4 to_u;                     // of (x/half_u, y/half_v, 1) on the lamp
    vec4 to_v;
    vec4 info;                     // levels, texels along the side of a square as large as a quarter of the lamp
    vec4 level[TG_PICTURE_LEVELS]; // x, y, width, height in texels, without the border of one
};

struct TgPictures {
    vec4 atlas; // 1/width, 1/height
    TgPicture picture[TG_PICTURE_CAPACITY];
};

struct TgLights {
    TgLight light[TG_LIGHT_CAPACITY];
};

struct TgAreas {
    TgArea area[TG_AREA_CAPACITY];
};

struct TgSpots {
    TgSpot spot[TG_LIGHT_CAPACITY];
};

// Row r, texel i at [r * TG_TABLE_SIZE + i]: linear RGB of F(theta) times the light (luminance 1).
struct TgTable {
    vec4 rgb[TG_TABLE_SIZE * TG_TABLE_ROWS];
};

struct TgSteel {
    vec4 part[TG_PART_COUNT];       // where no map is: ln_mu_deg, e1, e2, and the measured weight, negative for normalised
    vec4 ji_of_part[TG_PART_COUNT]; // where a map is: unused, e1, e2 of the ji's lobe without a shape image, its chi
    vec4 ha;                        // lobe, beta
    vec4 hadori;                    // lobe, beta
    vec4 rough_part[2];             // 1 for parts whose lobe is a hamon (ha, boshi), eight of them
    vec4 atlas;                     // 1/width, 1/height, number of levels
    vec4 level[TG_MAX_LEVELS];      // x, y, width, height in texels
};

// A normal map's atlas, with levels of its own size.
struct TgNormalMap {
    vec4 atlas;                 // 1/width, 1/height, number of levels
    vec4 level[TG_MAX_LEVELS]; // x, y, width, height in texels
};

struct TgPlain {
    vec4 albedo; // rgb, index of refraction
    vec4 gloss;  // ln_mu_deg, metallic
    vec4 shine;  // rgb of its own light, number of its picture, from 1; 0 for none
};

// Only where the wavelength loop is measured against the table (TG_BENCH_61).
struct TgWavelengths {
    vec4 nk[TG_WAVELENGTHS];                       // n, k
    vec4 rgb[TG_WAVELENGTHS * TG_WAVELENGTH_ROWS]; // light times observer in linear RGB, white-corrected
};
