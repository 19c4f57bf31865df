// The least-squares problem of a fit: readings, the model of a reading, and its derivatives.
#pragma once
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Dense>

#include "fit/aperture.hpp"
#include "fit/fit.hpp"
#include "fit/reflectance.hpp"
#include "scan/scan.hpp"

namespace togishi {

/// Places of the parameters that all scans share; pedestals, one a channel, follow.
/// Along and across are counted from the direction of the sample that lies in the plane of
/// incidence at the first scan's turn: what one turn alone can see is then one parameter.
enum FitIndex : int {
    index_ln_weight,
    index_ln_mu_deg,
    index_e_along,
    index_e_across,
    index_tilt_along,    // rad
    index_tilt_across,   // rad
    index_receive,       // rad
    index_out_of_plane,  // rad
    index_ln_haze_share,
    index_ln_haze_width,
    index_pedestal
};

struct FitParameters {
    Eigen::VectorXd shared;   ///< index_pedestal + channels
    Eigen::VectorXd ln_gain;  ///< one a scan
};

/// Which parameters move; the others stay as they are.
struct FitActive {
    std::vector<int> shared;  ///< increasing FitIndex
    bool gain = false;
    [[nodiscard]] bool has(int index) const;
};

/// Standard deviations of Gaussian priors about 0 (haze: about its usual size); infinity: none.
struct FitPriors {
    Eigen::VectorXd shared;
    double ln_gain = 0.01;
};

/// Normal equations in the order of FitActive::shared; gains meet only their own scan.
struct NormalEquations {
    Eigen::MatrixXd shared;
    Eigen::MatrixXd mixed;  ///< (shared, scans)
    Eigen::VectorXd gain;   ///< (scans) diagonal
    Eigen::VectorXd shared_gradient, gain_gradient;
    double cost = 0;  ///< sum of squared residuals (robust), priors included
};

class FitProblem {
  public:
    /// Readings are divided by their largest, `scale`. A scan's rows may be thinned to every
    /// `stride`-th.
    FitProblem(const ScanSet& scans, bool use_aperture, std::size_t stride = 1);

    // What the readings are
    [[nodiscard]] std::size_t scans() const { return scan_count_; }
    [[nodiscard]] std::size_t channels() const { return channels_; }
    [[nodiscard]] std::size_t rows() const { return rows_.size(); }
    [[nodiscard]] std::size_t readings() const { return measured_.size(); }
    [[nodiscard]] double scale() const { return scale_; }
    /// Azimuth in the sample that "along" lies at.
    [[nodiscard]] double axis_rad() const { return axis_; }
    void set_axis_rad(double axis) { axis_ = axis; }
    [[nodiscard]] const std::vector<double>& measured() const {
        return measured_;
    }  ///< (rows, channels)
    [[nodiscard]] std::size_t scan_of_row(std::size_t row) const { return rows_[row].scan; }
    [[nodiscard]] double peak(std::size_t channel) const { return peaks_[channel]; }
    /// Whether the detector clipped there, whatever became of the reading.
    [[nodiscard]] bool at_saturation(std::size_t reading) const {
        return at_saturation_[reading] != 0;
    }

    // What a fit may change between runs
    std::vector<ReadingState> state;  ///< (rows, channels)
    std::vector<double> sigma;        ///< (rows, channels), in units of scale
    std::vector<char> scan_used;      ///< (scans)
    double huber = std::numeric_limits<double>::infinity();
    FitPriors priors;
    std::shared_ptr<const ReflectanceTable> reflectance;
    bool haze = false;

    /// Chooses the quadrature of the aperture for a lobe as narrow as this.
    void set_aperture_for(const FitParameters& p);
    /// rings of the quadrature, for tests of convergence.
    void set_aperture_rings(int rings);
    [[nodiscard]] int aperture_rings_used() const { return rings_; }

    [[nodiscard]] FitParameters start() const;
    /// Modelled readings (rows, channels); 0 for gaps.
    [[nodiscard]] std::vector<double> modelled(const FitParameters& p) const;
    [[nodiscard]] double cost(const FitParameters& p) const;
    [[nodiscard]] NormalEquations linearised(const FitParameters& p, const FitActive& active) const;
    /// Derivatives of one reading by all shared parameters, and by its scan's ln gain (last): for
    /// tests.
    [[nodiscard]] Eigen::VectorXd derivatives(const FitParameters& p, std::size_t row,
                                              std::size_t channel) const;

    int mutable evaluations = 0;

  private:
    struct Row {
        std::size_t scan;
        double receive_rad, azimuth_rad;
    };
    struct Setup {
        double incidence_rad, turn_rad;
        ScanQuantity quantity;
        double source_deg, detector_deg;
        std::size_t nodes;  // which of node_sets_
    };
    template <class Visit>
    void visit_rows(const FitParameters& p, const FitActive* active, Visit&& visit) const;
    void make_nodes();

    ScanPart part_;
    std::size_t scan_count_, channels_;
    double scale_ = 1, axis_ = 0;
    bool use_aperture_;
    int rings_ = 0;
    std::vector<Setup> setups_;
    std::vector<Row> rows_;
    std::vector<double> measured_, peaks_;
    std::vector<char> at_saturation_;  // (rows, channels)
    std::vector<std::vector<ApertureNode>> node_sets_;
};

}  // namespace togishi
