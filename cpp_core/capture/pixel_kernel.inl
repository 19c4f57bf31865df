// The kernel's one source: see pixel_kernel.hpp. Included by one .cpp per instruction set.
#include "capture/pixel_kernel.hpp"
#include "capture/pixel_lanes.hpp"

namespace {

using namespace togishi;
using lanes::I;
using lanes::V;

constexpr float ln2 = 0.693147181F;
constexpr float e_cut = 20.0F;         // beyond, the lobe is 2e-9 of its peak: nothing
constexpr float huber = 4.0F;          // sigma, first pass
constexpr float reject = 6.0F;         // sigma, later passes
constexpr float most_aspect_r = 1.5F;  // mu_t/mu_b = 20

constexpr int packed(int i, int j) {
    return i * max_unknowns - i * (i - 1) / 2 + (j - i);
}

struct Form {
    V p, q, a, c, k, slope, e1, e2;  // a: A; slope: (2C - K)/r^2
};

inline Form form_of(const V* x) {
    Form f;
    f.p = x[tilt_u];
    f.q = x[tilt_v];
    f.e1 = x[shape_e1];
    f.e2 = x[shape_e2];
    f.a = ln2 * lanes::exp(-2.0F * x[ln_mu_deg]);
    const V r2 = f.e1 * f.e1 + f.e2 * f.e2;
    const V r = lanes::sqrt(r2);
    const V up = lanes::exp(r + r), down = 1.0F / up;
    const I round = r < 0.1F;
    const V safe = round ? lanes::all(1.0F) : r;
    f.c = 0.5F * (up + down);
    f.k = round ? 2.0F + r2 * (1.33333333F + r2 * (0.26666667F + r2 * 0.025396825F))
                : 0.5F * (up - down) / safe;
    f.slope = round ? 2.66666667F + r2 * (1.06666667F + r2 * 0.15238095F)
                    : (2.0F * f.c - f.k) / (safe * safe);
    return f;
}

template <bool Near>
inline V light(const float* values, int i, int lane) {
    return Near ? lanes::load(values + i * block_pixels + lane) : lanes::all(values[i]);
}

// The lobe and what its slopes need, at one light.
struct AtLight {
    V s1, s2;      // the two lobes, with gain
    V t;           // s1 + s2/k^2
    V e;           // exponent
    V qx, qy;      // Q d
    V m1, m2, n2;  // dx^2 - dy^2, 2 dx dy, |d|^2
    V m;
};

template <bool Haze>
inline AtLight at_light(const Form& f, V chi, V haze, V inverse_k2, V u, V v, V gain) {
    AtLight l;
    const V dx = u - f.p, dy = v - f.q;
    const V xx = dx * dx, yy = dy * dy;
    l.n2 = xx + yy;
    l.m1 = xx - yy;
    l.m2 = 2.0F * dx * dy;
    l.m = f.e1 * l.m1 + f.e2 * l.m2;
    l.e = lanes::max(f.a * (f.c * l.n2 - f.k * l.m), lanes::all(0.0F));
    const V peak = gain * chi;
    l.s1 = l.e < e_cut ? peak * lanes::exp(-l.e) : lanes::all(0.0F);
    l.s2 = lanes::all(0.0F);
    l.t = l.s1;
    if constexpr (Haze) {
        const V wide = l.e * inverse_k2;
        l.s2 = wide < e_cut ? peak * haze * lanes::exp(-wide) : lanes::all(0.0F);
        l.t = l.s1 + l.s2 * inverse_k2;
    }
    l.qx = f.a * ((f.c - f.k * f.e1) * dx - f.k * f.e2 * dy);
    l.qy = f.a * ((f.c + f.k * f.e1) * dy - f.k * f.e2 * dx);
    return l;
}

template <bool Pedestal, bool Haze, bool Near>
struct Fit {
    static constexpr int np = 7 + (Pedestal ? 1 : 0) + (Haze ? 1 : 0);
    static constexpr int pedestal_at = 7;
    static constexpr int haze_at = Pedestal ? 8 : 7;
    static constexpr int terms = np * (np + 1) / 2;

    const PixelLights& lights;
    const PixelSamples& samples;
    const PixelKernelOptions& o;
    int lane;
    float* weight;  // (count, 16): 1/sigma, 0: not used
    V inverse_k2 = lanes::all(1.0F / (o.haze_width * o.haze_width));

