// Tables as users bring them: what is read, what is refused and with which words.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "spectral/embedded_data.hpp"
#include "spectral/light.hpp"
#include "spectral/metal.hpp"
#include "spectral/observer.hpp"
#include "spectral/table_file.hpp"

namespace togishi {
namespace {

TableFile light_table(std::string_view text) {
    return parse_table(text, "user.csv", "light", 2, TableMetadata::optional);
}

// The message of the InputError that the text causes, or "accepted".
std::string refusal(std::string_view text) {
    try {
        (void)light_from_csv(text, "user.csv", "csv:user.csv");
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

void expect_refused(std::string_view text, std::initializer_list<std::string_view> words) {
    const auto message = refusal(text);
    EXPECT_TRUE(message.starts_with("user.csv") || message.starts_with("light ")) << message;
    for (const auto word : words)
        EXPECT_NE(message.find(word), std::string::npos) << message << "\nlacks " << word;
}

TEST(TableFile, ReadsAllLineEndsSeparatorsAndByteOrderMark) {
    const std::vector<std::string> texts{"400,1\n500,2\n",
                                         "400,1\r\n500,2\r\n",
                                         "400,1\r500,2",
                                         std::string("\xef\xbb\xbf") + "400;1\n500;2",
                                         "400\t1\n500\t2\n",
                                         "  400   1  \n\n 500 2\n",
                                         "# a comment\n400,1\n# another: one\n500,+2e0\n",
                                         "wavelength,power\n400,1\n500,2\n"};
    for (const auto& text : texts) {
        const auto table = light_table(text);
        EXPECT_EQ(table.columns[0], (std::vector<double>{400.0, 500.0})) << text;
        EXPECT_EQ(table.columns[1], (std::vector<double>{1.0, 2.0})) << text;
    }
}

TEST(TableFile, KeepsMetadataAndLineNumbers) {
    const auto table =
        light_table("# title: A lamp: mine\n# source:  bench 3 \n\n400,1\n\n500,2\n");
    EXPECT_EQ(table.value("title"), "A lamp: mine");
    EXPECT_EQ(table.value("source"), "bench 3");
    EXPECT_EQ(table.value("licence"), "");
    EXPECT_EQ(table.at(1), "user.csv, line 6");
}

TEST(TableFile, RefusesWhatIsNoTable) {
    expect_refused("", {"user.csv", "content"});
    expect_refused("# title: nothing\n", {"without a row"});
    expect_refused("nm,power\n", {"without a row"});
    expect_refused("400,1\n410,abc\n", {"line 2", "column 2", "\"abc\"", "a finite number"});
    expect_refused("400,1\n410,nan\n", {"line 2", "\"nan\""});
    expect_refused("400,1\n410,inf\n", {"line 2", "\"inf\""});
    expect_refused("400,1\n410,1e999\n", {"line 2", "1e999"});
    expect_refused("400,1\n410,\n", {"line 2", "column 2"});
    expect_refused("400,1\n410\n", {"line 2", "1 fields", "2 numbers"});
    expect_refused("400,1,7\n", {"3 fields"});
    expect_refused("380,5;0,1\n390,5;0,2\n", {"4 fields", "decimal points"});
    expect_refused("a,b\nc,d\n400,1\n", {"line 2"});
    expect_refused("500,1\n400,1\n", {"line 2", "\"400\"", "increasing"});
    expect_refused("500,1\n500,1\n", {"line 2", "each wavelength once"});
    expect_refused("-5,1\n500,1\n", {"line 1", "above 0 nm"});
    expect_refused(std::string("\xff\xfe"
                               "4\0",
                               4),
                   {"UTF-16"});
    expect_refused(std::string("400,1\0", 6), {"binary"});
    expect_refused("# kind: metal\n400,1\n500,1\n", {"kind", "\"metal\"", "light"});
    expect_refused("# format: togishi-table 9\n400,1\n500,1\n", {"format", "togishi-table 1"});
    expect_refused("400,\x1b[31m\n", {"\\x1b[31m"});  // no escape sequences into a terminal
}

TEST(TableFile, RefusesTooManyRows) {
    std::string text;
    for (std::size_t i = 0; i <= table_file_max_rows; ++i) text += std::to_string(1 + i) + ",1\n";
    expect_refused(text, {"number of rows", "200000"});
}

TEST(TableFile, RefusesMissingFilesFoldersAndHugeFiles) {
    EXPECT_THROW((void)read_table_text("/no/such/file.csv"), InputError);
    EXPECT_THROW((void)read_table_text(std::filesystem::temp_directory_path()), InputError);
    EXPECT_THROW((void)read_table_text("/dev/zero"), InputError);
    const auto path = std::filesystem::path(testing::TempDir()) / "huge.csv";
    std::ofstream(path) << "400,1\n";
    std::filesystem::resize_file(path, table_file_max_bytes + 1);  // sparse
    EXPECT_THROW((void)read_table_text(path), InputError);
    std::filesystem::remove(path);
}

TEST(UserLight, RefusesSpectraWithoutLightWhereItIsSeen) {
    expect_refused("400,0\n700,0\n", {"400 to 700 nm", "zero everywhere"});
    expect_refused("750,1\n900,1\n", {"400 to 700 nm"});
    expect_refused("200,1\n399,1\n", {"400 to 700 nm"});
    expect_refused("0.4,1\n0.7,1\n", {"micrometres"});
    expect_refused("400,1\n500,-0.5\n", {"line 2", "-0.5", "0 or more"});
    expect_refused("400,-1\n500,-2\n", {"0 or more"});
    expect_refused("400,1e200\n500,1\n", {"at most 1e100"});
    expect_refused("750,1\n", {"400 to 700 nm"});
}

TEST(UserLight, SaysWhatItLacksAndWhatWasDone) {
    auto notes = [](std::string_view text) {
        return light_from_csv(text, "u.csv", "csv:u.csv").description().notes;
    };
    EXPECT_TRUE(notes("380,1\n385,1\n390,1\n395,1\n400,1\n").size() == 1);  // ends at 400
    const auto narrow = notes("450,1\n455,1\n");
    ASSERT_EQ(narrow.size(), 2U);
    EXPECT_NE(narrow[0].find("no data from 380 to 450 nm"), std::string::npos);
    EXPECT_NE(narrow[0].find("within the 400 to 700 nm"), std::string::npos);
    EXPECT_NE(narrow[1].find("no data from 455 to 780 nm"), std::string::npos);
    EXPECT_NE(notes("380,1\n780,1\n").at(0).find("400 nm apart"), std::string::npos);
    EXPECT_NE(notes("380,1\n500,1\n500.2,1\n780,1\n").at(0).find("closer than 1 nm"),
              std::string::npos);
    EXPECT_NE(notes("500,5\n").at(0).find("spectral line"), std::string::npos);
    EXPECT_NE(notes("nm,W\n380,1\n780,1\n").at(0).find("column titles"), std::string::npos);
    const auto noise = light_from_csv("380,-0.01\n580,1\n780,1\n", "u.csv", "csv:u.csv");
    EXPECT_NE(noise.description().notes.at(0).find("1 values below zero"), std::string::npos);
    EXPECT_EQ(std::get<TableSpectrum>(noise.shape()).power[0], 0.0);
}

TEST(UserLight, IsReadAgainWhenItsFileChanges) {
    const auto path = std::filesystem::path(testing::TempDir()) / "changing_light.csv";
    const std::string name = "csv:" + path.string();
    std::ofstream(path) << "400,1\n700,1\n";
    const auto first = find_light(name);
    EXPECT_EQ(first, find_light(name));
    std::ofstream(path) << "400,1\n700,2.5\n";
    EXPECT_EQ(std::get<TableSpectrum>(find_light(name)->shape()).power[1], 2.5);
    std::ofstream(path) << "400,1\n700,x\n";
    EXPECT_THROW((void)find_light(name), InputError);
    std::filesystem::remove(path);
    EXPECT_THROW((void)find_light(name), InputError);
}

TEST(UserMetal, NeedsMetadataAndTheVisibleRange) {
    const std::string head =
        "# format: togishi-table 1\n# kind: metal\n# name: m\n# title: M\n# source: s\n# licence: "
        "CC0-1.0\n";
    auto metal = [&](const std::string& rows) {
        return Metal(parse_table(head + rows, "m.csv", "metal", 3, TableMetadata::required));
    };
    EXPECT_EQ(metal("400,1,2\n700,1,2\n").name(), "m");
    EXPECT_THROW(metal("410,1,2\n700,1,2\n"), InputError);
    EXPECT_THROW(metal("400,1,2\n650,1,2\n"), InputError);
    EXPECT_THROW(metal("400,-1,2\n700,1,2\n"), InputError);
    EXPECT_THROW(metal("400,0,0\n700,1,2\n"), InputError);
    EXPECT_THROW(metal("400,1,2\n700,1,1e9\n"), InputError);
    EXPECT_THROW(
        (void)parse_table("400,1,2\n700,1,2\n", "m.csv", "metal", 3, TableMetadata::required),
        InputError);
}

TEST(BuiltinData, EveryFileStatesSourceAndLicenceAndMatchesItsName) {
    std::size_t tables = 0;
    for (const auto& file : embedded_files()) {
        if (!file.path.ends_with(".csv")) continue;
        ++tables;
        for (const std::string_view key :
             {"# format: togishi-table 1", "# kind: ", "# source: ", "# licence: "}) {
            EXPECT_NE(file.text.find(key), std::string_view::npos) << file.path;
        }
        const auto slash = file.path.rfind('/');
        const auto stem = file.path.substr(slash + 1, file.path.size() - slash - 5);
        EXPECT_NE(file.text.find("# name: " + std::string(stem) + "\n"), std::string_view::npos)
            << file.path;
    }
    EXPECT_EQ(tables,
              builtin_metals().size() + builtin_lights().size() + builtin_observers().size() + 1);
    EXPECT_EQ(builtin_metals().front()->name(), "iron_johnson_christy");
    EXPECT_EQ(builtin_metals().size(), 6U);
    EXPECT_EQ(builtin_lights().front()->description().name, "D65");
    EXPECT_EQ(builtin_lights().size(), 10U);
    EXPECT_EQ(builtin_observers().front()->name(), "cie1931_2");
}

TEST(BuiltinData, UnknownNamesListWhatExists) {
    auto message = [](auto find) -> std::string {
        try {
            find();
        } catch (const InputError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_NE(message([] { (void)find_metal("iron"); }).find("iron_johnson_christy"),
              std::string::npos);
    EXPECT_NE(message([] { (void)find_light("D64"); }).find("D65"), std::string::npos);
    EXPECT_NE(message([] { (void)find_observer("x"); }).find("cie1964_10"), std::string::npos);
    for (const auto* light :
         {"daylight:3999", "daylight:25001", "daylight:", "daylight:5000K", "daylight:nan",
          "blackbody:100", "blackbody:inf", "line:399.9", "line:701", "line:", "csv:", "", ":"}) {
        EXPECT_NE(message([&] { (void)find_light(light); }), "accepted") << light;
    }
}

}  // namespace
}  // namespace togishi
