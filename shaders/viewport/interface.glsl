// What the add-on uploads (addon/togishi/core/packing.py writes the same layouts, std140, vec4 only).
// Positions are relative to the camera and along the world's axes, so that a blade a kilometre from the
// origin is as sharp as one at the origin.

struct TgFrame {
    mat4 view_projection; // of camera-relative positions
    vec4 view_axis;       // orthographic: unit vector to the viewer, 0; perspective: 0 0 0, 1
    vec4 depth_row;       // depth along the view axis = dot(xyz, position) + w
    vec4 world;           // rgb of the surroundings before its spectrum, row in the table
    vec4 counts;          // points, spots, suns, level-of-detail bias
};

// Point and spot lamps first (points, then spots), then suns.
struct TgLight {
    vec4 place;  // camera-relative position; sun: unit vector to the light
    vec4 colour; // rgb times W; sun: rgb times W/m^2. w: row in the table
};

struct TgSpot {
    vec4 axis_x; // lamp's x axis over its scale, blend
    vec4 axis_y; // lamp's y axis over its scale, cosine of half the cone
    vec4 axis_z; // the way the lamp shines, over its scale
};

struct TgLights {
    TgLight light[TG_LIGHT_CAPACITY];
};

struct TgSpots {
    TgSpot spot[TG_LIGHT_CAPACITY];
};

// Row r, texel i at [r * TG_TABLE_SIZE + i]: linear RGB of F(theta) times the light (luminance 1).
struct TgTable {
    vec4 rgb[TG_TABLE_SIZE * TG_TABLE_ROWS];
};

// Per part: the lobe (ln_mu_deg, e1, e2) and the measured weight, negative for the normalised one.
struct TgSteel {
    vec4 part[TG_PART_COUNT];      // lobe of the part where no map is
    vec4 ji_of_part[TG_PART_COUNT]; // shape of the ji's lobe where a map has no shape image, and its chi
    vec4 ha;
    vec4 hadori;
    vec4 rough_part[2];             // 1 for parts whose lobe is a hamon (ha, boshi), eight of them
    vec4 atlas;                     // 1/width, 1/height, number of levels, base level's larger side
    vec4 level[TG_MAX_LEVELS];      // x, y, width, height in texels
};

struct TgPlain {
    vec4 albedo; // rgb, index of refraction
    vec4 gloss;  // ln_mu_deg, metallic, 0, 0
};

// Only where the wavelength loop is measured against the table (TG_BENCH_61).
struct TgWavelengths {
    vec4 nk[TG_WAVELENGTHS];                         // n, k
    vec4 rgb[TG_WAVELENGTHS * TG_WAVELENGTH_ROWS];   // light times observer in linear RGB, white-corrected
};