    struct Normal {
        V cost;
        V g[np];
        V h[terms];
    };

    static constexpr int at(int i, int j) { return i * np - i * (i - 1) / 2 + (j - i); }

    [[nodiscard]] V value(int i) const {
        return lanes::load(samples.value + i * block_pixels + lane);
    }
    [[nodiscard]] V scale(int i) const {
        return lanes::load(samples.scale + i * block_pixels + lane);
    }
    [[nodiscard]] V weight_of(int i) const { return lanes::load(weight + i * block_pixels + lane); }
    [[nodiscard]] V haze_of(const V* x) const {
        if constexpr (Haze) return x[haze_at];
        return lanes::all(0.0F);
    }
    [[nodiscard]] V pedestal_of(const V* x) const {
        if constexpr (Pedestal) return x[pedestal_at];
        return lanes::all(0.0F);
    }
    [[nodiscard]] AtLight lobe(const Form& f, V chi, V haze, int i) const {
        return at_light<Haze>(f, chi, haze, inverse_k2, light<Near>(lights.u_deg, i, lane),
                              light<Near>(lights.v_deg, i, lane),
                              light<Near>(lights.gain, i, lane));
    }

    // Cost, gradient (of half the cost) and normal matrix. `bend`: residuals beyond it count
    // linearly.
    void evaluate(const V* x, float bend, Normal& n) const {
        const Form f = form_of(x);
        const V chi = lanes::exp(x[ln_chi]);
        const V haze = haze_of(x), pedestal = pedestal_of(x);
        n.cost = lanes::all(0.0F);
        for (V& g : n.g) g = lanes::all(0.0F);
        for (V& h : n.h) h = lanes::all(0.0F);
        for (int i = 0; i < lights.count; ++i) {
            const AtLight l = lobe(f, chi, haze, i);
            const V unit = light<Near>(lights.diffuse, i, lane);
            const V w = weight_of(i);
            V r = (l.s1 + l.s2 + x[diffuse] * unit + pedestal - value(i)) * w;
            // A clipped sample asks for nothing where the model is above it.
            const I idle = (scale(i) < 0.0F) & (r > 0.0F);
            r = idle ? lanes::all(0.0F) : r;
            const V size = lanes::abs(r);
            const I far = size > bend;
            const V share = far ? bend / size : lanes::all(1.0F);
            n.cost += far ? bend * (2.0F * size - bend) : r * r;
            const V wl = idle ? lanes::all(0.0F) : w;
            const V shared = wl * share;
            const V jd = wl * unit;
            n.g[diffuse] += share * jd * r;
            n.h[at(diffuse, diffuse)] += share * jd * jd;
            if constexpr (Pedestal) {
                n.g[pedestal_at] += shared * r;
                n.h[at(diffuse, pedestal_at)] += shared * jd;
                n.h[at(pedestal_at, pedestal_at)] += shared * wl;
            }
            // Where no pixel has its lobe, all that follows adds zeros.
            if (!lanes::any(l.t > 0.0F)) continue;
            const V tw = l.t * wl;
            V j[np];
            j[tilt_u] = 2.0F * tw * l.qx;
            j[tilt_v] = 2.0F * tw * l.qy;
            j[ln_mu_deg] = 2.0F * tw * l.e;
            const V common = 2.0F * f.k * l.n2 - f.slope * l.m, ta = tw * f.a;
            j[shape_e1] = ta * (f.k * l.m1 - f.e1 * common);
            j[shape_e2] = ta * (f.k * l.m2 - f.e2 * common);
            j[ln_chi] = (l.s1 + l.s2) * wl;
            j[diffuse] = jd;
            if constexpr (Pedestal) j[pedestal_at] = wl;
            if constexpr (Haze) {
                const V wide = l.e * inverse_k2;
                j[haze_at] = wide < e_cut
                                 ? wl * chi * light<Near>(lights.gain, i, lane) * lanes::exp(-wide)
                                 : lanes::all(0.0F);
            }
            const V rs = r * share;
#pragma GCC unroll 16
            for (int a = 0; a < np; ++a) {
                const bool linear = a == diffuse || (Pedestal && a == pedestal_at);
                if (!linear) n.g[a] += j[a] * rs;
                const V js = j[a] * share;
#pragma GCC unroll 16
                for (int b = a; b < np; ++b) {
                    const bool both = linear && (b == diffuse || (Pedestal && b == pedestal_at));
                    if (!both) n.h[at(a, b)] += js * j[b];
                }
            }
        }
        for (int k = 0; k < 3; ++k) {
            const int a = ln_mu_deg + k;
            const V off = x[a] - o.prior_mean[static_cast<std::size_t>(k)];
            const float weight_k = o.prior_weight[static_cast<std::size_t>(k)];
            n.cost += weight_k * off * off;
            n.g[a] += weight_k * off;
            n.h[at(a, a)] += lanes::all(weight_k);
        }
    }

