#include "scan/simulate_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "brdf/model.hpp"
#include "reference/reference.hpp"
#include "scan/scan_channel.hpp"
#include "scan/scan_file.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;

void check(std::string_view field, double value, double least, double most,
           std::string_view allowed) {
    if (!(value >= least && value <= most)) {
        throw InputError("simulate-scan", field, format_number(value), allowed);
    }
}

void check_angles(std::string_view field, const std::vector<double>& angles, double least,
                  double most) {
    const std::string allowed = format_number(least) + " to " + format_number(most) + " degrees";
    constexpr std::size_t most_angles = 1000;
    if (angles.empty() || angles.size() > most_angles) {
        throw InputError("simulate-scan", field, std::to_string(angles.size()) + " angles",
                         "1 to 1000");
    }
    for (const double angle : angles) check(field, angle, least, most, allowed);
}

void check(const SimulationOptions& o) {
    check_angles("incidences_deg", o.protocol.incidences_deg, 0, 89.9);
    check_angles("turns_deg", o.protocol.turns_deg, -360, 360);
    check_angles("azimuths_deg", o.protocol.azimuths_deg, -90, 90);
    check("receive_first_deg", o.protocol.receive_first_deg, -89.9, 89.9, "-89.9 to 89.9 degrees");
    check("receive_last_deg", o.protocol.receive_last_deg, o.protocol.receive_first_deg, 89.9,
          "receive_first_deg to 89.9 degrees");
    check("step_deg", o.protocol.step_deg, 1e-4, 90, "0.0001 to 90 degrees");
    check("dense_within_deg", o.protocol.dense_within_deg, 0, 180, "0 to 180 degrees");
    check("coarse_step_deg", o.protocol.coarse_step_deg, 1e-4, 90, "0.0001 to 90 degrees");
    check("noise_relative", o.noise_relative, 0, 1, "0 to 1, a share of the signal");
    check("noise_floor", o.noise_floor, 0, 1, "0 to 1, a share of the peak");
    check("gain_error", o.gain_error, 0, 0.3, "0 to 0.3");
    check("source_aperture_deg", o.source_aperture_deg, 0, 20, "0 to 20 degrees");
    check("detector_aperture_deg", o.detector_aperture_deg, 0, 20, "0 to 20 degrees");
    check("pedestal", o.pedestal, 0, 10, "0 to 10, a share of the peak");
    check("tilt_t_deg", o.tilt_t_deg, -10, 10, "-10 to 10 degrees");
    check("tilt_b_deg", o.tilt_b_deg, -10, 10, "-10 to 10 degrees");
    check("receive_offset_deg", o.receive_offset_deg, -10, 10, "-10 to 10 degrees");
    check("out_of_plane_deg", o.out_of_plane_deg, -10, 10, "-10 to 10 degrees");
    check("saturation", o.saturation, 0, 10, "0 (none) to 10, a share of the peak");
    check("haze_share", o.haze_share, 0, 1, "0 to 1, a share of the lobe's height");
    check("haze_width", o.haze_width, 1, 20, "1 to 20 times the lobe's width");
    check("outlier_share", o.outlier_share, 0, 1, "0 to 1");
    constexpr std::size_t most_channels = 64;
    if (o.channels.empty() || o.channels.size() > most_channels) {
        throw InputError("simulate-scan", "channels",
                         std::to_string(o.channels.size()) + " channels", "1 to 64");
    }
}

// A direction of a round aperture, as a displacement across the line of sight, in rad.
struct DiscNode {
    double x, y, share;
};

// Gauss-Legendre in the squared radius, equal steps in the angle.
std::vector<DiscNode> disc_nodes(double full_angle_deg, double narrowest_lobe_rad) {
    const double radius = std::tan(0.5 * full_angle_deg * rad_per_deg);
    if (radius == 0) return {{0, 0, 1}};
    // The half vector moves by half as much as the light, up to 1/cos times that beside the plane.
    const double spread = radius / narrowest_lobe_rad;
    const int rings =
        spread < 0.15 ? 1 : std::min(24, static_cast<int>(std::ceil(1.5 + 1.2 * spread)));
    const int around = 4 * rings + 2;
    std::vector<DiscNode> nodes;
    for (int ring = 0; ring < rings; ++ring) {
        // Newton's method on the Legendre polynomial, from the usual first guess.
        double z = std::cos(std::numbers::pi * (ring + 0.75) / (rings + 0.5));
        double slope = 1;
        for (int step = 0; step < 20; ++step) {
            double before = 1, value = z;
            for (int n = 2; n <= rings; ++n) {
                const double next = ((2 * n - 1) * z * value - (n - 1) * before) / n;
                before = value;
                value = next;
            }
            slope = rings * (z * value - before) / (z * z - 1);
            z -= value / slope;
        }
        const double weight = 1 / ((1 - z * z) * slope * slope);
        const double r = radius * std::sqrt(0.5 * (1 + z));
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * (i + 0.5 * (ring % 2)) / around;
            nodes.push_back({r * std::cos(angle), r * std::sin(angle), weight / around});
        }
    }
    return nodes;
}

