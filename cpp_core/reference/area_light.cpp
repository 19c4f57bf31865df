#include "reference/area_light.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

#include "brdf/model.hpp"

namespace togishi {
namespace {

constexpr double pi = 3.14159265358979323846;

/// A point of the light as the shaded point sees it: towards it, the solid angle of d(parameters),
/// and what the light emits there, relative to its radiance.
struct Sample {
    glm::dvec3 direction;
    double solid_angle;
    double emission;
};

/// Part of a light's line a = constant that is above the horizon, in the line's own parameter.
struct Range {
    double lo, hi;
};

/// Where from + s along has a positive height in [lo, hi].
Range above(double from, double along, Range whole) {
    if (along == 0) return from > 0 ? whole : Range{0, 0};
    const double cut = -from / along;
    const Range part = along > 0 ? Range{std::max(whole.lo, cut), whole.hi}
                                 : Range{whole.lo, std::min(whole.hi, cut)};
    return part.lo < part.hi ? part : Range{0, 0};
}

/// The light over the unit square: a across it, s along the line's part above the horizon.
class Surface {
  public:
    Surface(const AreaLight& light, const glm::dvec3& normal) : light_(light), normal_(normal) {
        if (const auto* spot = std::get_if<SpotLight>(&light_))
            take_cap(spot->centre, spot->radius);
        else if (const auto* sphere = std::get_if<SphereLight>(&light_))
            take_cap(sphere->centre, sphere->radius);
        else if (const auto* sun = std::get_if<SunLight>(&light_))
            take_cap_angle(sun->direction, std::sin(sun->half_angle_rad));
    }

    [[nodiscard]] Sample at(double a, double s) const {
        if (const auto* r = std::get_if<RectangleLight>(&light_))
            return flat(r->centre, r->half_u, r->half_v, 2 * a - 1, 2, {-1, 1}, s, r->emission);
        if (const auto* e = std::get_if<EllipseLight>(&light_)) {
            const double angle = pi * (a - 0.5), chord = std::cos(angle);
            return flat(e->centre, e->half_u, e->half_v, std::sin(angle), pi * chord,
                        {-chord, chord}, s, {});
        }
        return cap(a, s);
    }

  private:
    void take_cap(const glm::dvec3& centre, double radius) {
        const double distance = glm::length(centre);
        // Inside: nothing is seen of it.
        take_cap_angle(distance > radius ? centre / distance : glm::dvec3(0.0),
                       distance > radius ? radius / distance : 0.0);
    }

    void take_cap_angle(const glm::dvec3& direction, double sine) {
        axis_ = direction;
        sine_ = sine;
        const auto frame = f64::tangent_frame(
            direction, std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0));
        x_ = frame.tangent;
        y_ = frame.bitangent;
    }

    /// Line u, of which d(a) is du_da wide.
    [[nodiscard]] Sample flat(const glm::dvec3& centre, const glm::dvec3& half_u,
                              const glm::dvec3& half_v, double u, double du_da, Range line,
                              double s,
                              const std::function<double(double, double)>& emission) const {
        const glm::dvec3 start = centre + u * half_u;
        const Range part = above(glm::dot(normal_, start), glm::dot(normal_, half_v), line);
        const double v = part.lo + (part.hi - part.lo) * s;
        const glm::dvec3 p = start + v * half_v;
        const double r2 = glm::dot(p, p);
        const double facing = -glm::dot(glm::cross(half_u, half_v), p);
        if (!(facing > 0 && r2 > 0)) return {glm::dvec3(0.0), 0, 0};
        const double r = std::sqrt(r2);
        return {p / r, facing / (r2 * r) * (part.hi - part.lo) * du_da,
                emission ? emission(u, v) : 1};
    }

    /// The directions of a cap, by their projection on the plane across its axis: a disk.
    [[nodiscard]] Sample cap(double a, double s) const {
        const double angle = pi * (a - 0.5), chord = std::cos(angle);
        const double x = sine_ * std::sin(angle);
        const double half = sine_ * chord;
        // Above the horizon: N.(x X + y Y + sqrt(1 - x^2 - y^2) axis) > 0, by bisection where the
        // line crosses it: a conic, and the plainest code is the best reference.
        const auto height = [&](double y) {
            return glm::dot(normal_,
                            x * x_ + y * y_ + std::sqrt(std::max(0.0, 1 - x * x - y * y)) * axis_);
        };
        Range part{-half, half};
        const double peak = highest(x, half);
        if (!(height(peak) > 0)) return {glm::dvec3(0.0), 0, 0};
        if (height(part.lo) < 0) part.lo = crossing(height, part.lo, peak);
        if (height(part.hi) < 0) part.hi = crossing(height, part.hi, peak);
        const double y = part.lo + (part.hi - part.lo) * s;
        const double z = std::sqrt(std::max(1e-30, 1 - x * x - y * y));
        const glm::dvec3 direction = x * x_ + y * y_ + z * axis_;
        return {direction, sine_ * pi * chord * (part.hi - part.lo) / z, emission(direction)};
    }

