// A whole run over pictures in memory: what a cell decides, what is kept where a run ends early,
// and the same bits whatever the threads and bands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "brdf/model.hpp"
#include "capture/light_stack.hpp"
#include "capture/tile_run.hpp"

namespace togishi {
namespace {

namespace fs = std::filesystem;

constexpr double rad = 0.017453292519943295769;
constexpr std::size_t channels = capture_channels.size(), at_ln_mu = 3, at_haze = 7, at_flags = 18;

class Pictures : public TileReader {
  public:
    Pictures(std::size_t width, std::size_t height, std::size_t images)
        : width_(width), height_(height), values(width * height * images), images_(images) {}
    [[nodiscard]] std::size_t width() const override { return width_; }
    [[nodiscard]] std::size_t height() const override { return height_; }
    [[nodiscard]] std::size_t images() const override { return images_; }
    [[nodiscard]] double quantisation_variance() const override { return 0; }
    [[nodiscard]] std::string fingerprint() const override { return "in memory"; }
    void read(std::size_t image, std::size_t begin, std::size_t end, float* to,
              std::uint8_t* clipped) override {
        if (image == 7 && end > whole_rows)
            throw InputError("7.tif", "rows", "unreadable", "a whole picture");
        for (std::size_t i = begin * width_; i < end * width_; ++i) {
            const float v = values[image * width_ * height_ + i];
            *to++ = std::min(v, 1.0F);
            *clipped++ = v >= 1 ? 1 : 0;
        }
    }
    std::size_t whole_rows = 1'000'000;  // of picture 7

  private:
    std::size_t width_, height_;

  public:
    std::vector<float> values;

