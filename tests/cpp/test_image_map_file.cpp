// Property maps in OpenEXR files: what is written is read back, bad files are named, failures leave
// what was there.
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include <OpenImageIO/imageio.h>

#include "bake/half.hpp"
#include "bake/map_mips.hpp"
#include "base/error.hpp"
#include "image/map_file.hpp"

namespace {

using namespace togishi;
using enum MapChannel;
namespace fs = std::filesystem;

PropertyMaps random_maps(std::size_t width, std::size_t height, bool shapes) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0, 1);
    PropertyMaps maps;
    maps.width = width;
    maps.height = height;
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        const auto channel = static_cast<MapChannel>(c);
        const bool shape =
            channel == ji_e1 || channel == ji_e2 || channel == ha_e1 || channel == ha_e2;
        if (shape && !shapes) continue;
        auto& plane = maps[channel];
        plane.resize(width * height);
        for (float& value : plane)
            value = channel == part ? std::floor(8 * unit(random)) : 0.9F * unit(random);
    }
    maps[h] = {0.25F};
    return maps;
}

class MapFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("togishi-image-" + std::to_string(getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }
    static std::string error_of(const std::function<void()>& action) {
        try {
            action();
        } catch (const InputError& error) {
            return error.what();
        }
        return "no InputError";
    }
    static void expect_words(const std::string& text, std::initializer_list<const char*> words) {
        for (const char* word : words)
            EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
    }
    void write_foreign(const fs::path& path, const std::vector<std::string>& channels,
                       bool ours) const {
        OIIO::ImageSpec spec(8, 4, static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT);
        spec.channelnames = channels;
        if (ours) spec.attribute("togishi:format", map_file_format);
        const std::vector<float> pixels(32 * channels.size(), 0.5F);
        const auto out = OIIO::ImageOutput::create(path.string());
        ASSERT_TRUE(out && out->open(path.string(), spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
        ASSERT_TRUE(out->close());
    }

    fs::path folder_;
    MapFileInfo info_{{948.0F, 70.0F}, "a \"test\"", "togishi 0.1.0"};
};

TEST_F(MapFiles, ComesBackWithAllLevels) {
    const std::pair<std::size_t, std::size_t> sizes[]{{1, 1}, {130, 70}, {512, 8}, {3, 257}};
    for (const auto& [width, height] : sizes) {
        for (const bool shapes : {false, true}) {
            const PropertyMaps maps = random_maps(width, height, shapes);
            write_map_file(file("a.exr"), maps, info_, MapPrecision::single);
            const MapFile back = read_map_file(file("a.exr"));
            const auto levels = coarser_levels(view_of(maps));
            ASSERT_EQ(back.levels.size(), levels.size() + 1);
            EXPECT_EQ(back.levels[0].channels,
                      maps.channels);  // float: to the bit, constants as one value
            for (std::size_t n = 0; n < levels.size(); ++n) {
                EXPECT_EQ(back.levels[n + 1].width, levels[n].width);
                if (levels[n].width * levels[n].height > 1) {
                    EXPECT_EQ(back.levels[n + 1].channels, levels[n].channels);
                }
            }
            EXPECT_EQ(back.info.chart_mm, info_.chart_mm);
            EXPECT_EQ(back.info.source, info_.source);
            EXPECT_EQ(back.info.software, info_.software);
            EXPECT_FALSE(back.repair.any());
        }
    }
    EXPECT_TRUE(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()) == 1);
}

TEST_F(MapFiles, HalfIsTheNearestHalf) {
    const PropertyMaps maps = random_maps(33, 20, true);
    write_map_file(file("a.exr"), maps, info_);
    const MapFile back = read_map_file(file("a.exr"));
    for (std::size_t c = 0; c < map_channel_count; ++c) {
        ASSERT_EQ(back.levels[0].channels[c].size(), maps.channels[c].size());
        for (std::size_t i = 0; i < maps.channels[c].size(); ++i) {
            ASSERT_EQ(back.levels[0].channels[c][i],
                      float_from_half(half_from_float(maps.channels[c][i])));
        }
    }
}

TEST_F(MapFiles, IsATiledMipMappedExrWithTheChannelNames) {
    write_map_file(file("a.exr"), random_maps(130, 70, true), info_);
    const auto in = OIIO::ImageInput::open(file("a.exr").string());
    ASSERT_TRUE(in);
    const OIIO::ImageSpec spec = in->spec(0, 0);
    EXPECT_EQ(spec.tile_width, 64);
    EXPECT_EQ(spec.format, OIIO::TypeDesc::HALF);
    std::vector<std::string> names(spec.channelnames.begin(), spec.channelnames.end());
    std::vector<std::string> expected(map_channel_names.begin(), map_channel_names.end());
    std::sort(names.begin(), names.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(names, expected);
    EXPECT_EQ(in->spec(0, 7).width, 1);
    EXPECT_EQ(in->spec(0, 1).width, 65);
    EXPECT_EQ(in->spec(0, 1).height, 35);
}

TEST_F(MapFiles, TopRowOfTheImageIsTheTopOfTheChart) {
    PropertyMaps maps = random_maps(4, 2, false);
    maps[w] = {0, 0, 0, 0, 1, 1, 1, 1};  // v = 1 is hamon
    write_map_file(file("a.exr"), maps, info_);
    const auto in = OIIO::ImageInput::open(file("a.exr").string());
    const auto& names = in->spec().channelnames;
    const int channel =
        static_cast<int>(std::find(names.begin(), names.end(), "w") - names.begin());
    std::vector<float> top(8);
    ASSERT_TRUE(in->read_image(0, 0, channel, channel + 1, OIIO::TypeDesc::FLOAT, top.data()));
    EXPECT_EQ(top[0], 1.0F);
    EXPECT_EQ(top[7], 0.0F);
}

TEST_F(MapFiles, TruncatedAtAnyPlaceIsAnErrorThatNamesTheFile) {
    write_map_file(file("whole.exr"), random_maps(200, 100, true), info_);
    const auto size = fs::file_size(file("whole.exr"));
    for (const double share : {0.0, 0.001, 0.01, 0.3, 0.7, 0.98}) {
        fs::copy_file(file("whole.exr"), file("cut.exr"), fs::copy_options::overwrite_existing);
        fs::resize_file(file("cut.exr"),
                        static_cast<std::uintmax_t>(share * static_cast<double>(size)));
        expect_words(error_of([&] { (void)read_map_file(file("cut.exr")); }),
                     {"cut.exr", "allowed"});
    }
}

TEST_F(MapFiles, DamagedBytesNeverCrash) {
    write_map_file(file("whole.exr"), random_maps(70, 40, true), info_);
    std::ifstream in(file("whole.exr"), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    std::mt19937 random(2);
    for (int i = 0; i < 150; ++i) {
        std::string bytes = whole;
        for (int k = 0; k < 4; ++k)
            bytes[random() % (i % 2 == 0 ? 600 : bytes.size())] = static_cast<char>(random());
        std::ofstream(file("bad.exr"), std::ios::binary) << bytes;
        try {
            const MapFile map = read_map_file(file("bad.exr"));
            for (const auto& level : map.levels) EXPECT_TRUE(is_valid(view_of(level)));
        } catch (const InputError&) {
        }
    }
}

TEST_F(MapFiles, ForeignFilesAreNamed) {
    expect_words(error_of([&] { (void)read_map_file(file("none.exr")); }), {"none.exr", "OpenEXR"});
    std::ofstream(file("text.exr")) << "this is no picture";
    expect_words(error_of([&] { (void)read_map_file(file("text.exr")); }), {"text.exr", "allowed"});
    write_foreign(file("rgb.exr"), {"R", "G", "B"}, false);
    expect_words(error_of([&] { (void)read_map_file(file("rgb.exr")); }),
                 {"rgb.exr", "togishi:format", "missing", "1"});
    write_foreign(file("name.exr"), {"w", "h", "roughness"}, true);
    expect_words(error_of([&] { (void)read_map_file(file("name.exr")); }),
                 {"name.exr", "channel", "roughness", "ji.ln_mu_deg"});
    write_foreign(file("few.exr"), {"w", "ji.ln_mu_deg"}, true);
    const std::string few = error_of([&] { (void)read_map_file(file("few.exr")); });
    expect_words(few, {"few.exr", "allowed"});
    expect_words(error_of([&] { (void)read_map_file(folder_); }), {"allowed"});
}

TEST_F(MapFiles, NaNInAFileIsMendedAndCounted) {
    const auto nan = std::numeric_limits<float>::quiet_NaN();
    PropertyMaps maps = random_maps(2, 1, false);
    OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::FLOAT);
    spec.channelnames = {"ji.ln_mu_deg", "ha.ln_mu_deg", "w"};
    spec.tile_width = spec.tile_height = 16;
    spec.attribute("togishi:format", map_file_format);
    spec.attribute("textureformat", "Plain Texture");
    const std::vector<float> level0{0.1F, 1.5F, nan, 0.2F, 1.6F, 0.75F}, level1{nan, 1.5F, 0.5F};
    auto out = OIIO::ImageOutput::create(file("nan.exr").string());
    ASSERT_TRUE(out->open(file("nan.exr").string(), spec));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, level0.data()));
    spec.width = 1;
    spec.full_width = 1;
    ASSERT_TRUE(out->open(file("nan.exr").string(), spec, OIIO::ImageOutput::AppendMIPLevel));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, level1.data()));
    ASSERT_TRUE(out->close());
    out.reset();  // flushes
    const MapFile map = read_map_file(file("nan.exr"));
    EXPECT_EQ(map.repair.not_finite, 1U);
    EXPECT_EQ(map.levels[0][w], (std::vector<float>{0.75F, 0.75F}));
    EXPECT_TRUE(is_valid(view_of(map.levels[1])));
}

