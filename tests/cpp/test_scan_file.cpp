// Scan files: what is read, and what is refused with its line and column.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "scan/scan_file.hpp"
#include "scan/simulate_scan.hpp"

namespace togishi {
namespace {

const std::string header =
    "# format: togishi-scan 1\n# part: hamon\n# quantity: radiance\n# calibration: absolute\n# "
    "unit: 1/sr\n"
    "# source_aperture_deg: 0.2\n# detector_aperture_deg: 0.1\n# turn_sense: counter-clockwise\n";

std::string refusal(const std::string& text, const ScanSettings& settings = {}) {
    try {
        (void)parse_scans(text, "mine.csv", settings);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(ScanFile, WhatAStrangerWrites) {
    // Byte order mark, CRLF, semicolons, decimal commas, unsorted rows, gaps, comments, another
    // order of columns.
    const std::string text =
        "\xef\xbb\xbf" + header +
        "# warning: lamp drifted\r\nturn_deg;receive_deg;incidence_deg;intensity;sigma\r\n"
        "45;45,2;45;1,5;0,01\r\n0;44,8;45;1,25;0,02\r\n\r\n# in between\r\n"
        "0;44,6;45;;\r\n0;44,4;45;1e-3;0,02\r\n";
    const ScanSet set = parse_scans(text, "mine.csv");
    ASSERT_EQ(set.scans.size(), 2U);
    EXPECT_EQ(set.scans[0].turn_deg, 0);
    ASSERT_EQ(set.scans[0].rows.size(), 2U);
    EXPECT_EQ(set.scans[0].rows[0].receive_deg, 44.4);
    EXPECT_EQ(set.scans[0].intensity[1], 1.25);
    EXPECT_EQ(set.scans[0].sigma[1], 0.02);
    EXPECT_EQ(set.scans[1].turn_deg, 45);
    EXPECT_EQ(set.metal, "auto");
    EXPECT_EQ(set.readings(), 3U);
    ASSERT_EQ(set.notes.size(), 2U);
    EXPECT_NE(set.notes[0].find("warning"), std::string::npos);
    EXPECT_NE(set.notes[1].find("line 15"), std::string::npos) << set.notes[1];
    EXPECT_EQ(set.inputs[0].sha256.size(), 64U);
}

TEST(ScanFile, SenseAndAxisOfTheTurn) {
    const std::string rows = "incidence_deg,receive_deg,turn_deg,intensity\n45,45,30,1\n";
    EXPECT_EQ(parse_scans(header + rows, "a").scans[0].turn_deg, 30);
    EXPECT_EQ(parse_scans(replaced(header, "counter-clockwise", "clockwise") + rows, "a")
                  .scans[0]
                  .turn_deg,
              330);
    EXPECT_EQ(parse_scans(header + "# blade_axis_deg: 90\n" + rows, "a").scans[0].turn_deg, 120);
    const std::string rad =
        "incidence_rad\treceive_rad\tintensity\n0,7853981634\t0,7853981634\t1\n";
    EXPECT_NEAR(parse_scans(header + rad, "a").scans[0].incidence_deg, 45, 1e-8);
}

TEST(ScanFile, RefusalsNameLineAndColumn) {
    const std::string titles = "incidence_deg,receive_deg,turn_deg,intensity\n";
    const std::string good = header + titles + "45,44,0,1\n45,45,0,2\n";
    EXPECT_EQ(refusal(good), "");
    struct Case {
        std::string text;
        std::vector<std::string> words;
    };
    std::string swapped = header + titles;
    for (int i = 0; i < 30; ++i) swapped += std::to_string(20 + i) + ",45,0,1\n";
    for (const auto& [text, words] : std::vector<Case>{
             {replaced(good, "45,45,0,2", "45,45,0,two"),
              {"line 11", "column 4 (intensity)", "two"}},
             {replaced(good, "45,45,0,2", "45,45,0"), {"line 11", "3 fields"}},
             {replaced(good, "45,45,0,2", "95,45,0,2"),
              {"line 11", "column 1 (incidence_deg)", "95"}},
             {replaced(good, "45,45,0,2", "45,,0,2"), {"line 11", "column 2", "missing"}},
             {replaced(good, "45,45,0,2", "45,44,0,2"),
              {"line 11", "column 4", "line 10", "agree"}},
             {replaced(good, "45,45,0,2", "45,45,0,inf"), {"line 11", "inf"}},
             {replaced(good, "receive_deg,", ""), {"line 9", "receive_deg", "missing"}},
             {replaced(good, ",intensity", ",brightness"), {"line 9", "column 4", "brightness"}},
             {replaced(good, "turn_deg", "turn_rad"), {"line 9", "column 3", "mixed units"}},
             {replaced(good, "turn_deg", "receive_deg"), {"line 9", "column 3", "second time"}},
             {replaced(good, titles, ""), {"line 9", "before any titles"}},
             {replaced(good, "# quantity: radiance", "# quantiti: radiance"),
              {"line 3", "quantiti", "quantity"}},
             {replaced(good, "# quantity: radiance\n", ""), {"quantity", "missing"}},
             {replaced(good, "radiance", "light"), {"line 3", "quantity", "light", "flux"}},
             {replaced(good, "1/sr", "W/m2"), {"line 5", "unit"}},
             {replaced(good, "0.2", "wide"), {"line 6", "source_aperture_deg"}},
             {replaced(good, "togishi-scan 1", "togishi-scan 2"), {"line 1", "format"}},
             {header + "# metal: /etc/passwd\n" + titles + "45,44,0,1\n", {"line 9", "metal"}},
             {header + "# light: csv:/etc/passwd\n" + titles + "45,44,0,1\n", {"line 9", "light"}},
             {header + titles + "45,-45,0,5\n45,-44,0,3\n45,0,0,1\n",
              {"column 2 (receive_deg)", "-45", "reversed"}},
             {swapped, {"column 1 (incidence_deg)", "exchanged"}},
             {replaced(good, "# turn_sense: counter-clockwise\n", "") + "45,46,45,1\n",
              {"turn_sense", "missing"}},
             {replaced(good, "45,45,0,2", "45,45,0,2\n1.234,5,0,1,1"), {"5 fields"}},
             {header + "incidence_deg;receive_deg;intensity\n45;44,5;1\n45;45.5;1\n",
              {"line 11", "decimal comma"}},
             {header + "incidence_deg,receive_deg,intensity,sigma\n45,45,1,0\n",
              {"line 10", "column 4 (sigma)"}},
             {header, {"no column titles"}},
             {header + titles, {"no row"}},
             {std::string("a\0b", 3), {"binary"}},
             {"\xff\xfe", {"UTF-16"}}}) {
        const std::string found = refusal(text);
        EXPECT_NE(found.find("mine.csv"), std::string::npos) << text << ": " << found;
        for (const std::string& word : words)
            EXPECT_NE(found.find(word), std::string::npos) << word << ": " << found;
    }
}

TEST(ScanFile, SettingsStandOverTheFile) {
    const std::string good = replaced(header, "# quantity: radiance\n", "") +
                             "incidence_deg,receive_deg,intensity\n45,45,1\n";
    const ScanSet set = parse_scans(good, "mine.csv", {{"quantity", "flux"}, {"part", "ji"}});
    EXPECT_EQ(set.scans[0].quantity, ScanQuantity::flux);
    EXPECT_EQ(set.part, ScanPart::ji);
    EXPECT_EQ(set.notes.size(), 1U);
    EXPECT_NE(refusal(good, {{"colour", "red"}}).find("colour"), std::string::npos);
}

TEST(ScanFile, SimulationsComeBackBitForBit) {
    SimulationOptions o;
    o.channels = {"intensity", "intensity_450nm"};
    o.protocol.step_deg = 2;
    o.protocol.azimuths_deg = {4, -4, 0};
    o.state_sigma = true;
    o.saturation = 0.8;
    const ScanSet set = simulate_scan(default_material(), ScanPart::hamon, o);
    const ScanSet again = parse_scans(scans_to_text(set), "again");
    ASSERT_EQ(again.scans.size(), set.scans.size());
    for (std::size_t s = 0; s < set.scans.size(); ++s) {
        EXPECT_EQ(again.scans[s].intensity, set.scans[s].intensity);
        EXPECT_EQ(again.scans[s].sigma, set.scans[s].sigma);
        EXPECT_EQ(again.scans[s].turn_deg, set.scans[s].turn_deg);
        ASSERT_EQ(again.scans[s].rows.size(), 3U * 21U);
        for (std::size_t i = 0; i < set.scans[s].rows.size(); ++i) {
            EXPECT_EQ(again.scans[s].rows[i].azimuth_deg, set.scans[s].rows[i].azimuth_deg);
            EXPECT_EQ(again.scans[s].rows[i].receive_deg, set.scans[s].rows[i].receive_deg);
        }
        EXPECT_EQ(again.scans[s].rows.front().azimuth_deg, -4);
        EXPECT_EQ(again.scans[s].saturation, set.scans[s].saturation);
    }
    // The same seed is the same file; another one is not.
    EXPECT_EQ(scans_to_text(simulate_scan(default_material(), ScanPart::hamon, o)),
              scans_to_text(set));
    o.seed = 2;
    EXPECT_NE(scans_to_text(simulate_scan(default_material(), ScanPart::hamon, o)),
              scans_to_text(set));
}

TEST(ScanFile, ThePapersProtocols) {
    SimulationOptions o;
    o.channels = {"intensity_550nm"};
    const ScanSet a = simulate_scan(default_material(), ScanPart::hamon, o);
    EXPECT_EQ(a.scans.size(), 4U);
    EXPECT_EQ(a.rows(), 4U * 201U);
    o.protocol = scan_protocol("b");
    const ScanSet b = simulate_scan(default_material(), ScanPart::ji, o);
    EXPECT_EQ(b.scans.size(), 6U);
    EXPECT_EQ(b.scans[3].rows.front().receive_deg, 10);
    EXPECT_EQ(b.scans[3].rows.back().receive_deg, 80);
    EXPECT_THROW((void)scan_protocol("c"), InputError);
}

TEST(ScanFile, TornTextIsRefusedOrRead) {
    SimulationOptions o;
    o.channels = {"intensity_550nm"};
    o.protocol.step_deg = 5;
    const std::string good = scans_to_text(simulate_scan(default_material(), ScanPart::hamon, o));
    std::mt19937 random(5);  // NOLINT(bugprone-random-generator-seed): the same damage every time
    for (int i = 0; i < 1500; ++i) {
        std::string text = good;
        for (int hit = 0; hit < 3; ++hit)
            text[random() % text.size()] = static_cast<char>(random() % 256);
        try {
            (void)parse_scans(text, "mine.csv");
        } catch (const InputError& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    }
}

TEST(ScanFile, FilesAreJoinedByPart) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(::testing::TempDir()) / "togishi_scans";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string rows = "incidence_deg,receive_deg,intensity\n45,45,1\n";
    const auto write = [&](const char* name, const std::string& text) {
        std::ofstream(folder / name) << text;
        return folder / name;
    };
    const fs::path ha = write("ha.csv", header + rows);
    const fs::path ha2 = write("ha2.csv", header + replaced(rows, "45,45,1", "25,25,1"));
    const fs::path ji = write("ji.csv", replaced(header, "hamon", "ji") + rows);
    const fs::path other =
        write("other.csv", replaced(replaced(header, "absolute", "relative"), "1/sr", "V") + rows);
    const std::vector<fs::path> all{ha, ji, ha2};
    const auto sets = read_scans(all);
    ASSERT_EQ(sets.size(), 2U);
    EXPECT_EQ(sets[0].part, ScanPart::ji);
    EXPECT_EQ(sets[1].scans.size(), 2U);
    EXPECT_EQ(sets[1].inputs.size(), 2U);
    EXPECT_THROW((void)read_scans(std::vector<fs::path>{ha, other}), InputError);
    EXPECT_THROW((void)read_scans(std::vector<fs::path>{ha, ha}), InputError);
    EXPECT_THROW((void)read_scans(std::vector<fs::path>{folder / "none.csv"}), InputError);
    EXPECT_THROW((void)read_scans(std::vector<fs::path>{}), InputError);
    fs::remove_all(folder);
}

}  // namespace
}  // namespace togishi