// Perpendicular to an axis and out of the plane of incidence.
glm::dvec3 beside(const glm::dvec3& axis) {
    const glm::dvec3 y(0, 1, 0);
    return glm::normalize(y - axis * glm::dot(axis, y));
}

glm::dvec3 displaced(const glm::dvec3& axis, const glm::dvec3& across, const DiscNode& node) {
    return glm::normalize(axis + node.x * glm::cross(across, axis) + node.y * across);
}

std::vector<ScanRow> receive_rows(const ScanProtocol& p, double incidence_deg) {
    std::vector<double> angles;
    const auto sweep = [&](double first, double last, double step, bool dense) {
        const auto count = static_cast<std::int64_t>(std::floor((last - first) / step + 1e-9)) + 1;
        if (count > static_cast<std::int64_t>(scan_file_max_rows)) {
            throw InputError(
                "simulate-scan", "step_deg", format_number(step),
                "steps that make at most " + std::to_string(scan_file_max_rows) + " rows");
        }
        for (std::int64_t i = 0; i < count; ++i) {
            const double angle = std::round((first + static_cast<double>(i) * step) * 1e9) / 1e9;
            const bool near = std::abs(angle - incidence_deg) <= p.dense_within_deg + 1e-9;
            if (dense == near) angles.push_back(angle);
        }
    };
    const double first = p.receive_first_deg, last = p.receive_last_deg;
    // Dense angles are counted from the protocol's first one, so that a step of 0.2 gives tenths.
    sweep(first, last, p.step_deg, true);
    if (p.dense_within_deg < 180) sweep(first, last, p.coarse_step_deg, false);
    std::sort(angles.begin(), angles.end());
    std::vector<double> azimuths = p.azimuths_deg;
    std::sort(azimuths.begin(), azimuths.end());
    if (angles.size() * azimuths.size() > scan_file_max_rows) {
        throw InputError(
            "simulate-scan", "azimuths_deg", std::to_string(azimuths.size()),
            "azimuths that make at most " + std::to_string(scan_file_max_rows) + " rows");
    }
    std::vector<ScanRow> rows;
    rows.reserve(angles.size() * azimuths.size());
    for (const double azimuth : azimuths) {
        for (const double angle : angles) rows.push_back({angle, azimuth, 0});
    }
    return rows;
}

// The sample as it sits on the goniometer: its normal leans, and turns with it.
struct Pose {
    glm::dvec3 normal, tangent;
};

Pose pose_of(double turn_deg, double tilt_t_deg, double tilt_b_deg) {
    const double turn = turn_deg * rad_per_deg;
    const glm::dvec3 t(std::cos(turn), std::sin(turn), 0), b(-std::sin(turn), std::cos(turn), 0);
    const glm::dvec3 normal =
        glm::normalize(glm::dvec3(0, 0, 1) + std::tan(tilt_t_deg * rad_per_deg) * t +
                       std::tan(tilt_b_deg * rad_per_deg) * b);
    return {normal, t};
}

struct LobeOfPart {
    StoredLobe lobe;
    double weight;
    double narrowest_rad;
};

class Simulator {
  public:
    Simulator(const Material& material, ScanPart part, const SimulationOptions& options,
              unsigned threads)
        : material_(material), part_(part), options_(options), threads_(threads) {
        const MaterialLobe& lobe = part == ScanPart::ji ? material.ji : material.ha;
        const f64::Lobe stored = f64::lobe_from_mu(
            lobe.mu_t_deg * rad_per_deg, lobe.mu_b_deg * rad_per_deg, lobe.rho_deg * rad_per_deg);
        const double weight =
            lobe.weight < 0 ? f64::lobe_normalised_weight(f64::lobe_form(stored)) : lobe.weight;
        const double narrowest = lobe.mu_b_deg * rad_per_deg;
        lobes_.push_back({{stored.ln_mu_deg, stored.e1, stored.e2}, weight, narrowest});
        if (options.haze_share > 0) {
            lobes_.push_back(
                {{stored.ln_mu_deg + std::log(options.haze_width), stored.e1, stored.e2},
                 weight * options.haze_share,
                 narrowest});
        }
        source_ = disc_nodes(options.source_aperture_deg, narrowest);
        detector_ = disc_nodes(options.detector_aperture_deg, narrowest);
    }

