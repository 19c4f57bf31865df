// The model of a reading in the fit: its derivatives, its average over the aperture, its agreement
// with the reference; and the fingerprint of inputs.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

// Eigen is the fit's own business; its headers come with the problem's.
#include "base/sha256.hpp"
#include "fit/aperture.hpp"
#include "fit/problem.hpp"
#include "scan/simulate_scan.hpp"

namespace togishi {
namespace {

Material measured(double mu_t_deg, double mu_b_deg, double rho_deg) {
    Material m = default_material();
    m.weights = Weights::measured;
    for (const MaterialLobeField& field : material_lobes) (m.*field.member).weight = 1;
    m.ji = {mu_t_deg, mu_b_deg, rho_deg, 3.5};
    m.ha = {mu_t_deg, mu_b_deg, rho_deg, 3.5};
    return m;
}

SimulationOptions quiet() {
    SimulationOptions o;
    o.noise_relative = o.noise_floor = o.gain_error = 0;
    o.channels = {"intensity_550nm"};
    return o;
}

FitParameters parameters_of(const FitProblem& problem, const MaterialLobe& lobe,
                            const SimulationOptions& o) {
    constexpr double rad = 0.017453292519943295769;
    FitParameters p = problem.start();
    const double r = 0.5 * std::log(lobe.mu_t_deg / lobe.mu_b_deg),
                 rho = lobe.rho_deg * rad - problem.axis_rad();
    p.shared[index_ln_weight] = std::log(lobe.weight / problem.scale());
    p.shared[index_ln_mu_deg] = 0.5 * std::log(lobe.mu_t_deg * lobe.mu_b_deg);
    p.shared[index_e_along] = r * std::cos(2 * rho);
    p.shared[index_e_across] = r * std::sin(2 * rho);
    p.shared[index_tilt_along] = o.tilt_t_deg * rad;
    p.shared[index_tilt_across] = o.tilt_b_deg * rad;
    p.shared[index_receive] = o.receive_offset_deg * rad;
    p.shared[index_out_of_plane] = o.out_of_plane_deg * rad;
    return p;
}

TEST(FitModel, AgreesWithTheReference) {
    struct Case {
        double mu_t, mu_b, aperture;
        ScanPart part;
        ScanQuantity quantity;
    };
    for (const Case& c : {Case{8, 5, 0, ScanPart::hamon, ScanQuantity::radiance},
                          Case{8, 5, 0.2, ScanPart::ji, ScanQuantity::flux},
                          Case{0.5, 0.3, 0.2, ScanPart::hamon, ScanQuantity::brdf},
                          Case{0.3, 0.3, 0.2, ScanPart::ji, ScanQuantity::radiance},
                          Case{0.06, 0.05, 0.2, ScanPart::ji, ScanQuantity::radiance}}) {
        SimulationOptions o = quiet();
        o.source_aperture_deg = c.aperture;
        o.detector_aperture_deg = 0.5 * c.aperture;
        o.quantity = c.quantity;
        o.tilt_t_deg = 0.13;
        o.tilt_b_deg = -0.07;
        o.receive_offset_deg = 0.05;
        o.out_of_plane_deg = 0.04;
        const Material m = measured(c.mu_t, c.mu_b, 27);
        const ScanSet scans = simulate_scan(m, c.part, o);
        FitProblem problem(scans, true);
        problem.reflectance =
            std::make_shared<const ReflectanceTable>(scans.metal, scans.light, scans.channels);
        const FitParameters p = parameters_of(problem, c.part == ScanPart::ji ? m.ji : m.ha, o);
        problem.set_aperture_for(p);
        const std::vector<double> modelled = problem.modelled(p);
        double worst = 0;
        for (std::size_t i = 0; i < modelled.size(); ++i)
            worst = std::max(worst, std::abs(modelled[i] - problem.measured()[i]));
        // Of the peak; where the aperture is four times the lobe, the quadrature shows.
        EXPECT_LT(worst, c.mu_b < 0.1 ? 1.5e-4 : 5e-5)
            << c.mu_t << "/" << c.mu_b << " aperture " << c.aperture;
    }
}

TEST(FitModel, DerivativesAreThoseOfDifferences) {
    SimulationOptions o = quiet();
    o.protocol.step_deg = 1.3;
    o.protocol.turns_deg = {30, 75, 190};
    const Material m = measured(3, 2, 40);
    for (const ScanPart part : {ScanPart::ji, ScanPart::hamon}) {
        for (const ScanQuantity quantity : {ScanQuantity::radiance, ScanQuantity::flux}) {
            o.quantity = quantity;
            const ScanSet scans = simulate_scan(m, part, o);
            FitProblem problem(scans, true);
            problem.haze = true;
            problem.reflectance =
                std::make_shared<const ReflectanceTable>(scans.metal, scans.light, scans.channels);
            FitParameters p = parameters_of(problem, m.ha, o);
            p.shared[index_tilt_along] = 0.01;
            p.shared[index_tilt_across] = -0.02;
            p.shared[index_receive] = 0.003;
            p.shared[index_out_of_plane] = 0.005;
            p.shared[index_ln_haze_share] = std::log(0.2);
            p.shared[index_pedestal] = 0.02;
            p.ln_gain[1] = 0.1;
            problem.set_aperture_for(p);
            for (const std::size_t row : {5UL, 16UL, 40UL, 55UL, 80UL}) {
                const Eigen::VectorXd found = problem.derivatives(p, row, 0);
                for (Eigen::Index k = 0; k < p.shared.size(); ++k) {
                    constexpr double h = 1e-5;
                    FitParameters up = p, down = p;
                    up.shared[k] += h;
                    down.shared[k] -= h;
                    const double difference =
                        (problem.modelled(up)[row] - problem.modelled(down)[row]) / (2 * h);
                    // The shift of the aperture with the pose is left out of the derivative: 1e-4
                    // of it.
                    EXPECT_NEAR(found[k], difference, 2e-4 * std::abs(difference) + 1e-5)
                        << "parameter " << k;
                }
            }
        }
    }
}

TEST(Aperture, MomentsOfTwoDiscs) {
    for (const auto& [a, b] : {std::pair{0.2, 0.2}, {0.5, 0.1}, {0.0, 0.3}, {2.0, 2.0}}) {
        for (const int rings : {1, 2, 5}) {
            double sum = 0, along2 = 0, across2 = 0, fourth = 0;
            for (const ApertureNode& n : aperture_nodes(a, b, rings)) {
                sum += n.share;
                along2 += n.share * n.along * n.along;
                across2 += n.share * n.across * n.across;
                fourth += n.share * std::pow(n.along * n.along + n.across * n.across, 2);
            }
            const double ra = std::tan(0.5 * a * 0.017453292519943295769);
            const double rb = std::tan(0.5 * b * 0.017453292519943295769);
            // A disc has a variance of r^2/4 an axis; variances add.
            EXPECT_NEAR(sum, 1, 1e-12);
            EXPECT_NEAR(along2, (ra * ra + rb * rb) / 4, 1e-6 * ra * ra + 1e-6 * rb * rb);
            EXPECT_NEAR(across2, along2, 1e-12);
            // E r^4 of a sum: r^4/3 of each disc, and 4 times the product of the variances' means.
            const double exact = (std::pow(ra, 4) + std::pow(rb, 4)) / 3 + ra * ra * rb * rb;
            if (rings > 1) {
                EXPECT_NEAR(fourth, exact, 1e-5 * exact);
            }
        }
    }
    EXPECT_EQ(aperture_nodes(0, 0, 3).size(), 1U);
}

TEST(Sha256, KnownFingerprints) {
    // FIPS 180-4 examples.
    EXPECT_EQ(sha256_hex("abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(sha256_hex(std::string(1000000, 'a')),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace togishi
