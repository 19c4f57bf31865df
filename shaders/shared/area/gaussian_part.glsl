// What an interval [a, b] cuts out of the standard normal distribution exp(-x^2/2)/sqrt(2 pi).
//
// | quantity | meaning |
// |----------|---------|
// | share    | integral over [a, b]; 0 where b <= a |
// | mean     | of the part, inside [a, b] |
// | spread   | its standard deviation: mean - spread and mean + spread are a quadrature of two points, exact for a parabola where the part is symmetric |
//
// Error, absolute, in float: share 1e-6, relative 2e-4 out to a = 5; mean and spread 1e-4 (b - a) or better. The interval may be as
// narrow as a float can tell a from b, and infinite ends are allowed up to 1e9.
// Source of the error function: Abramowitz & Stegun, 7.1.26.

struct NormalPart {
    float share;
    float mean;
    float spread;
};

#define TG_INV_SQRT_TAU float(0.39894228040143267794)

// The tail beyond x >= 0 over exp(-x^2/2).
TG_FN float normal_tail_ratio(float x) {
    float t = float(1.0) / (float(1.0) + float(0.23164190) * x);
    float p = float(1.061405429);
    p = p * t - float(1.453152027);
    p = p * t + float(1.421413741);
    p = p * t - float(0.284496736);
    p = p * t + float(0.254829592);
    return float(0.5) * p * t;
}

// Density over that at 0; 0 far out, where a square would overflow.
TG_FN float normal_bump(float x) {
    float c = min(abs(x), float(13.0));
    return abs(x) < float(13.0) ? exp(float(-0.5) * c * c) : float(0.0);
}

// exp(-y^2/2) over exp(-x^2/2) is not needed twice: every erf here is made of the exp that the mean needs anyway.
TG_FN NormalPart normal_part(float a, float b) {
    NormalPart part;
    float h = b - a;
    float middle = float(0.5) * (a + b);
    if (h < float(0.25)) {
        // Series about the middle: the differences below would be those of near numbers.
        float h2 = max(h, float(0.0)) * max(h, float(0.0));
        float m2 = middle * middle;
        part.share = max(h, float(0.0)) * TG_INV_SQRT_TAU * normal_bump(middle) *
                     (float(1.0) + h2 * (m2 - float(1.0)) / float(24.0));
        part.mean = middle - middle * h2 / float(12.0);
        part.spread = sqrt(h2 / float(12.0)) * (float(1.0) - h2 / float(60.0));
        return part;
    }
    float density_a = normal_bump(a);
    float density_b = normal_bump(b);
    float tail_a = normal_tail_ratio(abs(a)) * density_a;
    float tail_b = normal_tail_ratio(abs(b)) * density_b;
    float share = a >= float(0.0)   ? tail_a - tail_b
                  : b <= float(0.0) ? tail_b - tail_a
                                    : float(1.0) - tail_a - tail_b;
    float inverse = TG_INV_SQRT_TAU / max(share, float(1.0e-9));
    float mean = clamp((density_a - density_b) * inverse, a, b);
    float reach_a = density_a > float(0.0) ? a * density_a : float(0.0);
    float reach_b = density_b > float(0.0) ? b * density_b : float(0.0);
    float variance = float(1.0) + (reach_a - reach_b) * inverse - mean * mean;
    // Of a part, no more than of its interval.
    part.share = max(share, float(0.0));
    part.mean = mean;
    part.spread = sqrt(clamp(variance, float(0.0), min(float(1.0), h * h / float(12.0))));
    return part;
}