    // Readings of one channel over one scan, as a perfect detector would show them.
    [[nodiscard]] std::vector<double> readings(const Scan& scan,
                                               const ChannelSpectrum& channel) const {
        const Pose pose = pose_of(scan.turn_deg, options_.tilt_t_deg, options_.tilt_b_deg);
        const double incidence = scan.incidence_deg * rad_per_deg;
        const glm::dvec3 to_light(-std::sin(incidence), 0, std::cos(incidence)), y(0, 1, 0);
        std::vector<glm::dvec3> lights;
        std::vector<std::int32_t> light_of(source_.size(), 0);
        for (const DiscNode& node : source_) lights.push_back(displaced(to_light, y, node));
        std::vector<double> sum(scan.rows.size(), 0.0);
        // Row by row: a wide aperture over a narrow lobe has a million pairs of directions a row.
        const std::size_t views = detector_.size();
        const std::size_t rows_at_once =
            std::max<std::size_t>(1, 400'000 / (views * source_.size()));
        for (std::size_t begin = 0; begin < scan.rows.size(); begin += rows_at_once) {
            const std::size_t end = std::min(scan.rows.size(), begin + rows_at_once);
            const std::size_t points = (end - begin) * views;
            std::vector<glm::dvec3> normal(points, pose.normal), tangent(points, pose.tangent),
                view, light_direction;
            std::vector<double> irradiance;
            for (std::size_t i = begin; i < end; ++i) {
                const glm::dvec3 axis = detector_axis(scan.rows[i]);
                for (const DiscNode& node : detector_) {
                    view.push_back(displaced(axis, beside(axis), node));
                    light_direction.insert(light_direction.end(), lights.begin(), lights.end());
                    for (const DiscNode& from : source_) irradiance.push_back(from.share);
                }
            }
            for (const LobeOfPart& lobe : lobes_) {
                const auto xyz = evaluate(lobe, channel, light_of, normal, tangent, view,
                                          light_direction, irradiance);
                for (std::size_t p = 0; p < points; ++p) {
                    double value =
                        glm::dot(channel.xyz_weights, xyz[p]) * detector_[p % views].share;
                    if (options_.quantity == ScanQuantity::flux)
                        value *= glm::dot(pose.normal, view[p]);
                    if (options_.quantity == ScanQuantity::brdf) value /= std::cos(incidence);
                    sum[begin + p / views] += value;
                }
            }
        }
        return sum;
    }

  private:
    [[nodiscard]] glm::dvec3 detector_axis(const ScanRow& row) const {
        const double r = (row.receive_deg + options_.receive_offset_deg) * rad_per_deg;
        const double a = row.azimuth_deg * rad_per_deg;
        const glm::dvec3 stated(std::sin(r) * std::cos(a), std::sin(r) * std::sin(a), std::cos(r));
        return glm::normalize(stated +
                              std::tan(options_.out_of_plane_deg * rad_per_deg) * beside(stated));
    }
    [[nodiscard]] std::vector<glm::dvec3> evaluate(const LobeOfPart& lobe,
                                                   const ChannelSpectrum& channel,
                                                   const std::vector<std::int32_t>& light_of,
                                                   const std::vector<glm::dvec3>& normal,
                                                   const std::vector<glm::dvec3>& tangent,
                                                   const std::vector<glm::dvec3>& view,
                                                   const std::vector<glm::dvec3>& light_direction,
                                                   const std::vector<double>& irradiance) const {
        const double share_of_hamon = part_ == ScanPart::hamon ? 1 : 0;
        const double none = 0;
        ReferenceScene scene;
        scene.metal = material_.metal;
        scene.lights = {channel.light};
        scene.light_of = light_of;
        scene.normal = normal;
        scene.tangent = tangent;
        scene.view = view;
        scene.light_direction = light_direction;
        scene.irradiance = irradiance;
        scene.lobe_ji.values = {&lobe.lobe, 1};
        scene.lobe_hadori.values = {&lobe.lobe, 1};
        scene.lobe_ha.values = {&lobe.lobe, 1};
        scene.w.values = {&share_of_hamon, 1};
        scene.h.values = {&none, 1};
        scene.chi = lobe.weight;
        scene.beta_hadori = lobe.weight;
        scene.beta_ha = lobe.weight;
        return reference_xyz(scene, threads_);
    }

    const Material& material_;
    ScanPart part_;
    const SimulationOptions& options_;
    unsigned threads_;
    std::vector<LobeOfPart> lobes_;
    std::vector<DiscNode> source_, detector_;
};

// Largest reading of each channel.
std::vector<double> peaks_of(const ScanSet& set) {
    std::vector<double> peaks(set.channels.size(), 0.0);
    for (const Scan& scan : set.scans) {
        for (std::size_t i = 0; i < scan.intensity.size(); ++i) {
            double& peak = peaks[i % peaks.size()];
            peak = std::max(peak, scan.intensity[i]);
        }
    }
    return peaks;
}

void add_instrument(ScanSet& set, const SimulationOptions& o) {
    RandomNormal random(o.seed);
    const std::size_t channels = set.channels.size();
    const std::vector<double> bare = peaks_of(set);
    for (Scan& scan : set.scans) {
        const double gain = std::exp(o.gain_error * random.normal());
        for (std::size_t i = 0; i < scan.intensity.size(); ++i)
            scan.intensity[i] = gain * (scan.intensity[i] + o.pedestal * bare[i % channels]);
    }
    const std::vector<double> peaks = peaks_of(set);
    double clip = std::numeric_limits<double>::infinity();
    if (o.saturation > 0) clip = o.saturation * *std::max_element(peaks.begin(), peaks.end());
    for (Scan& scan : set.scans) {
        for (std::size_t i = 0; i < scan.intensity.size(); ++i) {
            const double peak = peaks[i % channels];
            const double sigma =
                std::hypot(o.noise_relative * scan.intensity[i], o.noise_floor * peak);
            double value = scan.intensity[i] + sigma * random.normal();
            if (o.outlier_share > 0 && random.uniform() < o.outlier_share)
                value += peak * (2 * random.uniform() - 1);
            scan.intensity[i] = std::min(value, clip);
            if (o.state_sigma) scan.sigma.push_back(std::max(sigma, 1e-9 * peak));
        }
        if (o.saturation > 0) scan.saturation = clip;
    }
}

// In which unit a relative calibration comes out: the peak, of all or of each scan, reads 100.
void rescale(ScanSet& set, double scale_of_all) {
    for (Scan& scan : set.scans) {
        double scale = scale_of_all;
        if (set.calibration == ScanCalibration::per_scan)
            scale = *std::max_element(scan.intensity.begin(), scan.intensity.end());
        if (!(scale > 0)) continue;
        for (double& v : scan.intensity) v *= 100 / scale;
        for (double& v : scan.sigma) v *= 100 / scale;
        scan.saturation *= 100 / scale;
    }
}

}  // namespace