    // Cholesky factor of the matrix scaled to a unit diagonal, plus lambda on it. l: rows below the
    // diagonal and reciprocals on it.
    static void factor(const Normal& n, V lambda, V* s, V (&l)[np][np]) {
        for (int i = 0; i < np; ++i)
            s[i] = 1.0F / lanes::sqrt(lanes::max(n.h[at(i, i)], lanes::all(1e-20F)));
#pragma GCC unroll 16
        for (int i = 0; i < np; ++i) {
#pragma GCC unroll 16
            for (int j = 0; j <= i; ++j) {
                V sum = n.h[at(j, i)] * s[i] * s[j];
                if (i == j) sum += lambda;
                for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
                if (i == j) {
                    l[i][i] = 1.0F / lanes::sqrt(lanes::max(sum, lanes::all(1e-6F)));
                } else {
                    l[i][j] = sum * l[j][j];
                }
            }
        }
    }

    static void solve(const Normal& n, V lambda, V* step) {
        V s[np], l[np][np];
        factor(n, lambda, s, l);
        V y[np];
        for (int i = 0; i < np; ++i) {
            V sum = -n.g[i] * s[i];
            for (int k = 0; k < i; ++k) sum -= l[i][k] * y[k];
            y[i] = sum * l[i][i];
        }
        for (int i = np - 1; i >= 0; --i) {
            V sum = y[i];
            for (int k = i + 1; k < np; ++k) sum -= l[k][i] * y[k];
            y[i] = sum * l[i][i];
        }
        for (int i = 0; i < np; ++i) step[i] = y[i] * s[i];
    }

    // Within what the model allows; tells which lanes stood outside.
    I clamp(V* x) const {
        I out = lanes::all(0.0F) > 0.0F;
        const auto within = [&out](V& value, float low, float high) {
            out |= (value < low) | (value > high);
            value = lanes::min(lanes::max(value, lanes::all(low)), lanes::all(high));
        };
        const float reach = lights.reach_deg + 3;
        within(x[tilt_u], -reach, reach);
        within(x[tilt_v], -reach, reach);
        within(x[ln_mu_deg], -3.0F, 3.7F);  // 0.05 to 40 degrees
        within(x[ln_chi], -40.0F, 40.0F);
        const V r = lanes::sqrt(x[shape_e1] * x[shape_e1] + x[shape_e2] * x[shape_e2]);
        const I long_shape = r > most_aspect_r;
        const V shorten = long_shape ? most_aspect_r / r : lanes::all(1.0F);
        out |= long_shape;
        x[shape_e1] *= shorten;
        x[shape_e2] *= shorten;
        if constexpr (Haze) {
            // No bound that flags: without haze the best share is 0.
            x[haze_at] = lanes::min(lanes::max(x[haze_at], lanes::all(0.0F)), lanes::all(0.5F));
        }
        return out;
    }

