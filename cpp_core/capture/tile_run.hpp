// A stack of photographs under many known lights becomes maps, band by band.
//
// The picture is cut into cells of 64 x 64 pixels. Each cell has its own normal (the middle one of
// its pixels), about which its half vectors are mapped, and its own decision about haze; both come
// from the cell's pixels alone. So the maps are the same bits for any number of threads, any band
// height, and whether or not a run was stopped in between. (Another instruction set rounds
// differently: the run's fingerprint holds it.)
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/light_stack.hpp"
#include "capture/pixel_result.hpp"
#include "capture/self_calibration.hpp"
#include "capture/tile_reader.hpp"
#include "capture/tile_store.hpp"

namespace togishi {

inline constexpr std::size_t cell_pixels = 64;

/// Channels of a finished map, in file order. Lobes are stored as shaders/shared/lobe.glsl states,
/// in the frame whose tangent is the picture's x axis made perpendicular to the normal.
inline constexpr std::array<std::string_view, 19> capture_channels{"N.X",
                                                                   "N.Y",
                                                                   "N.Z",
                                                                   "lobe.ln_mu_deg",
                                                                   "lobe.e1",
                                                                   "lobe.e2",
                                                                   "lobe.weight",
                                                                   "lobe.haze",
                                                                   "diffuse",
                                                                   "pedestal",
                                                                   "sigma.ln_mu",
                                                                   "sigma.rho_deg",
                                                                   "sigma.normal_deg",
                                                                   "sigma.ln_weight",
                                                                   "chi2",
                                                                   "samples.used",
                                                                   "samples.clipped",
                                                                   "samples.rejected",
                                                                   "flags"};

/// A lobe known beforehand (from a goniometer fit), for pixels that the photographs leave open.
struct LobePrior {
    double mu_t_deg = 1, mu_b_deg = 1, rho_deg = 0;  ///< rho against the picture's x axis
    double sigma_ln_mu = 0.1;                        ///< how sure, of ln mu and of the shape
};

struct WhitePatch {
    std::size_t left = 0, top = 0, width = 0, height = 0;  ///< pixels
    double reflectance = 0.99;                             ///< diffuse, 0 to 1
};

struct StackRunOptions {
    StackOptions stack;
    std::vector<double> exposures{1};  ///< relative light of each set of pictures, the first is 1
    glm::dvec3 normal{0, 0, 1};        ///< of the object, roughly; cells find their own from it
    double snr = 100;                  ///< at full scale: photon noise of 1/snr
    double read_noise = 3e-4;          ///< of full scale, rms
    bool pedestal = false;
    double haze_width = 0;  ///< > 1: look for a second lobe so many times wider
    std::optional<WhitePatch> white;
    bool self_calibration = false;
    std::optional<LobePrior> prior;
    PixelEffort effort = PixelEffort::full;
    std::size_t band_rows = 0;  ///< 0: what memory_bytes allows; else a multiple of 64
    std::size_t memory_bytes = std::size_t{1} << 30U;  ///< for the pictures' bands
    unsigned threads = 0;
    const std::atomic<bool>* stop = nullptr;  ///< asked between cells: true stops the run
};

struct StackRunReport {
    StackReach reach{};
    std::size_t width = 0, height = 0, lights = 0, pictures = 0;
    std::size_t bands = 0, bands_resumed = 0;
    std::size_t flagged = 0, inferred = 0, haze_cells = 0, cells = 0;
    std::array<std::size_t, 7> reasons{};  ///< pixels per PixelFlag
    std::optional<Calibration> calibration;
    double seconds_reading = 0;  ///< beside the fit
    double seconds_fitting = 0;
    std::string instruction_set;
};

/// Called after each band; false stops the run.
using StackProgress = std::function<bool(std::size_t bands_done, std::size_t bands)>;

/// A stop that was asked for: finished bands are kept.
struct StackStopped {
    std::size_t bands_done = 0, bands = 0;
};

class StackRun {
  public:
    /// `reader`'s pictures are those of `lights`, exposure by exposure. Throws InputError for
    /// options out of range, and as LightStack does.
    StackRun(const LightFile& lights, TileReader& reader, const StackRunOptions& options);

    /// What the set-up can see; nothing is read for it.
    [[nodiscard]] StackReach reach() const;
    /// Fits what is not yet in the store beside `target`, and leaves it there; the caller writes
    /// the target from it. Throws InputError (a truncated picture: finished bands are kept) and
    /// StackStopped.
    [[nodiscard]] TileStore run(const std::filesystem::path& target, StackRunReport& report,
                                const StackProgress& progress = {});

  private:
    struct Band;
    struct Cell;
    [[nodiscard]] std::string fingerprint() const;
    [[nodiscard]] std::size_t rows_per_band() const;
    void measure_white();
    void calibrate(StackRunReport& report);
    void read_band(Band& band, std::size_t begin, std::size_t end);
    void gather(const Band& band, std::size_t x, std::size_t row, float* value, float* scale) const;
    void fit_cell(const Band& band, std::size_t x, std::size_t y, std::vector<float>& out,
                  Cell& counted) const;
    [[nodiscard]] PixelKernelOptions kernel_options() const;

    TileReader& reader_;
    StackRunOptions options_;
    LightStack stack_;
    std::string lights_text_;
    std::vector<std::size_t> shortest_first_;  ///< exposures
    double sigma_h_deg_;
    SharedError shared_;
};

}  // namespace togishi