    /// The y of a line on the cap that is farthest above the horizon: height is concave in y.
    [[nodiscard]] double highest(double x, double half) const {
        const double ny = glm::dot(normal_, y_), nz = glm::dot(normal_, axis_);
        const double reach = std::sqrt(std::max(0.0, 1 - x * x));
        if (nz <= 0) return ny > 0 ? half : -half;
        return std::clamp(reach * ny / std::hypot(ny, nz), -half, half);
    }

    template <class Height>
    static double crossing(const Height& height, double below, double over) {
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (below + over);
            (height(middle) > 0 ? over : below) = middle;
        }
        return over;
    }

    [[nodiscard]] double emission(const glm::dvec3& direction) const {
        const auto* spot = std::get_if<SpotLight>(&light_);
        if (!spot) return 1;
        return f64::light_spot_blend(-glm::dot(direction, spot->axis), spot->cos_half, spot->blend);
    }

    AreaLight light_;
    glm::dvec3 normal_;
    glm::dvec3 axis_{0.0}, x_{0.0}, y_{0.0};
    double sine_ = 0;
};

class Integrand {
  public:
    Integrand(const AreaLightPoint& point, const AreaLight& light)
        : point_(point),
          frame_(f64::tangent_frame(point.normal, point.tangent)),
          form_(f64::lobe_form({point.lobe[0], point.lobe[1], point.lobe[2]})),
          surface_(light, frame_.normal) {}

    [[nodiscard]] double radiance(double a, double s) const {
        const Sample sample = surface_.at(a, s);
        if (!(sample.solid_angle > 0 && sample.emission > 0)) return 0;
        const auto g = geometry(sample);
        if (g.lit == 0) return 0;
        const bool ji = point_.model == AreaLightModel::ji;
        const double reflection = ji ? f64::ji_reflection(form_, g, point_.weight)
                                     : f64::hamon_reflection(form_, g, point_.weight);
        const bool mirror = point_.n == 0 && point_.k == 0;
        const double fresnel =
            mirror ? 1 : f64::fresnel_conductor(point_.n, point_.k, ji ? g.cos_i : g.cos_h);
        return reflection * fresnel * sample.solid_angle * sample.emission;
    }

    /// Facet in half widths times sqrt(2 ln2): D = exp(-z.z/2). False where nothing is lit.
    [[nodiscard]] bool whitened(double a, double s, glm::dvec2& z) const {
        const Sample sample = surface_.at(a, s);
        if (!(sample.solid_angle > 0)) return false;
        const auto g = geometry(sample);
        z = std::sqrt(2 / form_.xx) *
            glm::dvec2(form_.xx * g.facet.dx + form_.xy * g.facet.dy, form_.scale * g.facet.dy);
        return g.lit > 0;
    }

  private:
    [[nodiscard]] f64::LightGeometry geometry(const Sample& sample) const {
        return f64::light_geometry(frame_.normal, frame_.tangent, frame_.bitangent, point_.view,
                                   sample.direction);
    }

    AreaLightPoint point_;
    f64::TangentFrame frame_;
    f64::LobeForm form_;
    Surface surface_;
};

struct Cell {
    double a0, a1, s0, s1;
    double value, error;
    bool split_a;
    bool operator<(const Cell& other) const { return error < other.error; }
};

