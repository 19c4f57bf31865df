// Fits of simulated scans: what is recovered, what is said of hopeless data, and never a NaN.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "fit/fit.hpp"
#include "fit/unseen_tilt.hpp"
#include "scan/scan_file.hpp"
#include "scan/simulate_scan.hpp"

namespace togishi {
namespace {

Material measured(double mu_t_deg, double mu_b_deg, double rho_deg, double weight) {
    Material m = default_material();
    m.weights = Weights::measured;
    for (const MaterialLobeField& field : material_lobes) (m.*field.member).weight = 1;
    m.ji = m.ha = {mu_t_deg, mu_b_deg, rho_deg, weight};
    return m;
}

SimulationOptions options(const std::string& protocol) {
    SimulationOptions o;
    o.protocol = scan_protocol(protocol);
    o.channels = {"intensity_550nm"};
    o.pedestal = 0.01;
    return o;
}

const FitParameter& of(const Fit& fit, const std::string& name) {
    for (const FitParameter& p : fit.record.parameters) {
        if (p.name == name) return p;
    }
    throw std::runtime_error("no parameter " + name);
}

void expect_finite(const Fit& fit, const std::string& what) {
    for (const FitParameter& p : fit.record.parameters) {
        EXPECT_TRUE(std::isfinite(p.value) && std::isfinite(p.sigma) && p.sigma >= 0)
            << what << " " << p.name;
        EXPECT_TRUE(p.determined || !p.reason.empty()) << what << " " << p.name;
    }
    for (const auto& row : fit.record.correlations) {
        for (const double c : row) EXPECT_TRUE(std::abs(c) <= 1) << what;
    }
    for (const FittedScan& scan : fit.fitted) {
        for (const double v : scan.modelled) EXPECT_TRUE(std::isfinite(v)) << what;
        for (const double v : scan.residual_sigma) EXPECT_TRUE(std::isfinite(v)) << what;
        EXPECT_TRUE(std::isfinite(scan.mu_eff_deg) && std::isfinite(scan.gain_sigma)) << what;
    }
    EXPECT_TRUE(std::isfinite(fit.record.chi2_reduced)) << what;
    // What the material's reader must take.
    const Material m = material_from_fits({&fit}, default_material(), "fitted");
    EXPECT_EQ(material_from_toml(material_to_toml(m), what), m);
}

std::string refusal(const ScanSet& scans, const FitOptions& o = {}) {
    try {
        (void)fit_scans(scans, o);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(Fit, RecoversWithinItsOwnIntervals) {
    struct Case {
        double mu_t, mu_b, rho;
        ScanPart part;
        const char* protocol;
    };
    for (const Case& c :
         {Case{8, 5, 30, ScanPart::hamon, "a"}, Case{0.5, 0.3, 160, ScanPart::hamon, "a"},
          Case{1, 1, 0, ScanPart::ji, "b"}}) {
        SimulationOptions o = options(c.protocol);
        o.tilt_t_deg = 0.12;
        if (std::string(c.protocol) == "a") o.tilt_b_deg = -0.09;
        const Fit fit = fit_scans(simulate_scan(measured(c.mu_t, c.mu_b, c.rho, 40), c.part, o));
        expect_finite(fit, c.protocol);
        const auto near = [&](const std::string& name, double truth, double bound) {
            const FitParameter& p = of(fit, name);
            EXPECT_NEAR(p.value, truth, std::min(bound, 4 * p.sigma)) << name << " of " << c.mu_t;
            EXPECT_TRUE(p.determined) << name;
        };
        near("mu_t_deg", c.mu_t, 0.005 * c.mu_t);
        near(c.part == ScanPart::ji ? "chi" : "beta", 40, 0.8);
        near("tilt_t_deg", 0.12, 0.02);
        EXPECT_NEAR(fit.record.chi2_reduced, 1, 0.15);
        EXPECT_NEAR(fit.record.noise_relative, 0.005, 0.001);
        EXPECT_EQ(fit.record.outliers, 0);
        if (c.mu_t != c.mu_b) {
            near("mu_b_deg", c.mu_b, 0.005 * c.mu_b);
            near("rho_deg", c.rho, 0.3);
            near("tilt_b_deg", -0.09, 0.02);
        } else {
            EXPECT_EQ(of(fit, "rho_deg").reason, "no_azimuth_coverage");
            EXPECT_EQ(of(fit, "tilt_b_deg").reason, "not_turned");
        }
    }
}

TEST(Fit, SaysAspectOneInsteadOfAnAngle) {
    const Fit fit = fit_scans(simulate_scan(measured(3, 3, 0, 40), ScanPart::hamon, options("a")));
    EXPECT_EQ(of(fit, "mu_t_deg").value, of(fit, "mu_b_deg").value);
    EXPECT_FALSE(of(fit, "rho_deg").determined);
    EXPECT_EQ(of(fit, "rho_deg").reason, "isotropic");
}

TEST(Fit, ASecondLobeIsFoundWhereThereIsOne) {
    SimulationOptions o = options("a");
    o.haze_share = 0.04;
    o.haze_width = 3;
    const Fit fit = fit_scans(simulate_scan(measured(2, 1.5, 20, 40), ScanPart::hamon, o));
    EXPECT_NEAR(of(fit, "haze_share").value, 0.04, 0.005);
    EXPECT_NEAR(of(fit, "haze_width").value, 3, 0.2);
    EXPECT_NEAR(of(fit, "mu_t_deg").value, 2, 0.01);
    const Fit plain =
        fit_scans(simulate_scan(measured(2, 1.5, 20, 40), ScanPart::hamon, options("a")));
    EXPECT_THROW((void)of(plain, "haze_share"), std::runtime_error);
}

TEST(Fit, OutliersAreLeftOutAndSaid) {
    SimulationOptions o = options("a");
    o.outlier_share = 0.02;
    const Fit fit = fit_scans(simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, o));
    EXPECT_GT(fit.record.outliers, 8);
    EXPECT_LT(fit.record.outliers, 30);
    EXPECT_NEAR(of(fit, "mu_t_deg").value, 8, 0.05);
    EXPECT_NEAR(of(fit, "mu_b_deg").value, 5, 0.03);
}

TEST(Fit, WrongReadingsAtTheTopOfTheRangeAreNoPeak) {
    // Sparks far from the peak reach the clipping level, too: as lower bounds they would weigh more
    // than all others together.
    SimulationOptions o = options("a");
    o.saturation = 0.7;
    o.outlier_share = 0.02;
    for (const std::uint64_t seed : {1U, 5U, 10U}) {
        o.seed = seed;
        const Fit fit = fit_scans(simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, o));
        EXPECT_GT(fit.record.outliers, 8);
        EXPECT_GT(fit.record.clipped, 200);
        EXPECT_NEAR(of(fit, "mu_t_deg").value, 8, 4 * of(fit, "mu_t_deg").sigma) << seed;
        EXPECT_NEAR(of(fit, "mu_b_deg").value, 5, 4 * of(fit, "mu_b_deg").sigma) << seed;
        EXPECT_LT(of(fit, "mu_t_deg").sigma, 0.05);
        for (const FittedScan& scan : fit.fitted) EXPECT_NEAR(scan.gain, 1, 0.05) << seed;
    }
}

TEST(Fit, ReadingsOutOfThePlaneShowTheWholeLobe) {
    // One position of the sample, the detector led around the mirror direction.
    SimulationOptions o = options("a");
    o.protocol.turns_deg = {0};
    o.protocol.azimuths_deg = {-9, -6, -3, 0, 3, 6, 9};
    o.protocol.receive_first_deg = 35;
    o.protocol.receive_last_deg = 55;
    o.protocol.step_deg = 0.5;
    o.tilt_t_deg = 0.12;
    o.tilt_b_deg = -0.09;
    const ScanSet simulated = simulate_scan(measured(2, 1.2, 35, 40), ScanPart::hamon, o);
    const ScanSet scans = parse_scans(scans_to_text(simulated), "out_of_plane.csv");
    ASSERT_EQ(scans.scans.size(), 1U);
    ASSERT_EQ(scans.rows(), 7U * 41U);
    const Fit fit = fit_scans(scans);
    expect_finite(fit, "out of plane");
    const auto near = [&](const std::string& name, double truth, double bound) {
        const FitParameter& p = of(fit, name);
        EXPECT_TRUE(p.determined) << name;
        EXPECT_NEAR(p.value, truth, std::min(bound, 4 * p.sigma)) << name;
    };
    near("mu_t_deg", 2, 0.02);
    near("mu_b_deg", 1.2, 0.012);
    near("rho_deg", 35, 0.5);
    near("beta", 40, 1.6);
    near("tilt_t_deg", 0.12, 0.01);
    near("tilt_b_deg", -0.09, 0.01);
}

TEST(Fit, AnUnseenTiltIsPartOfTheWeightsInterval) {
    // 0.1 degrees across the plane lower a peak of 0.3 degrees by 8 %, and nothing else.
    SimulationOptions o = options("b");
    o.tilt_b_deg = 0.1;
    FitOptions exact;
    exact.unseen_tilt_deg = 0;
    const ScanSet scans = simulate_scan(measured(0.3, 0.3, 0, 40), ScanPart::ji, o);
    const Fit known = fit_scans(scans, exact), fit = fit_scans(scans);
    EXPECT_NEAR(of(known, "chi").value, 40 * std::exp(-std::log(2.0) * 0.01 / 0.09), 0.5);
    EXPECT_LT(of(known, "chi").sigma, 0.005 * 40);
    // The interval leads from the fitted height upwards, by what the stated tilt may have taken
    // off.
    const FitParameter& chi = of(fit, "chi");
    EXPECT_EQ(chi.reason, "not_turned");
    EXPECT_NEAR(chi.value - chi.sigma, of(known, "chi").value, 2 * of(known, "chi").sigma);
    EXPECT_NEAR(chi.value + chi.sigma,
                of(known, "chi").value * std::exp(std::log(2.0) * 0.0064 / 0.09), 0.5);
    EXPECT_EQ(of(fit, "mu_t_deg").value, of(known, "mu_t_deg").value);
    EXPECT_NEAR(of(fit, "mu_t_deg").value, 0.3, 0.001);
    EXPECT_NEAR(of(fit, "tilt_b_deg").sigma, 0.08, 1e-12);
    // Turned by 90 degrees it shows; turned by 180 it does not.
    o.protocol.turns_deg = {0, 90};
    const Fit turned = fit_scans(simulate_scan(measured(0.3, 0.3, 0, 40), ScanPart::ji, o));
    EXPECT_NEAR(of(turned, "chi").value, 40, 4 * of(turned, "chi").sigma);
    EXPECT_NEAR(of(turned, "tilt_b_deg").value, 0.1, 0.005);
    o.protocol.turns_deg = {0, 180};
    const Fit reversed = fit_scans(simulate_scan(measured(0.3, 0.3, 0, 40), ScanPart::ji, o));
    EXPECT_EQ(of(reversed, "chi").reason, "not_turned");
    EXPECT_FALSE(of(reversed, "tilt_b_deg").determined);
}

TEST(Fit, TheIntervalWithAnUnseenTiltHoldsItsShare) {
    EXPECT_NEAR(interval_with_drop(0.3, 0).half, 0.3, 1e-12);
    EXPECT_NEAR(interval_with_drop(1e-9, 0.4).middle, 0.2, 1e-6);
    RandomNormal random(4);
    for (const double drop : {0.02, 0.3, 1.0, 5.0, 50.0}) {
        const Interval interval = interval_with_drop(1, drop);
        constexpr int trials = 40'000;
        int held = 0;
        for (int i = 0; i < trials; ++i) {
            const double z = random.normal();
            const double x = random.normal() + drop * z * z;
            held += std::abs(x - interval.middle) <= interval.half ? 1 : 0;
        }
        EXPECT_NEAR(static_cast<double>(held) / trials, 0.6827, 0.01) << drop;
    }
}

TEST(Fit, AClippedPeakIsTakenAsALowerBound) {
    SimulationOptions o = options("a");
    o.saturation = 0.7;
    for (const bool stated : {true, false}) {
        ScanSet scans = simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, o);
        if (!stated) {
            for (Scan& scan : scans.scans)
                scan.saturation = std::numeric_limits<double>::infinity();
        }
        const Fit fit = fit_scans(scans);
        EXPECT_GT(fit.record.clipped, 20);
        EXPECT_EQ(of(fit, "beta").reason, "clipped_peak");
        EXPECT_NEAR(of(fit, "mu_t_deg").value, 8, 0.1);
        EXPECT_NEAR(of(fit, "beta").value, 40, 1.2);
    }
}

TEST(Fit, TheMetalIsToldByItsColour) {
    SimulationOptions o = options("b");
    o.channels = {"intensity_r", "intensity_g", "intensity_b"};
    Material m = measured(1, 1, 0, 40);
    m.metal = "copper_johnson_christy";
    FitOptions choose;
    choose.metal = "auto";
    const Fit fit = fit_scans(simulate_scan(m, ScanPart::ji, o), choose);
    EXPECT_EQ(fit.record.metal, "copper_johnson_christy");
    ASSERT_GT(fit.record.metals.size(), 3U);
    EXPECT_GT(fit.record.metals[1].second, 20);
}

TEST(Fit, StiffAndHopelessData) {
    for (const double mu : {0.05, 0.2, 20.0}) {
        for (const double aspect : {1.0, 20.0}) {
            if (mu / aspect < 0.04) continue;
            const Fit fit = fit_scans(
                simulate_scan(measured(mu, mu / aspect, 35, 40), ScanPart::hamon, options("a")));
            expect_finite(fit, "mu " + std::to_string(mu) + " aspect " + std::to_string(aspect));
            const FitParameter& p = of(fit, "mu_t_deg");
            EXPECT_TRUE(!p.determined || std::abs(p.value - mu) < 0.1 * mu)
                << mu << " " << aspect << ": " << p.value;
        }
    }
    SimulationOptions o = options("a");
    ScanSet scans = simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, o);
    scans.scans[1].intensity[70] = std::nan("");
    scans.scans[2].intensity[70] = INFINITY;
    expect_finite(fit_scans(scans), "one NaN");
    std::fill(scans.scans[1].intensity.begin(), scans.scans[1].intensity.end(), 0.0);
    const Fit without = fit_scans(scans);
    expect_finite(without, "a scan of zeros");
    EXPECT_EQ(of(without, "mu_b_deg").reason, "no_azimuth_coverage");
    EXPECT_EQ(of(without, "tilt_b_deg").reason, "no_azimuth_coverage");
    for (const double level : {1.0, 0.0, -2.0}) {
        for (Scan& scan : scans.scans)
            std::fill(scan.intensity.begin(), scan.intensity.end(), level);
        EXPECT_NE(refusal(scans).find("intensity"), std::string::npos) << level;
    }
    o.protocol.turns_deg = {0};
    o.protocol.step_deg = 10;
    scans = simulate_scan(measured(8, 8, 0, 40), ScanPart::hamon, o);
    ASSERT_EQ(scans.readings(), 5U);
    expect_finite(fit_scans(scans), "five points");
    scans.scans[0].intensity[1] = scans.scans[0].intensity[3] = std::nan("");
    EXPECT_NE(refusal(scans).find("as many as parameters"), std::string::npos);
}