    // 1/sigma at the model x; from the data alone where a sample is brighter than the model.
    // Samples beyond `most` sigma get weight 0; returns how many.
    V set_weights(const V* x, float most) const {
        const Form f = form_of(x);
        const V chi = lanes::exp(x[ln_chi]);
        const V haze = haze_of(x), pedestal = pedestal_of(x);
        const float sigma2 = o.sigma_h_deg * o.sigma_h_deg;
        V rejected = lanes::all(0.0F);
        for (int i = 0; i < lights.count; ++i) {
            const AtLight l = lobe(f, chi, haze, i);
            const V y = value(i), t = scale(i), size = lanes::abs(t);
            const V base = x[diffuse] * light<Near>(lights.diffuse, i, lane) + pedestal;
            const V signal = lanes::max(y, lanes::all(0.0F));
            // Between picture and model: a shadow, which has no photons, would else count most of
            // all.
            const V expected = 0.5F * (signal + lanes::max(l.s1 + l.s2 + base, lanes::all(0.0F)));
            const V photons = o.noise_gain * size * expected + o.noise_floor2 * size * size;
            // A model far above the picture must not excuse itself by its own steepness. What a
            // clipped sample was is not known.
            const V most_t = t < 0.0F ? l.t : lanes::min(l.t, 2.0F * signal);
            const V steep = most_t * most_t * (l.qx * l.qx + l.qy * l.qy);
            const V variance = photons + 4.0F * sigma2 * steep;
            const I usable = (size > 0.0F) & (light<Near>(lights.gain, i, lane) > 0.0F);
            V w = usable ? 1.0F / lanes::sqrt(variance) : lanes::all(0.0F);
            const V r = (l.s1 + l.s2 + base - y) * w;
            const I wrong = (lanes::abs(r) > most) & ~((t < 0.0F) & (r > 0.0F));
            rejected += wrong ? lanes::all(1.0F) : lanes::all(0.0F);
            w = wrong ? lanes::all(0.0F) : w;
            lanes::store(weight + i * block_pixels + lane, w);
        }
        return rejected;
    }

    void lower_tail(V* x) const {
        // Three times the mean of what lies below the mean.
        V limit = lanes::all(1e30F);
        for (int round = 0; round < 4; ++round) {
            V sum = lanes::all(0.0F), count = lanes::all(1e-6F);
            for (int i = 0; i < lights.count; ++i) {
                const V unit = light<Near>(lights.diffuse, i, lane), y = value(i);
                const I low = (scale(i) > 0.0F) & (unit > 0.01F) & (y <= limit * unit);
                sum += low ? y / lanes::max(unit, lanes::all(0.01F)) : lanes::all(0.0F);
                count += low ? lanes::all(1.0F) : lanes::all(0.0F);
            }
            limit = sum / count;
        }
        x[diffuse] = limit;
        if constexpr (Pedestal) x[pedestal_at] = lanes::all(0.0F);
        if constexpr (Haze) x[haze_at] = lanes::all(0.03F);
    }

    // The lobe's share of a sample, above the noise.
    [[nodiscard]] V lobe_part(const V* x, int i, V floor) const {
        const V gain = light<Near>(lights.gain, i, lane);
        const V s = value(i) - x[diffuse] * light<Near>(lights.diffuse, i, lane) - floor;
        const I usable = (lanes::abs(scale(i)) > 0.0F) & (gain > 0.0F) & (s > 0.0F);
        return usable ? s / lanes::max(gain, lanes::all(1e-20F)) : lanes::all(0.0F);
    }

    // Moments of the half vectors, weighted by what they reflect.
    void moments(V* x) const {
        // The third brightest stands for the brightest: a glint must not draw the lobe to itself.
        V first = lanes::all(0.0F), second = first, third = first;
        for (int i = 0; i < lights.count; ++i) {
            V y = lobe_part(x, i, lanes::all(0.0F));
            V low = lanes::min(first, y);
            first = lanes::max(first, y);
            y = low;
            low = lanes::min(second, y);
            second = lanes::max(second, y);
            third = lanes::max(third, low);
        }
        const V floor = lanes::max(0.02F * third, 2.0F * lanes::sqrt(lanes::all(o.noise_floor2)));
        V sum = lanes::all(1e-30F), su = lanes::all(0.0F), sv = su;
        for (int i = 0; i < lights.count; ++i) {
            const V s = lanes::min(lobe_part(x, i, floor), third) * lights.area[i];
            sum += s;
            su += s * light<Near>(lights.u_deg, i, lane);
            sv += s * light<Near>(lights.v_deg, i, lane);
        }
        x[tilt_u] = su / sum;
        x[tilt_v] = sv / sum;
        V xx = lanes::all(0.0F), xy = xx, yy = xx;
        for (int i = 0; i < lights.count; ++i) {
            const V s = lanes::min(lobe_part(x, i, floor), third) * lights.area[i];
            const V dx = light<Near>(lights.u_deg, i, lane) - x[tilt_u];
            const V dy = light<Near>(lights.v_deg, i, lane) - x[tilt_v];
            xx += s * dx * dx;
            xy += s * dx * dy;
            yy += s * dy * dy;
        }
        // Variance to mu^2; never narrower than the lights could show.
        const float least = 0.2F * lights.spacing_deg * lights.spacing_deg;
        const V to_mu2 = 2.0F * ln2 / sum;
        set_shape(x, xx * to_mu2 + least, xy * to_mu2, yy * to_mu2 + least);
        set_height(x);
    }