// Kronrod's 15 points on [-1, 1] (Piessens et al., QUADPACK, 1983); every second one is Gauss's.
constexpr double node[8] = {
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0};
constexpr double kronrod[8] = {
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr double gauss[8] = {
    0, 0.129484966168869693270611432679082, 0, 0.279705391489276667901467771423780,
    0, 0.381830050505118944950369775488975, 0, 0.417959183673469387755102040816327};

double node_of(int i) {
    return i < 8 ? -node[i] : node[14 - i];
}
double weight_of(const double (&weights)[8], int i) {
    return weights[i < 8 ? i : 14 - i];
}

class Quadrature {
  public:
    explicit Quadrature(const Integrand& integrand) : integrand_(integrand) {}

    void measure(Cell& cell) {
        const double ha = 0.5 * (cell.a1 - cell.a0), hs = 0.5 * (cell.s1 - cell.s0);
        const double ma = 0.5 * (cell.a1 + cell.a0), ms = 0.5 * (cell.s1 + cell.s0);
        double fine = 0, coarse_a = 0, coarse_s = 0;
        for (int i = 0; i < 15; ++i) {
            double row = 0, row_gauss = 0;
            for (int j = 0; j < 15; ++j) {
                const double f = integrand_.radiance(ma + ha * node_of(i), ms + hs * node_of(j));
                row += weight_of(kronrod, j) * f;
                row_gauss += weight_of(gauss, j) * f;
            }
            fine += weight_of(kronrod, i) * row;
            coarse_s += weight_of(kronrod, i) * row_gauss;
            coarse_a += weight_of(gauss, i) * row;
        }
        evaluations_ += 225;
        cell.value = ha * hs * fine;
        const double error_a = std::abs(fine - coarse_a), error_s = std::abs(fine - coarse_s);
        cell.error = ha * hs * (error_a + error_s);
        cell.split_a = error_a > error_s;
    }

    /// Cells over which the facet moves by a few widths of the lobe; those far from it are dropped.
    void start(const Cell& cell, int depth, std::vector<Cell>& cells) {
        constexpr int n = 5;
        glm::dvec2 z[n][n];
        bool lit[n][n];
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                lit[i][j] = integrand_.whitened(
                    cell.a0 + (cell.a1 - cell.a0) * (0.002 + 0.996 * i / (n - 1)),
                    cell.s0 + (cell.s1 - cell.s0) * (0.002 + 0.996 * j / (n - 1)), z[i][j]);
            }
        }
        double step_a = 0, step_s = 0, nearest = INFINITY;
        int count = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                if (!lit[i][j]) continue;
                ++count;
                nearest = std::min(nearest, glm::length(z[i][j]));
                if (i > 0 && lit[i - 1][j])
                    step_a = std::max(step_a, glm::length(z[i][j] - z[i - 1][j]));
                if (j > 0 && lit[i][j - 1])
                    step_s = std::max(step_s, glm::length(z[i][j] - z[i][j - 1]));
            }
        }
        evaluations_ += n * n;
        if (count == n * n && nearest - step_a - step_s > 9) return;
        const bool partly = count < n * n && depth < 12;
        if (depth < 60 && (step_a > 1.2 || step_s > 1.2 || partly)) {
            const bool across =
                partly && step_a <= 1.2 && step_s <= 1.2 ? depth % 2 == 0 : step_a > step_s;
            const auto [first, second] = halves(cell, across);
            start(first, depth + 1, cells);
            start(second, depth + 1, cells);
            return;
        }
        cells.push_back(cell);
    }

    static std::pair<Cell, Cell> halves(const Cell& cell, bool across) {
        Cell first = cell, second = cell;
        if (across)
            first.a1 = second.a0 = 0.5 * (cell.a0 + cell.a1);
        else
            first.s1 = second.s0 = 0.5 * (cell.s0 + cell.s1);
        return {first, second};
    }

    [[nodiscard]] std::size_t evaluations() const { return evaluations_; }

  private:
    const Integrand& integrand_;
    std::size_t evaluations_ = 0;
};

}  // namespace

AreaLightRadiance reference_area_light(const AreaLightPoint& point, const AreaLight& light,
                                       double relative_error) {
    const Integrand integrand(point, light);
    Quadrature quadrature(integrand);
    std::vector<Cell> cells;
    quadrature.start({0, 1, 0, 1, 0, 0, false}, 0, cells);
    double value = 0, error = 0;
    for (Cell& cell : cells) {
        quadrature.measure(cell);
        value += cell.value;
        error += cell.error;
    }
    std::priority_queue<Cell> queue(std::less<Cell>(), std::move(cells));
    constexpr std::size_t most_cells = 200'000;
    while (!queue.empty() && error > relative_error * value && queue.size() < most_cells) {
        const Cell worst = queue.top();
        queue.pop();
        auto [first, second] = Quadrature::halves(worst, worst.split_a);
        quadrature.measure(first);
        quadrature.measure(second);
        value += first.value + second.value - worst.value;
        error += first.error + second.error - worst.error;
        queue.push(first);
        queue.push(second);
    }
    // Summed anew: the running sums have gathered rounding.
    value = error = 0;
    for (; !queue.empty(); queue.pop()) {
        value += queue.top().value;
        error += queue.top().error;
    }
    return {value, error, quadrature.evaluations()};
}

}  // namespace togishi