TEST(Fit, OptionsAreChecked) {
    const ScanSet scans = simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, options("a"));
    FitOptions o;
    o.starts = 0;
    EXPECT_NE(refusal(scans, o).find("starts"), std::string::npos);
    o = {};
    o.gain_prior = std::nan("");
    EXPECT_NE(refusal(scans, o).find("gain_prior"), std::string::npos);
    o = {};
    o.metal = "unobtainium";
    EXPECT_NE(refusal(scans, o).find("unobtainium"), std::string::npos);
    EXPECT_THROW((void)fit_scans(scans, {}, [](double done) { return done < 0.4; }), FitCancelled);
}

TEST(Fit, RelativeWeightsStayOutOfTheMaterial) {
    SimulationOptions o = options("a");
    o.calibration = ScanCalibration::relative;
    const Fit fit = fit_scans(simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, o));
    EXPECT_EQ(of(fit, "beta").unit, "relative");
    const Material m = material_from_fits({&fit}, default_material(), "relative");
    EXPECT_EQ(m.weights, Weights::normalised);
    EXPECT_NEAR(m.ha.mu_t_deg, 8, 0.05);
    o.calibration = ScanCalibration::per_scan;
    const Fit each = fit_scans(simulate_scan(measured(8, 5, 30, 40), ScanPart::hamon, o));
    EXPECT_NEAR(of(each, "mu_b_deg").value, 5, 0.05);
}

TEST(Fit, CurvesAreTheModelOfTheFit) {
    const Fit fit =
        fit_scans(simulate_scan(measured(2, 0.5, 70, 40), ScanPart::hamon, options("a")));
    for (std::size_t s = 0; s < fit.scans.scans.size(); ++s) {
        std::vector<double> angles;
        for (const ScanRow& row : fit.scans.scans[s].rows) angles.push_back(row.receive_deg);
        const std::vector<double> curve = modelled_curve(fit, s, angles);
        ASSERT_EQ(curve.size(), fit.fitted[s].modelled.size());
        for (std::size_t i = 0; i < curve.size(); ++i)
            EXPECT_NEAR(curve[i], fit.fitted[s].modelled[i], 1e-9 * std::abs(curve[i]) + 1e-12);
        EXPECT_NEAR(fit.fitted[s].mu_eff_deg, mu_eff_deg(fit, {fit.scans.scans[s].turn_deg})[0],
                    5 * fit.fitted[s].mu_eff_sigma_deg + 1e-6);
    }
    EXPECT_THROW((void)modelled_curve(fit, 99, {45}), InputError);
    EXPECT_THROW((void)modelled_curve(fit, 0, {std::nan("")}), InputError);
}

}  // namespace
}  // namespace togishi