    // s, e1, e2 from mu^2 as a tensor.
    static void set_shape(V* x, V xx, V xy, V yy) {
        const V mean = 0.5F * (xx + yy), d = 0.5F * (xx - yy);
        const V q = lanes::sqrt(d * d + xy * xy);
        const V wide = lanes::max(mean + q, lanes::all(1e-6F));
        const V narrow = lanes::max((xx * yy - xy * xy) / wide, 0.01F * wide);
        const V ln_wide = lanes::log(wide), ln_narrow = lanes::log(narrow);
        const V over_q = q > 1e-9F * wide
                             ? 0.25F * (ln_wide - ln_narrow) / lanes::max(q, lanes::all(1e-30F))
                             : lanes::all(0.0F);
        x[ln_mu_deg] = 0.25F * (ln_wide + ln_narrow);
        x[shape_e1] = d * over_q;
        x[shape_e2] = xy * over_q;
    }

    // chi by least squares with the shape as it is.
    void set_height(V* x) const {
        const Form f = form_of(x);
        V top = lanes::all(0.0F), bottom = lanes::all(1e-30F), brightest = lanes::all(1e-30F);
        for (int i = 0; i < lights.count; ++i) {
            const V gain = light<Near>(lights.gain, i, lane);
            const AtLight l = lobe(f, lanes::all(1.0F), lanes::all(0.0F), i);
            const V s = lobe_part(x, i, lanes::all(0.0F)) * gain;
            const I usable = lanes::abs(scale(i)) > 0.0F;
            top += s * l.s1;
            bottom += usable ? l.s1 * l.s1 : lanes::all(0.0F);
            brightest = lanes::max(brightest, s / lanes::max(gain, lanes::all(1e-20F)));
        }
        x[ln_chi] = lanes::log(lanes::max(top / bottom, 0.3F * brightest));
    }

    // Weighted least squares of ln(lobe) = c - (d' Q d), a quadratic in u and v.
    void log_linear(V* x) const {
        constexpr int nq = 6;
        V h[nq * (nq + 1) / 2], g[nq];
        for (V& v : h) v = lanes::all(0.0F);
        for (V& v : g) v = lanes::all(0.0F);
        const V u0 = x[tilt_u], v0 = x[tilt_v];
        const V width = lanes::exp(-x[ln_mu_deg]);
        for (int i = 0; i < lights.count; ++i) {
            const V t = scale(i);
            const V s = lobe_part(x, i, lanes::all(0.0F));
            const V gain = light<Near>(lights.gain, i, lane);
            const V variance =
                o.noise_gain * t * lanes::max(value(i), lanes::all(0.0F)) + o.noise_floor2 * t * t;
            const V signal = s * gain;
            const I usable = (t > 0.0F) & (signal * signal > 16.0F * variance);
            const V w = usable
                            ? signal * signal /
                                  lanes::max(variance + 0.03F * signal * signal, lanes::all(1e-30F))
                            : lanes::all(0.0F);
            const V dx = (light<Near>(lights.u_deg, i, lane) - u0) * width;
            const V dy = (light<Near>(lights.v_deg, i, lane) - v0) * width;
            const V j[nq] = {lanes::all(1.0F), dx, dy, dx * dx, dx * dy, dy * dy};
            const V y = lanes::log(lanes::max(s, lanes::all(1e-30F)));
            int k = 0;
            for (int a = 0; a < nq; ++a) {
                g[a] += usable ? w * j[a] * y : lanes::all(0.0F);
                for (int b = a; b < nq; ++b) h[k++] += w * j[a] * j[b];
            }
        }
        V l[nq][nq], z[nq];
        V least = lanes::all(1e30F);
        for (int i = 0; i < nq; ++i) {
            for (int j = 0; j <= i; ++j) {
                V sum = h[j * nq - j * (j - 1) / 2 + (i - j)];
                const V diagonal = sum;
                for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
                if (i == j) {
                    least = lanes::min(least, sum / lanes::max(diagonal, lanes::all(1e-30F)));
                    l[i][i] = 1.0F / lanes::sqrt(lanes::max(sum, lanes::all(1e-20F)));
                } else {
                    l[i][j] = sum * l[j][j];
                }
            }
        }
        for (int i = 0; i < nq; ++i) {
            V sum = g[i];
            for (int k = 0; k < i; ++k) sum -= l[i][k] * z[k];
            z[i] = sum * l[i][i];
        }
        for (int i = nq - 1; i >= 0; --i) {
            V sum = z[i];
            for (int k = i + 1; k < nq; ++k) sum -= l[k][i] * z[k];
            z[i] = sum * l[i][i];
        }
        // ln S = c + b.d - d' Q d: centre = Q^-1 b/2; mu^2 = ln2 Q^-1.
        const V qxx = -z[3], qxy = -0.5F * z[4], qyy = -z[5];
        const V det = qxx * qyy - qxy * qxy;
        const I good = (least > 1e-4F) & (qxx > 0.0F) & (det > 1e-3F * qxx * qyy) & (qyy > 0.0F);
        const V safe = good ? det : lanes::all(1.0F);
        const V dx = 0.5F * (qyy * z[1] - qxy * z[2]) / safe;
        const V dy = 0.5F * (qxx * z[2] - qxy * z[1]) / safe;
        const V unit = lanes::exp(x[ln_mu_deg]), mu2 = ln2 * unit * unit / safe;
        V found[np];
        for (int a = 0; a < np; ++a) found[a] = x[a];
        found[tilt_u] = u0 + dx * unit;
        found[tilt_v] = v0 + dy * unit;
        set_shape(found, mu2 * qyy, -mu2 * qxy, mu2 * qxx);
        found[ln_chi] = z[0] + 0.5F * (z[1] * dx + z[2] * dy);
        const I near = good & (dx * dx + dy * dy < 4.0F) &
                       (lanes::abs(found[ln_mu_deg] - x[ln_mu_deg]) < 1.5F);
        for (int a = 0; a < np; ++a) x[a] = near ? found[a] : x[a];
    }

