// Surroundings reflected by an anisotropic lobe: a row of round taps along its long axis.
// Written by tools/fit_environment_taps.py, which says what was minimised.
//
// Largest error of the reflection of a patch as wide as the short axis, in % of its peak, by aspect:
//
// | taps | 1.5 | 2.1 | 3.1 | 4.5 | 6.5 | 9.5 | 14 | 20 |
// |---|---|---|---|---|---|---|---|---|
// | 3 | 0.17 | 1.9 | 7.3 | 16 | 26 | 36 | 45 | 53 |
// | 5 | 0.027 | 0.32 | 1.8 | 6.6 | 15 | 25 | 34 | 43 |
// | 7 | 0.0029 | 0.05 | 0.45 | 2.5 | 8.1 | 17 | 27 | 36 |
// | 9 | 0.00027 | 0.0073 | 0.11 | 0.93 | 4.2 | 11 | 21 | 30 |
// | 13 | 1.9e-06 | 0.00016 | 0.0068 | 0.13 | 1.1 | 4.6 | 12 | 21 |
// | 25 | 4.8e-13 | 1.4e-09 | 1.2e-06 | 0.00028 | 0.017 | 0.28 | 1.9 | 6.7 |
//
// Source of the idea: McCormack et al., Feline, 1999.

// One row for each of 3, 5, 7, 9, 13 and 25 taps; columns: aspect 20^(i/8), i = 0 to 8.
const float TG_TAP_STEP[54] = {
    float(0.0000), float(1.6441), float(2.5305), float(3.3863), float(4.2198), float(5.3435), float(6.8532), float(8.8944), float(11.5991),
    float(0.0000), float(1.3300), float(2.0089), float(2.6729), float(3.3842), float(4.2225), float(5.2940), float(6.8249), float(8.8764),
    float(0.0000), float(1.1543), float(1.7536), float(2.3123), float(2.9051), float(3.5993), float(4.4628), float(5.6013), float(7.2318),
    float(0.0000), float(1.0325), float(1.5748), float(2.0759), float(2.5965), float(3.1969), float(3.9349), float(4.8817), float(6.2030),
    float(0.0000), float(0.8763), float(1.3384), float(1.7662), float(2.2081), float(2.7016), float(3.2882), float(4.0248), float(4.9959),
    float(0.0000), float(0.6468), float(0.9848), float(1.2926), float(1.6294), float(2.0064), float(2.4258), float(2.9233), float(3.5388)
};
const float TG_TAP_TAU[54] = {
    float(1.0000), float(1.1071), float(1.9787), float(3.1619), float(4.3462), float(5.9777), float(8.1358), float(10.5873), float(14.2502),
    float(1.0000), float(1.0585), float(1.8709), float(2.9448), float(4.3953), float(6.1263), float(8.2787), float(10.3415), float(13.7860),
    float(1.0000), float(1.0559), float(1.8642), float(2.9166), float(4.3863), float(6.3461), float(8.7727), float(11.6764), float(15.3479),
    float(1.0000), float(1.0558), float(1.8635), float(2.9102), float(4.3825), float(6.4114), float(9.0789), float(12.3740), float(16.3313),
    float(1.0000), float(1.0558), float(1.8634), float(2.9083), float(4.3621), float(6.4277), float(9.3279), float(13.0668), float(17.7905),
    float(1.0000), float(1.0558), float(1.8634), float(2.9082), float(4.3589), float(6.4267), float(9.4025), float(13.6734), float(19.5292)
};
const float TG_TAP_WIDTH[54] = {
    float(1.0000), float(1.0021), float(1.0211), float(1.0790), float(1.4366), float(1.9323), float(2.5830), float(3.4204), float(4.4850),
    float(1.0000), float(1.0004), float(1.0055), float(1.0193), float(1.0869), float(1.3385), float(1.8229), float(2.5199), float(3.1852),
    float(1.0000), float(1.0001), float(1.0008), float(1.0043), float(1.0254), float(1.1229), float(1.4027), float(1.9575), float(2.5179),
    float(1.0000), float(1.0000), float(1.0001), float(1.0010), float(1.0044), float(1.0520), float(1.2008), float(1.5857), float(2.1445),
    float(1.0000), float(1.0000), float(1.0000), float(1.0001), float(1.0005), float(1.0112), float(1.0613), float(1.2357), float(1.6246),
    float(1.0000), float(1.0000), float(1.0000), float(1.0000), float(1.0000), float(1.0000), float(1.0028), float(1.0214), float(1.1023)
};

// In units of the short axis's standard deviation.
struct EnvironmentTaps {
    float step;   // from tap to tap
    float tau;    // standard deviation of the weights
    float width;  // of each tap
};

// count: 3, 5, 7, 9, 13 or 25 (another number: the next smaller of them). aspect: 1 to 20, else the nearer end.
TG_FN EnvironmentTaps environment_taps(float aspect, int count) {
    int row = count < 5 ? 0 : count < 7 ? 1 : count < 9 ? 2 : count < 13 ? 3 : count < 25 ? 4 : 5;
    float x = clamp(log(max(aspect, float(1.0))) * float(8.0) / log(float(20.0)), float(0.0), float(7.9999));
    int i = int(x);
    float share = x - float(i);
    int at = row * 9 + i;
    EnvironmentTaps taps;
    taps.step = TG_TAP_STEP[at] + (TG_TAP_STEP[at + 1] - TG_TAP_STEP[at]) * share;
    taps.tau = TG_TAP_TAU[at] + (TG_TAP_TAU[at + 1] - TG_TAP_TAU[at]) * share;
    taps.width = TG_TAP_WIDTH[at] + (TG_TAP_WIDTH[at + 1] - TG_TAP_WIDTH[at]) * share;
    return taps;
}

// Place of tap k of count on the long axis; the weights' sum is the caller's, who divides by it.
TG_FN float environment_tap_place(EnvironmentTaps taps, int count, int k) {
    return (float(k) - float(0.5) * float(count - 1)) * taps.step;
}

TG_FN float environment_tap_weight(EnvironmentTaps taps, float place) {
    return exp(float(-0.5) * place * place / (taps.tau * taps.tau));
}