TEST_F(MapFiles, RefusesToWriteWhatItWouldNotRead) {
    PropertyMaps maps = random_maps(4, 4, true);
    maps[w][3] = std::numeric_limits<float>::quiet_NaN();
    expect_words(error_of([&] { write_map_file(file("a.exr"), maps, info_); }), {"a.exr", "NaN"});
    maps = random_maps(4, 4, true);
    maps[ha_ln_mu_deg].clear();
    expect_words(error_of([&] { write_map_file(file("a.exr"), maps, info_); }), {"ha.ln_mu_deg"});
    maps = random_maps(4, 4, true);
    expect_words(error_of([&] { write_map_file(file("a.png"), maps, info_); }), {"a.png", ".exr"});
    expect_words(error_of([&] { write_map_file(file("none/a.exr"), maps, info_); }),
                 {"none", "folder"});
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(MapFiles, FullDiskLeavesWhatWasThere) {
    const fs::path path = file("maps.exr");
    std::ofstream(path) << "previous";
    const PropertyMaps maps = random_maps(300, 200, true);
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    // A file may grow to 20 kB: as on a full disk, write() fails in the middle of the pixels.
    auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20'000, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    const std::string error = error_of([&] { write_map_file(path, maps, info_); });
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)std::signal(SIGXFSZ, handler);
    expect_words(error, {"maps.exr", "untouched"});
    std::ifstream in(path);
    const std::string left{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(left, "previous");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()),
              1);  // no leftovers
}

TEST_F(MapFiles, ReadOnlyFolderLeavesWhatWasThere) {
    const fs::path path = file("maps.exr");
    std::ofstream(path) << "previous";
    const PropertyMaps maps = random_maps(8, 8, true);
    fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::group_read |
                                 fs::perms::group_exec | fs::perms::others_read |
                                 fs::perms::others_exec);
    // Root may write anywhere: be nobody for a moment, as a farm's user would be.
    constexpr uid_t nobody = 65534;
    const bool root = geteuid() == 0;
    ASSERT_EQ(root ? setresuid(nobody, nobody, 0) : 0, 0);
    const std::string error = error_of([&] { write_map_file(path, maps, info_); });
    ASSERT_EQ(root ? setresuid(0, 0, 0) : 0, 0);
    fs::permissions(folder_, fs::perms::owner_all);
    expect_words(error, {"read-only"});
    EXPECT_EQ(fs::file_size(path), 8U);
}

}  // namespace
