#include "fit/start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/order_statistics.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;

struct Curve {
    double turn_rad = 0;
    double mu_eff_deg = 0;  // half width of the facet angle
    double offset_deg = 0;  // of the peak from the mirror direction, as a tilt
    double height = 0;
};

double low_level(const FitProblem& problem, std::size_t channel) {
    std::vector<double> values;
    for (std::size_t i = channel; i < problem.readings(); i += problem.channels()) {
        if (problem.state[i] == ReadingState::used) values.push_back(problem.measured()[i]);
    }
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 20);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// Peak and half width of one scan's first channel, in its plane. A single spike is no peak: medians
// of three.
Curve curve_of(const Scan& scan, std::size_t channels, double floor) {
    std::vector<double> angle, value;
    for (std::size_t i = 0; i < scan.rows.size(); ++i) {
        const double v = scan.intensity[i * channels];
        if (!std::isfinite(v) || std::abs(scan.rows[i].azimuth_deg) > 1e-6) continue;
        angle.push_back(scan.rows[i].receive_deg);
        value.push_back(v);
    }
    Curve curve;
    curve.turn_rad = scan.turn_deg * rad_per_deg;
    if (angle.size() < 3) return curve;
    std::vector<double> smooth = value;
    for (std::size_t i = 1; i + 1 < value.size(); ++i) {
        smooth[i] = std::max(std::min(value[i - 1], value[i]),
                             std::min(std::max(value[i - 1], value[i]), value[i + 1]));
    }
    const auto top =
        static_cast<std::size_t>(std::max_element(smooth.begin(), smooth.end()) - smooth.begin());
    curve.height = smooth[top] - floor;
    if (!(curve.height > 0)) return curve;
    const double half = floor + 0.5 * curve.height;
    const auto crossing = [&](int direction) {
        auto i = static_cast<std::ptrdiff_t>(top);
        const auto last = static_cast<std::ptrdiff_t>(angle.size()) - 1;
        while (i + direction >= 0 && i + direction <= last) {
            const auto from = static_cast<std::size_t>(i),
                       to = static_cast<std::size_t>(i + direction);
            if (smooth[to] < half) {
                const double t =
                    (smooth[from] - half) / std::max(smooth[from] - smooth[to], 1e-300);
                return angle[from] + t * (angle[to] - angle[from]);
            }
            i += direction;
        }
        return std::numeric_limits<double>::quiet_NaN();
    };
    const double left = crossing(-1), right = crossing(1);
    double width = right - left;
    if (std::isnan(left)) width = 2 * (right - angle[top]);
    if (std::isnan(right)) width = 2 * (angle[top] - left);
    if (!std::isfinite(width) || width <= 0) width = 0.5 * (angle.back() - angle.front());
    const double middle = std::isnan(left) || std::isnan(right) ? angle[top] : 0.5 * (left + right);
    // The receive angle turns twice as far as the facet; source and detector widen in squares.
    const double blur =
        std::hypot(scan.source_aperture_deg, scan.detector_aperture_deg) / 8 * 1.1774;
    const double seen = width / 4;
    curve.mu_eff_deg = std::sqrt(std::max(seen * seen - blur * blur, 0.04 * seen * seen));
    curve.mu_eff_deg = std::clamp(curve.mu_eff_deg, 0.005, 60.0);
    curve.offset_deg = 0.5 * (middle - scan.incidence_deg);
    return curve;
}

struct LobeStart {
    double ln_mu_deg = 0, e_along = 0, e_across = 0;
};

// The ellipse of half widths through the curves', in the axes of the first scan.
LobeStart lobe_through(const std::vector<Curve>& curves, double axis_rad, bool round) {
    std::vector<double> widths;
    for (const Curve& c : curves) {
        if (c.height > 0) widths.push_back(c.mu_eff_deg);
    }
    LobeStart start;
    if (widths.empty()) return start;
    start.ln_mu_deg = std::log(median(widths));
    if (round) return start;
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const Curve& c : curves) {
        if (c.height <= 0) continue;
        const double psi = -c.turn_rad - axis_rad;
        // Relative errors of the half widths are alike: scaled by the squared half width.
        const double w = c.mu_eff_deg * c.mu_eff_deg;
        const Eigen::Vector3d row(w * std::cos(psi) * std::cos(psi),
                                  w * 2 * std::cos(psi) * std::sin(psi),
                                  w * std::sin(psi) * std::sin(psi));
        h += row * row.transpose();
        g += row;
    }
    // Towards a round lobe where a direction was not cut.
    const double mean = std::exp(-2 * start.ln_mu_deg), pull = 1e-4 * h.trace();
    const Eigen::Vector3d around(mean, 0, mean);
    const Eigen::Vector3d form =
        (h + pull * Eigen::Matrix3d::Identity()).ldlt().solve(g + pull * around);
    Eigen::Matrix2d m;
    m << form[0], form[1], form[1], form[2];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(m);
    const double narrow = eigen.eigenvalues()(1);
    const double wide = std::max(eigen.eigenvalues()(0), 1e-3 * narrow);
    if (!(narrow > 0)) return start;
    const double r = 0.25 * std::log(narrow / wide);
    const Eigen::Vector2d axis = eigen.eigenvectors().col(0);
    const double rho = std::atan2(axis.y(), axis.x());
    start.ln_mu_deg = -0.25 * std::log(narrow * wide);
    start.e_along = r * std::cos(2 * rho);
    start.e_across = r * std::sin(2 * rho);
    return start;
}

}  // namespace