    V levenberg(V* x, float bend, V& steps) const {
        Normal n;
        evaluate(x, bend, n);
        V lambda = lanes::all(1e-2F);
        I active = lanes::all(1.0F) > 0.0F;
        for (int step = 0; step < o.steps && lanes::any(active); ++step) {
            V trial[np];
            solve(n, lambda, trial);
            // A step of more than e^1.5 in width or height leaves where the slopes mean anything.
            V longest =
                lanes::max(lanes::abs(trial[ln_mu_deg]),
                           lanes::max(lanes::abs(trial[shape_e1]), lanes::abs(trial[shape_e2])));
            longest = lanes::max(longest, 0.5F * lanes::abs(trial[ln_chi]));
            const V shorten = longest > 1.0F ? 1.0F / longest : lanes::all(1.0F);
            for (int a = 0; a < np; ++a) trial[a] = x[a] + trial[a] * shorten;
            clamp(trial);
            Normal next;
            evaluate(trial, bend, next);
            const I better = active & (next.cost < n.cost);
            const I settled = better & (n.cost - next.cost < 2e-3F + 2e-5F * n.cost);
            const I stuck = active & ~better & (lambda > 1e3F);
            steps += active ? lanes::all(1.0F) : lanes::all(0.0F);
            for (int a = 0; a < np; ++a) {
                x[a] = better ? trial[a] : x[a];
                n.g[a] = better ? next.g[a] : n.g[a];
            }
            for (int k = 0; k < terms; ++k) n.h[k] = better ? next.h[k] : n.h[k];
            n.cost = better ? next.cost : n.cost;
            lambda = better ? lanes::max(lambda * 0.1F, lanes::all(1e-6F)) : lambda * 8.0F;
            active &= ~settled & ~stuck;
        }
        return n.cost;
    }

    void run(PixelBlock& out) const {
        V x[np];
        V steps = lanes::all(0.0F), rejected = lanes::all(0.0F);
        lower_tail(x);
        moments(x);
        if (o.effort != PixelEffort::moments) log_linear(x);
        clamp(x);
        if constexpr (Haze) {
            if (o.effort == PixelEffort::full) choose_start(x, steps);
        }
        if (o.effort == PixelEffort::full) {
            for (int pass = 0; pass < o.passes; ++pass) {
                rejected = set_weights(x, pass == 0 ? 1e6F : reject);
                levenberg(x, pass == 0 ? huber : 1e6F, steps);
            }
        } else {
            rejected = set_weights(x, 1e6F);
        }
        write(x, rejected, steps, out);
    }