ScanProtocol scan_protocol(const std::string& name) {
    ScanProtocol p;
    if (name == "a") {
        p.incidences_deg = {45};
        p.turns_deg = {0, 45, 135, 180};
    } else if (name == "b") {
        p.incidences_deg = {15, 25, 35, 45, 55, 65};
        p.turns_deg = {0};
        p.receive_first_deg = 10;
        p.receive_last_deg = 80;
        p.dense_within_deg = 20;
    } else {
        throw InputError("simulate-scan", "protocol", "\"" + name + "\"", "a or b");
    }
    return p;
}

ScanSet simulate_scan(const Material& material, ScanPart part, const SimulationOptions& options,
                      unsigned threads) {
    check(options);
    ScanSet set;
    set.part = part;
    set.calibration = options.calibration;
    set.unit = options.calibration == ScanCalibration::absolute ? "1/sr" : "relative";
    set.metal = material.metal;
    set.light = options.light;
    set.name = "simulated: " + material.name;
    std::vector<ChannelSpectrum> sums;
    for (const std::string& title : options.channels) {
        const auto channel = parse_channel(title);
        if (!channel) {
            throw InputError("simulate-scan", "channels", "\"" + title + "\"",
                             "intensity, intensity_x|_y|_z|_r|_g|_b, intensity_550nm (400 to 700)");
        }
        set.channels.push_back(*channel);
        sums.push_back(channel_spectrum(*channel, options.light));
    }
    const Simulator simulator(material, part, options, threads);
    for (const double turn : options.protocol.turns_deg) {
        for (const double incidence : options.protocol.incidences_deg) {
            Scan scan;
            scan.file = "simulated";
            scan.incidence_deg = incidence;
            scan.turn_deg = turn < 0 ? turn + 360 : turn;
            scan.quantity = options.quantity;
            scan.source_aperture_deg = options.source_aperture_deg;
            scan.detector_aperture_deg = options.detector_aperture_deg;
            scan.rows = receive_rows(options.protocol, incidence);
            scan.intensity.resize(scan.rows.size() * sums.size());
            for (std::size_t c = 0; c < sums.size(); ++c) {
                const std::vector<double> readings = simulator.readings(scan, sums[c]);
                for (std::size_t i = 0; i < readings.size(); ++i)
                    scan.intensity[i * sums.size() + c] = readings[i];
            }
            set.scans.push_back(std::move(scan));
        }
    }
    if (set.rows() == 0)
        throw InputError("simulate-scan", "protocol", "without a row", "at least one angle");
    add_instrument(set, options);
    if (options.calibration != ScanCalibration::absolute) {
        const std::vector<double> peaks = peaks_of(set);
        rescale(set, *std::max_element(peaks.begin(), peaks.end()));
    }
    set.inputs.push_back({"simulated", std::string(64, '0')});
    return set;
}

}  // namespace togishi