namespace {

bool has_reading(const Scan& scan) {
    return std::any_of(scan.intensity.begin(), scan.intensity.end(),
                       [](double v) { return std::isfinite(v); });
}

}  // namespace

int lobe_directions(const ScanSet& scans) {
    std::set<long> directions;
    for (const Scan& scan : scans.scans) {
        if (!has_reading(scan)) continue;
        std::set<long> azimuths;
        for (const ScanRow& row : scan.rows) azimuths.insert(std::lround(row.azimuth_deg));
        constexpr std::size_t enough = 3;
        if (azimuths.size() >= enough) return 3;
        const double turn = scan.turn_deg - 180 * std::floor(scan.turn_deg / 180 + 1e-9);
        // Directions closer than three degrees are one.
        directions.insert(std::lround(turn / 3) % 60);
    }
    return static_cast<int>(std::min<std::size_t>(directions.size(), 3));
}

bool turned(const ScanSet& scans) {
    for (const Scan& scan : scans.scans) {
        const double by = std::remainder(scan.turn_deg - scans.scans.front().turn_deg, 360.0);
        constexpr double far_enough = 30;
        if (std::abs(by) > far_enough && has_reading(scan)) return true;
    }
    return false;
}

bool shows_both_tilts(const ScanSet& scans) {
    if (lobe_directions(scans) >= 3) return true;
    const Scan* first = nullptr;
    for (const Scan& scan : scans.scans) {
        if (!has_reading(scan)) continue;
        if (first == nullptr) first = &scan;
        const double by = (scan.turn_deg - first->turn_deg) * rad_per_deg;
        constexpr double well_across = 0.4;  // sine: 24 degrees
        if (std::abs(std::sin(by)) > well_across) return true;
    }
    return false;
}

void set_height(const FitProblem& problem, FitParameters& p) {
    p.shared[index_ln_weight] = 0;
    const std::size_t channels = problem.channels();
    p.shared.tail(static_cast<Eigen::Index>(channels)).setZero();
    const std::vector<double> shape = problem.modelled(p);
    std::vector<double> floor;
    for (std::size_t c = 0; c < channels; ++c) floor.push_back(low_level(problem, c));
    double vv = 0, vy = 0;
    for (std::size_t first = 0; first < shape.size(); first += channels) {
        for (std::size_t c = 0; c < channels; ++c) {
            const std::size_t i = first + c;
            if (problem.state[i] != ReadingState::used) continue;
            vv += shape[i] * shape[i];
            vy += shape[i] * (problem.measured()[i] - floor[c]);
        }
    }
    p.shared[index_ln_weight] = std::log(vv > 0 && vy > 0 ? vy / vv : 1e-6);
    for (std::size_t c = 0; c < channels; ++c)
        p.shared[index_pedestal + static_cast<int>(c)] = floor[c];
}

std::vector<FitParameters> starting_points(const ScanSet& scans, const FitProblem& problem,
                                           int count) {
    const double floor = low_level(problem, 0) * problem.scale();
    std::vector<Curve> curves;
    for (const Scan& scan : scans.scans)
        curves.push_back(curve_of(scan, scans.channels.size(), floor));
    // Tilts by least squares from where the peaks lie; only for peaks that are narrow enough to
    // tell.
    Eigen::Matrix2d h = 1e-6 * Eigen::Matrix2d::Identity();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    const double axis = problem.axis_rad();
    for (const Curve& c : curves) {
        constexpr double widest = 3;
        if (c.height <= 0 || c.mu_eff_deg > widest) continue;
        const double psi = -c.turn_rad - axis;
        const Eigen::Vector2d row(std::cos(psi), std::sin(psi));
        h += row * row.transpose();
        g += row * c.offset_deg;
    }
    const Eigen::Vector2d tilt = h.ldlt().solve(g) * rad_per_deg;

    struct Variant {
        double widen;
        bool round;
        double turn_deg;
    };
    constexpr Variant variants[] = {
        {1, false, 0},   {0.7, false, 0},  {1.4, false, 0}, {1, true, 0},
        {0.4, false, 0}, {2.5, false, 0},  {1, false, 90},  {0.5, true, 0},
        {2, true, 0},    {0.25, false, 0}, {4, false, 0},   {1, false, 45},
        {1, false, 135}, {0.15, true, 0},  {6, true, 0},    {0.7, false, 90}};
    std::vector<FitParameters> starts;
    for (int i = 0; i < count; ++i) {
        const Variant& v = variants[static_cast<std::size_t>(i) % std::size(variants)];
        // Beyond the list: the same again, half as far.
        const int round_of_list = i / static_cast<int>(std::size(variants));
        const double widen = std::pow(v.widen, 1.0 / (1 + round_of_list));
        const LobeStart lobe = lobe_through(curves, axis, v.round);
        FitParameters p = problem.start();
        p.shared[index_ln_mu_deg] = lobe.ln_mu_deg + std::log(widen);
        const double turn = 2 * v.turn_deg * rad_per_deg;
        p.shared[index_e_along] = std::cos(turn) * lobe.e_along - std::sin(turn) * lobe.e_across;
        p.shared[index_e_across] = std::sin(turn) * lobe.e_along + std::cos(turn) * lobe.e_across;
        p.shared[index_tilt_along] = tilt[0];
        p.shared[index_tilt_across] = tilt[1];
        starts.push_back(std::move(p));
    }
    return starts;
}

}  // namespace togishi