  private:
    std::size_t images_;
};

LightFile lights_about_the_normal(int count) {
    LightFile file;
    file.path = "stack.lp";
    for (int i = 0; i < count; ++i) {
        const double r = 22 * rad * std::pow((i + 0.5) / count, 0.85), a = 2.399963 * i;
        const glm::dvec3 h(std::sin(r) * std::cos(a), std::sin(r) * std::sin(a), std::cos(r));
        LightEntry light;
        light.direction = 2 * h.z * h - glm::dvec3(0, 0, 1);
        file.lights.push_back(light);
    }
    return file;
}

// Pictures of a flat plate whose lobe changes from pixel to pixel; haze_of: share of a second lobe
// of three times the width, by the column's cell.
struct Plate {
    LightFile lights = lights_about_the_normal(60);
    Pictures pictures;
    std::vector<double> ln_mu;
    Plate(std::size_t width, std::size_t height, const std::vector<double>& haze_of)
        : pictures(width, height, 60), ln_mu(width * height) {
        RandomNormal random(11);
        const RegionLights seen = LightStack(lights, {}, 7).region({0, 0, 1});
        for (std::size_t p = 0; p < width * height; ++p) {
            const double haze = haze_of[p % width / cell_pixels % haze_of.size()];
            const double mu_b = 3 + 2 * random.uniform(), mu_t = mu_b * (1.3 + random.uniform());
            const double rho = 180 * random.uniform();
            ln_mu[p] = 0.5 * std::log(mu_t * mu_b);
            const auto form = [&](double wider) {
                return f64::lobe_form(
                    f64::lobe_from_mu(mu_t * wider * rad, mu_b * wider * rad, rho * rad));
            };
            const auto narrow = form(1), wide = form(3);
            for (std::size_t i = 0; i < 60; ++i) {
                const glm::dvec2 d(seen.u_deg[i] * rad, seen.v_deg[i] * rad);
                const double y =
                    seen.gain[i] * (f64::lobe_value(narrow, {d.x, d.y}) +
                                    (haze > 0 ? haze * f64::lobe_value(wide, {d.x, d.y}) : 0)) +
                    0.02 * seen.diffuse[i];
                pictures.values[i * width * height + p] =
                    static_cast<float>(y + std::sqrt(1e-4 * y + 9e-8) * random.normal());
            }
        }
    }
};

class StackRunTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() /
                  ("togishi-run-" +
                   std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    // The finished run's pixels, (height, width, channels).
    std::vector<float> pixels(Plate& plate, const StackRunOptions& options,
                              StackRunReport& report) const {
        TileStore store =
            StackRun(plate.lights, plate.pictures, options).run(folder_ / "m.exr", report);
        std::vector<float> all;
        for (std::size_t b = 0; b < store.bands(); ++b) {
            const std::vector<float> band = store.read(b);
            all.insert(all.end(), band.begin(), band.end());
        }
        store.remove();
        return all;
    }
    fs::path folder_;
};

StackRunOptions exact_lights() {
    StackRunOptions o;
    o.stack.light_error_deg = 0;
    return o;
}

double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST_F(StackRunTest, HazeIsDecidedByTheCell) {
    const std::vector<double> share{0, 0.01, 0.03, 0.1};
    const std::size_t width = share.size() * cell_pixels, height = cell_pixels;
    Plate plate(width, height, share);
    StackRunOptions options = exact_lights();
    options.haze_width = 3;
    StackRunReport report;
    const std::vector<float> found = pixels(plate, options, report);
    EXPECT_EQ(report.cells, share.size());
    EXPECT_EQ(report.haze_cells, share.size() - 1);
    for (std::size_t cell = 0; cell < share.size(); ++cell) {
        std::vector<double> haze, off;
        for (std::size_t p = 0; p < width * height; ++p) {
            if (p % width / cell_pixels != cell) continue;
            const float* const pixel = &found[p * channels];
            haze.push_back(double{pixel[at_haze]});
            if (pixel[at_flags] == 0)
                off.push_back(std::abs(double{pixel[at_ln_mu]} - plate.ln_mu[p]));
        }
        ASSERT_GT(off.size(), haze.size() / 2) << share[cell];
        EXPECT_LT(median(off), 0.01) << share[cell];
        if (share[cell] == 0) {
            EXPECT_EQ(*std::max_element(haze.begin(), haze.end()), 0) << "no second lobe at all";
        } else {
            EXPECT_NEAR(median(haze), share[cell], 0.1 * share[cell] + 5e-4);
        }
    }
}

TEST_F(StackRunTest, TheSameBitsForAnyThreadsAndBands) {
    Plate plate(100, 150, {0});
    std::vector<std::vector<float>> found;
    for (const auto& [threads, rows] : {std::pair{1U, std::size_t{0}}, std::pair{3U, cell_pixels},
                                        std::pair{2U, 2 * cell_pixels}}) {
        StackRunOptions options = exact_lights();
        options.threads = threads;
        options.band_rows = rows;
        StackRunReport report;
        found.push_back(pixels(plate, options, report));
    }
    EXPECT_TRUE(same_bits(found[0], found[1]));
    EXPECT_TRUE(same_bits(found[0], found[2]));
}

TEST_F(StackRunTest, APictureThatEndsTooEarlyKeepsTheBandsBeforeIt) {
    Plate plate(64, 4 * cell_pixels, {0});
    StackRunOptions options = exact_lights();
    options.band_rows = cell_pixels;
    StackRunReport whole, first, second;
    const std::vector<float> expected = pixels(plate, options, whole);
    EXPECT_EQ(files(), 0U);
    plate.pictures.whole_rows = 2 * cell_pixels + 10;
    EXPECT_THROW((void)pixels(plate, options, first), InputError);
    EXPECT_EQ(files(), 1U) << "the store, with two bands";
    plate.pictures.whole_rows = 4 * cell_pixels;
    EXPECT_TRUE(same_bits(pixels(plate, options, second), expected));
    EXPECT_EQ(second.bands_resumed, 2U);
    // Where nothing was finished, nothing is left.
    plate.pictures.whole_rows = 10;
    EXPECT_THROW((void)pixels(plate, options, first), InputError);
    EXPECT_EQ(files(), 0U);
}

TEST_F(StackRunTest, AStoppedRunSaysWhatIsKeptAndGoesOn) {
    Plate plate(64, 3 * cell_pixels, {0});
    StackRunOptions options = exact_lights();
    options.band_rows = cell_pixels;
    StackRunReport whole, stopped, again;
    const std::vector<float> expected = pixels(plate, options, whole);
    try {
        (void)StackRun(plate.lights, plate.pictures, options)
            .run(folder_ / "m.exr", stopped,
                 [](std::size_t done, std::size_t) { return done < 2; });
        FAIL() << "ran on";
    } catch (const StackStopped& s) {
        EXPECT_EQ(s.bands_done, 2U) << "the band that was being written is kept";
        EXPECT_EQ(s.bands, 3U);
    }
    EXPECT_TRUE(same_bits(pixels(plate, options, again), expected));
    EXPECT_EQ(again.bands_resumed, 2U);
}

}  // namespace
}  // namespace togishi
