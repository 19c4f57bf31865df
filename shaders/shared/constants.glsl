// Constants of the model. GLSL and C++: rules of the common subset in docs/architecture.md.
// float(...) around a literal is GLSL's way to say "in the precision of this compilation".

#define TG_PI float(3.14159265358979323846)
#define TG_LN2 float(0.693147180559945309417)
#define TG_RAD_PER_DEG float(0.017453292519943295769)
// ln(pi/180): maps and materials hold ln(mu / 1 degree), the model works in radians.
#define TG_LN_RAD_PER_DEG float(-4.0482269650408105)
// No light is reflected below this cosine of either angle to the normal: Torrance-Sparrow's
// 1/cos(theta_r) is finite only where one of the two stays off the horizon (design, section 5).
#define TG_MIN_COS float(1.0e-4)

// Range of a lobe that the model promises to evaluate (shaders/shared/lobe.glsl, sanitise_lobe): geometric-mean
// half width 0.001 to 80 degrees as ln(mu / 1 degree), and |e| up to ln 10, which is mu_t/mu_b = 100.
#define TG_MIN_LN_MU_DEG float(-6.907755278982137)
#define TG_MAX_LN_MU_DEG float(4.382026634673881)
#define TG_MAX_E float(2.302585092994046)