    // With haze: the narrow lobe may hide in few samples. Three widths, each a few steps; the best
    // goes on.
    void choose_start(V* x, V& steps) const {
        V best[np];
        for (int a = 0; a < np; ++a) best[a] = x[a];
        V best_cost = lanes::all(1e30F);
        const float shrink[3] = {0.0F, -0.55F, -1.1F};
        const float share[3] = {0.0F, 0.03F, 0.1F};
        for (int s = 0; s < 3; ++s) {
            V y[np];
            for (int a = 0; a < np; ++a) y[a] = x[a];
            y[ln_mu_deg] += shrink[s];
            y[haze_at] = lanes::all(share[s]);
            set_height(y);
            clamp(y);
            (void)set_weights(y, 1e6F);
            (void)levenberg(y, huber, steps);
            // Weights at its own solution, so that the costs of the starts compare.
            (void)set_weights(y, 1e6F);
            const V cost = evidence(y);
            const I better = cost < best_cost;
            best_cost = better ? cost : best_cost;
            for (int a = 0; a < np; ++a) best[a] = better ? y[a] : best[a];
        }
        for (int a = 0; a < np; ++a) x[a] = best[a];
    }

    // -2 ln likelihood up to a constant: whitened squares and the logarithm of the variances.
    [[nodiscard]] V evidence(const V* x) const {
        Normal n;
        evaluate(x, huber, n);
        V sum = n.cost;
        for (int i = 0; i < lights.count; ++i) {
            const V w = weight_of(i);
            sum -=
                w > 0.0F ? 2.0F * lanes::log(lanes::max(w, lanes::all(1e-20F))) : lanes::all(0.0F);
        }
        return sum;
    }

    void write(V* x, V rejected, V steps, PixelBlock& out) const {
        Normal n;
        evaluate(x, 1e6F, n);
        V s[np], l[np][np], inverse[np][np];
        factor(n, lanes::all(0.0F), s, l);
        // Inverse of the factor, then (L L')^-1 = L'^-1 L^-1.
        for (int j = 0; j < np; ++j) {
            inverse[j][j] = l[j][j];
            for (int i = j + 1; i < np; ++i) {
                V sum = lanes::all(0.0F);
                for (int k = j; k < i; ++k) sum -= l[i][k] * inverse[k][j];
                inverse[i][j] = sum * l[i][i];
            }
        }
        const auto lane_at = static_cast<std::size_t>(lane);
        const auto put = [lane_at](PixelBlock::Lanes& to, V v) { lanes::store(&to[lane_at], v); };
        for (int a = 0; a < max_unknowns; ++a) {
            for (int b = a; b < max_unknowns; ++b) {
                V sum = lanes::all(0.0F);
                if (b < np) {
                    for (int k = b; k < np; ++k) sum += inverse[k][a] * inverse[k][b];
                    sum *= s[a] * s[b];
                }
                put(out.covariance[static_cast<std::size_t>(packed(a, b))], sum);
            }
            put(out.x[static_cast<std::size_t>(a)], a < np ? x[a] : lanes::all(0.0F));
        }
        V used = lanes::all(0.0F), clipped = used, lit = used;
        const Form f = form_of(x);
        const V chi = lanes::exp(x[ln_chi]), haze = haze_of(x);
        for (int i = 0; i < lights.count; ++i) {
            const AtLight lo = lobe(f, chi, haze, i);
            const V t = scale(i), signal = lanes::max(value(i), lanes::all(0.0F));
            const V photons = o.noise_gain * t * signal + o.noise_floor2 * t * t;
            const V one = lanes::all(1.0F), none = lanes::all(0.0F);
            const I weighted = weight_of(i) > 0.0F;
            used += weighted ? one : none;
            clipped += t < 0.0F ? one : none;
            lit += (weighted & (t > 0.0F) & (lo.s1 * lo.s1 > 16.0F * photons)) ? one : none;
        }
        V beyond[np];
        for (int a = 0; a < np; ++a) beyond[a] = x[a];
        beyond[ln_mu_deg] *= 1.0001F;
        beyond[shape_e1] *= 1.0001F;
        beyond[shape_e2] *= 1.0001F;
        beyond[tilt_u] *= 1.0001F;
        beyond[tilt_v] *= 1.0001F;
        const I bounded = clamp(beyond);
        put(out.chi2, n.cost);
        put(out.used, used);
        put(out.clipped, clipped);
        put(out.rejected, rejected);
        put(out.lobe_samples, lit);
        put(out.bounded, bounded ? lanes::all(1.0F) : lanes::all(0.0F));
        put(out.steps, steps);
    }

