#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "scanned/record.hpp"

namespace togishi {
namespace {

ScanRecord example() {
    ScanRecord record;
    record.object_id = "F-19-112";
    record.title = "太刀 \"銘\"\nsecond line";
    record.holder = "A museum";
    record.rights = "CC BY 4.0";
    record.software_version = "0.1.0";
    record.created_utc = "2026-11-23T11:30:00Z";
    record.mm_per_unit = 1000;
    record.unit_how = "m: 0.95 units long, as a sword is";
    record.inputs = {{"blade.ply", "scan", std::string(64, 'a'), 123456789012}};
    record.outputs = {{"blade.glb", "blade", std::string(64, 'b'), 1},
                      {"parts.csv", "parts", "", 0}};
    record.steps = {{"clean",
                     {{"close_holes_mm", 0.5}, {"weld", true}, {"mode", std::string("safe")}},
                     {{"duplicate faces", 12, ""}, {"largest hole", 3.25, "mm"}},
                     {"2 pieces kept aside"}}};
    record.dimensions = {{"nagasa", 736.0312345678901, 0.08, "mm", ""},
                         {"sori", 18.5, {}, "mm", "one end only"}};
    record.inferred = {"the border of ha and ji"};
    return record;
}

TEST(ScanRecord, ComesBackAsItWas) {
    const ScanRecord before = example();
    const ScanRecord after = parse_record(record_json(before), "test");
    EXPECT_EQ(after.title, before.title);
    EXPECT_EQ(after.object_id, before.object_id);
    EXPECT_EQ(after.holder, before.holder);
    EXPECT_EQ(after.rights, before.rights);
    EXPECT_EQ(after.created_utc, before.created_utc);
    EXPECT_EQ(after.software_version, before.software_version);
    EXPECT_EQ(after.mm_per_unit, before.mm_per_unit);
    EXPECT_EQ(after.unit_how, before.unit_how);
    EXPECT_EQ(after.inferred, before.inferred);
    ASSERT_EQ(after.inputs.size(), 1U);
    EXPECT_EQ(after.inputs[0].bytes, before.inputs[0].bytes);
    ASSERT_EQ(after.outputs.size(), 2U);
    EXPECT_EQ(after.outputs[1].role, "parts");
    ASSERT_EQ(after.steps.size(), 1U);
    EXPECT_EQ(after.steps[0].parameters, before.steps[0].parameters);
    EXPECT_EQ(after.steps[0].notes, before.steps[0].notes);
    EXPECT_EQ(after.steps[0].figures[1].value, 3.25);
    EXPECT_EQ(after.steps[0].figures[1].unit, "mm");
    ASSERT_EQ(after.dimensions.size(), 2U);
    EXPECT_EQ(after.dimensions[0].value, before.dimensions[0].value);
    EXPECT_EQ(after.dimensions[0].sigma, before.dimensions[0].sigma);
    EXPECT_FALSE(after.dimensions[1].sigma.has_value());
    EXPECT_EQ(record_json(after), record_json(before));
}

TEST(ScanRecord, AFigureThatIsNoNumberIsLeftOutNotNulled) {
    ScanRecord record = example();
    record.dimensions[0].value = NAN;
    record.dimensions[0].sigma = INFINITY;
    const std::string text = record_json(record);
    EXPECT_EQ(text.find("null"), std::string::npos);
    const ScanRecord after = parse_record(text, "test");
    EXPECT_TRUE(std::isnan(after.dimensions[0].value));
    EXPECT_FALSE(after.dimensions[0].sigma.has_value());
}

TEST(ScanRecord, ForeignAndBrokenFilesAreNamed) {
    const auto message = [](const std::string& text) {
        try {
            (void)parse_record(text, "x.jsonld");
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(message("{").find("no JSON"), std::string::npos);
    EXPECT_NE(message("[]").find("togishi:format"), std::string::npos);
    EXPECT_NE(message("{}").find("togishi:format"), std::string::npos);
    EXPECT_NE(message(R"({"togishi:format": 2, "@graph": []})").find("2"), std::string::npos);
    EXPECT_NE(message(R"({"togishi:format": 1, "@graph": []})").find("D3_Formal_Derivation"),
              std::string::npos);
    const std::string deep(1000000, '[');
    EXPECT_NE(message(deep + std::string(1000000, ']')).find("togishi:format"), std::string::npos);
    EXPECT_NE(message(R"({"togishi:format": )" + deep + std::string(1000000, ']') + "}")
                  .find("togishi:format"),
              std::string::npos);
    std::string text = record_json(example());
    text.replace(text.find("123456789012"), 12, "-3          ");
    EXPECT_NE(message(text).find("togishi:bytes"), std::string::npos);
}

}  // namespace
}  // namespace togishi
