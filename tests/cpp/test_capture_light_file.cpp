// .lp files as people write them, and what is refused with which words.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.hpp"
#include "capture/light_file.hpp"
#include "capture/light_stack.hpp"

namespace togishi {
namespace {

namespace fs = std::filesystem;

class LightFileTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() /
                  ("togishi-lp-" +
                   std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        fs::create_directories(folder_ / "img");
    }
    void TearDown() override { fs::remove_all(folder_); }
    fs::path picture(const std::string& name) const {
        std::ofstream(folder_ / name) << "x";
        return folder_ / name;
    }
    LightFile read(const std::string& text, const LightFileOptions& options = {}) const {
        std::ofstream(folder_ / "stack.lp", std::ios::binary) << text;
        return read_light_file(folder_ / "stack.lp", options);
    }
    void refused(const std::string& text, const std::string& words,
                 const LightFileOptions& options = {}) const {
        try {
            (void)read(text, options);
            FAIL() << "accepted: " << text;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
            EXPECT_NE(std::string(error.what()).find("stack.lp"), std::string::npos);
        }
    }
    fs::path folder_;
};

TEST_F(LightFileTest, NamesWithSpacesCommasTabsBomAndWindowsLines) {
    picture("IMG 0001 a.tif");
    picture("\xe5\x88\x80.png");
    picture("img/3.tif");
    const fs::path absolute = picture("4.tif");
    const LightFile file = read(
        "\xef\xbb\xbf"
        "4\r\nIMG 0001 a.tif 0,6 0,0 0,8\r\n\r\n\xe5\x88\x80.png\t0 -1.2\t1.6\r\n"
        "img\\3.tif 0 0 2e0\r\n\"" +
        absolute.string() + "\" 1 1 1\r\n");
    ASSERT_EQ(file.lights.size(), 4U);
    EXPECT_EQ(file.lights[0].image, folder_ / "IMG 0001 a.tif");
    EXPECT_NEAR(file.lights[0].direction.x, 0.6, 1e-15);
    EXPECT_NEAR(file.lights[1].direction.y, -0.6, 1e-15);
    EXPECT_EQ(file.lights[1].line, 4U);
    EXPECT_EQ(file.lights[2].image, folder_ / "img/3.tif");
    EXPECT_EQ(file.lights[3].image, absolute);
    EXPECT_NEAR(glm::length(file.lights[3].direction), 1, 1e-15);
    EXPECT_FALSE(file.near);
}

TEST_F(LightFileTest, PositionsAndIntensities) {
    picture("a.tif");
    LightFileOptions options;
    options.positions_mm = options.intensity_column = true;
    const LightFile file = read("1\na.tif 300 0 400 1,25\n", options);
    EXPECT_TRUE(file.near);
    EXPECT_EQ(file.lights[0].position_mm, glm::dvec3(300, 0, 400));
    EXPECT_NEAR(file.lights[0].direction.z, 0.8, 1e-15);
    EXPECT_EQ(file.lights[0].intensity, 1.25);
    refused("1\na.tif 300 0 400 0\n", "line 2: intensity", options);
    refused("1\na.tif 300 0 400\n", "line 2: x is \"a.tif\"", options);
}

TEST_F(LightFileTest, WhatIsWrongIsNamed) {
    picture("a.tif");
    picture("b.tif");
    refused("", "count is missing");
    refused("two\na.tif 0 0 1\n", "line 1: count");
    refused("-1\n", "line 1: count");
    refused("2\na.tif 0 0 1\n", "2 in the first line, but 1 lines follow");
    refused("1\na.tif 0 0 1\nb.tif 0 0 1\n", "line 3: count");
    refused("1\nmissing.tif 0 0 1\n", "line 2: picture is missing");
    refused("1\na.tif 0 0,5.1 1\n", "line 2: y is \"0,5.1\"");
    refused("1\na.tif 0 0 nan\n", "line 2: z");
    refused("1\n0 0 1\n", "line 2: file name is missing");
    refused("1\na.tif 0 0 0\n", "line 2: x y z");
    refused("1\na.tif 0 1 -0.2\n", "line 2: z is -0.2");
    refused("2\na.tif 0 0 1\na.tif 0 1 1\n", "named twice");
    refused(std::string("1\n\0a.tif 0 0 1\n", 16), "binary");
    EXPECT_THROW((void)read_light_file(folder_ / "none.lp"), InputError);
}

LightFile lights(int count, double arc) {
    LightFile file;
    file.path = "stack.lp";
    for (int i = 0; i < count; ++i) {
        const double zenith = 0.2 + 0.9 * i / count, azimuth = arc * i;
        LightEntry light;
        light.direction = {std::sin(zenith) * std::cos(azimuth),
                           std::sin(zenith) * std::sin(azimuth), std::cos(zenith)};
        file.lights.push_back(light);
    }
    return file;
}

TEST(LightStackTest, SetUpsThatCannotWorkAreRefused) {
    EXPECT_NO_THROW(LightStack(lights(12, 2.4), {}, 7));
    EXPECT_THROW(LightStack(lights(6, 2.4), {}, 7), InputError);
    EXPECT_THROW(LightStack(lights(40, 0), {}, 7), InputError) << "one arc";
    EXPECT_THROW(LightStack(lights(40, 3.14159265358979), {}, 7), InputError) << "one plane";
    StackOptions options;
    options.metal = "unobtainium";
    EXPECT_THROW(LightStack(lights(12, 2.4), options, 7), InputError);
    LightFile near = lights(12, 2.4);
    near.near = true;
    EXPECT_THROW(LightStack(near, {}, 7), InputError) << "no scale";
}

TEST(LightStackTest, ReachFollowsTheSpacing) {
    const StackReach few = LightStack(lights(20, 2.4), {}, 7).reach({0, 0, 1});
    const StackReach many = LightStack(lights(80, 2.4), {}, 7).reach({0, 0, 1});
    EXPECT_NEAR(many.spacing_deg / few.spacing_deg, 0.5, 0.08) << "a quarter of the room for each";
    EXPECT_NEAR(few.mu_sure_deg, 0.65 * few.spacing_deg, 1e-12);
}

TEST(LightStackTest, NearLightsSeenFromTheirOriginAreLikeFarOnes) {
    LightFile far = lights(20, 2.4), near = far;
    near.near = true;
    for (LightEntry& light : near.lights) light.position_mm = 700.0 * light.direction;
    StackOptions options;
    options.mm_per_pixel = 0.1;
    const RegionLights a = LightStack(far, options, 7).region({0, 0, 1});
    const LightStack stack(near, options, 7);
    const RegionLights b = stack.region({0, 0, 1});
    const RegionLights c = stack.region({0, 0, 1}, {70, 0, 0});
    for (std::size_t i = 0; i < 20; ++i) {
        EXPECT_NEAR(a.u_deg[i], b.u_deg[i], 1e-4);
        EXPECT_NEAR(a.gain[i], b.gain[i], 1e-6 * a.gain[i]);
    }
    // 70 mm to the right every light stands further left: half vectors turn by about half of 5.7
    // deg.
    EXPECT_NEAR(c.u_deg[0] - b.u_deg[0], -0.5 * 5.7, 0.3);
}

}  // namespace
}  // namespace togishi