    void slopes(const PixelBlock& in, const PixelSlopes& out) const {
        V x[np];
        for (int a = 0; a < np; ++a)
            x[a] = lanes::load(&in.x[static_cast<std::size_t>(a)][static_cast<std::size_t>(lane)]);
        const Form f = form_of(x);
        const V chi = lanes::exp(x[ln_chi]);
        const V haze = haze_of(x), pedestal = pedestal_of(x);
        const float sigma2 = o.sigma_h_deg * o.sigma_h_deg;
        for (int i = 0; i < lights.count; ++i) {
            const AtLight l = lobe(f, chi, haze, i);
            const V t = scale(i), y = value(i), signal = lanes::max(y, lanes::all(0.0F));
            const V steep = lanes::min(l.t, 2.0F * signal);
            const V variance = o.noise_gain * t * signal + o.noise_floor2 * t * t +
                               4.0F * sigma2 * steep * steep * (l.qx * l.qx + l.qy * l.qy);
            const I usable = (t > 0.0F) & (light<Near>(lights.gain, i, lane) > 0.0F);
            const V w = usable ? 1.0F / lanes::sqrt(variance) : lanes::all(0.0F);
            const V base = x[diffuse] * light<Near>(lights.diffuse, i, lane) + pedestal;
            const V wt = l.t * w, ta = wt * f.a;
            const V common = 2.0F * f.k * l.n2 - f.slope * l.m;
            V j[np];
            j[tilt_u] = 2.0F * wt * l.qx;
            j[tilt_v] = 2.0F * wt * l.qy;
            j[ln_mu_deg] = 2.0F * wt * l.e;
            j[shape_e1] = ta * (f.k * l.m1 - f.e1 * common);
            j[shape_e2] = ta * (f.k * l.m2 - f.e2 * common);
            j[ln_chi] = (l.s1 + l.s2) * w;
            j[diffuse] = w * light<Near>(lights.diffuse, i, lane);
            if constexpr (Pedestal) j[pedestal_at] = w;
            if constexpr (Haze) j[haze_at] = l.s2 * w / lanes::max(haze, lanes::all(1e-6F));
            lanes::store(out.residual + i * block_pixels + lane, (l.s1 + l.s2 + base - y) * w);
            for (int a = 0; a < np; ++a)
                lanes::store(out.by_unknown + (a * lights.count + i) * block_pixels + lane, j[a]);
        }
    }
};

template <class Action>
void for_variant(const PixelLights& lights, const PixelKernelOptions& o, const Action& action) {
    const bool near = lights.stride != 1;
    if (o.pedestal && o.haze) {
        near ? action.template operator()<true, true, true>()
             : action.template operator()<true, true, false>();
    } else if (o.pedestal) {
        near ? action.template operator()<true, false, true>()
             : action.template operator()<true, false, false>();
    } else if (o.haze) {
        near ? action.template operator()<false, true, true>()
             : action.template operator()<false, true, false>();
    } else {
        near ? action.template operator()<false, false, true>()
             : action.template operator()<false, false, false>();
    }
}

void fit_block(const PixelLights& lights, const PixelSamples& samples, const PixelKernelOptions& o,
               float* scratch, PixelBlock& out) {
    for_variant(lights, o, [&]<bool Pedestal, bool Haze, bool Near>() {
        for (int lane = 0; lane < block_pixels; lane += lanes::width) {
            const Fit<Pedestal, Haze, Near> fit{lights, samples, o, lane, scratch};
            fit.run(out);
        }
    });
}

void block_slopes(const PixelLights& lights, const PixelSamples& samples,
                  const PixelKernelOptions& o, const PixelBlock& in, const PixelSlopes& out) {
    for_variant(lights, o, [&]<bool Pedestal, bool Haze, bool Near>() {
        for (int lane = 0; lane < block_pixels; lane += lanes::width) {
            const Fit<Pedestal, Haze, Near> fit{lights, samples, o, lane, nullptr};
            fit.slopes(in, out);
        }
    });
}

}  // namespace
