// The material schema: what is read, what is refused, and that writing and reading are inverse.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "brdf/material.hpp"

namespace togishi {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

Material measured() {
    Material m = default_material();
    m.weights = Weights::measured;
    double weight = 1.5;
    for (const MaterialLobeField& field : material_lobes) {
        if (!field.weight_key.empty()) (m.*field.member).weight = weight *= 1.7;
    }
    return m;
}

std::string refusal(const std::string& text) {
    try {
        (void)material_from_toml(text, "mine.toml");
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(Material, BuiltinsComeBackEqual) {
    const auto names = builtin_materials();
    ASSERT_GE(names.size(), 4U);
    EXPECT_EQ(names.front(), default_material_name);
    for (const auto& name : names) {
        const Material m = load_material(name);
        EXPECT_EQ(material_from_toml(material_to_toml(m), name), m) << name;
    }
}

TEST(Material, AnyLegalValueComesBackBitForBit) {
    std::mt19937 random(7);  // NOLINT(bugprone-random-generator-seed): the same values every time
    const auto pick = [&](double low, double high) {
        return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(random));
    };
    for (int i = 0; i < 200; ++i) {
        Material m = i % 2 == 0 ? default_material() : measured();
        m.name = "\"\\\n\t\u7814\u304e\u5e2b [x] # = '''" + std::to_string(i);
        m.source = std::string(static_cast<std::size_t>(i), '"');
        for (const MaterialLobeField& field : material_lobes) {
            MaterialLobe& lobe = m.*field.member;
            lobe.mu_t_deg = pick(0.001, 80);
            lobe.mu_b_deg = std::max(0.001, lobe.mu_t_deg / pick(1, 100));
            lobe.rho_deg = pick(1e-300, 179.999);
            if (lobe.weight > 0) lobe.weight = pick(1e-300, 1e8);
        }
        m.nakago_albedo_rgb = {0, 1, pick(1e-30, 1)};
        m.nakago_ior = pick(1, 4);
        ASSERT_EQ(material_from_toml(material_to_toml(m), "again"), m) << material_to_toml(m);
    }
}

TEST(Material, EndsOfTheRangesAreAllowed) {
    Material m = measured();
    m.ji = {0.001, 0.001, 0, 1e8};
    m.ha = {80, 0.8, 0, 5e-324};
    m.ha.weight = 2.2250738585072014e-308;
    m.nakago_albedo_rgb = {0, 1, 0};
    m.nakago_ior = 4;
    EXPECT_EQ(material_from_toml(material_to_toml(m), "ends"), m);
    m.ji.rho_deg = 180;
    EXPECT_EQ(material_from_toml(material_to_toml(m), "ends").ji.rho_deg, 0) << "180 is read as 0";
}

TEST(Material, NumbersOutOfRangeAreRefused) {
    const double nan = std::nan("");
    for (const MaterialLobeField& field : material_lobes) {
        struct Change {
            std::string key;
            double MaterialLobe::*member;
            std::vector<double> values;
        };
        std::vector<Change> changes{
            {"mu_t_deg", &MaterialLobe::mu_t_deg, {0, -1, 80.001, 1e300, nan, INFINITY, 5e-324}},
            {"mu_b_deg", &MaterialLobe::mu_b_deg, {0, -1, 80.001, nan, -INFINITY, 1e-4}},
            {"rho_deg", &MaterialLobe::rho_deg, {-1e-9, 180.0001, nan, INFINITY}}};
        if (!field.weight_key.empty()) {
            changes.push_back({std::string(field.weight_key),
                               &MaterialLobe::weight,
                               {0, -1, -0.0, 1.0001e8, nan, INFINITY, 5e-324}});
        }
        for (const auto& [key, member, values] : changes) {
            for (const double value : values) {
                Material m = measured();
                m.*field.member.*member = value;
                const std::string said = refusal(material_to_toml(m));
                EXPECT_NE(said.find("parts." + std::string(field.key) + "." + key + " is"),
                          std::string::npos)
                    << key << " = " << value << ": " << said;
                EXPECT_NE(said.find("mine.toml:"), std::string::npos) << "no line: " << said;
            }
        }
    }
    Material m = default_material();
    m.ha.mu_t_deg = 1;
    m.ha.mu_b_deg = 1.0001;
    EXPECT_NE(refusal(material_to_toml(m)).find("parts.ha.mu_b_deg"), std::string::npos);
    m.ha.mu_t_deg = 50;
    m.ha.mu_b_deg = 0.49;
    EXPECT_NE(refusal(material_to_toml(m)).find("parts.ha.mu_b_deg"), std::string::npos);
}

TEST(Material, WrongFieldsAreNamed) {
    const std::string good = material_to_toml(default_material());
    struct Case {
        std::string from, to, said;
    };
    for (const auto& [from, to, said] : std::vector<Case>{
             {"format = 1", "format = 2", "format is 2"},
             {"format = 1", "format = 1.0", "format is"},
             {"format = 1", "format = \"1\"", "format is"},
             {"format = 1", "", "format is missing"},
             {"format = 1", "format = 1\nshine = 3", "shine is unknown"},
             {"[parts.ji]", "[parts.ji]\ngloss = 1", "parts.ji.gloss is unknown"},
             {"[parts.ji]", "[parts.tsuba]\nmu_t_deg = 1\n[parts.ji]", "parts.tsuba is unknown"},
             {"[parts.ji]", "[parts.ji]\nchi = 1.0", "parts.ji.chi is 1"},
             {"[parts.ji]", "[parts.j]", "parts.ji is missing"},
             {"[parts.ji]\n", "[parts.ji]\nmu_t_deg = \"1\"\n#", "parts.ji.mu_"},
             {"weights = \"normalised\"", "weights = \"loud\"", "weights is \"loud\""},
             {"weights = \"normalised\"", "weights = \"measured\"", "chi is missing"},
             {"weights = \"normalised\"", "weights = true", "weights is true"},
             {"name = ", "name = \"\"\n# ", "name is empty"},
             {"name = ", "name = [1]\n# ", "name is a list"},
             {"metal = ", "metal = \"unobtainium\"\n# ", "metal is \"unobtainium\""},
             {"albedo_rgb = [", "albedo_rgb = [1, 1, 1, 1]\n# ", "albedo_rgb is 4 values"},
             {"albedo_rgb = [", "albedo_rgb = [0.1, nan, 0.1]\n# ", "albedo_rgb is nan"},
             {"albedo_rgb = [", "albedo_rgb = [0.1, \"red\", 0.1]\n# ", "albedo_rgb is 'red'"},
             {"ior = ", "ior = 0.99\n# ", "ior is 0.99"},
             {"ior = ", "ior = inf\n# ", "ior is inf"}}) {
        const std::string found = refusal(replaced(good, from, to));
        EXPECT_NE(found.find(said), std::string::npos) << to << ": \"" << found << "\"";
        EXPECT_NE(found.find("mine.toml"), std::string::npos) << found;
        EXPECT_NE(found.find("allowed: "), std::string::npos) << found;
    }
}

TEST(Material, EveryFieldIsNeeded) {
    const std::string good = material_to_toml(measured());
    for (const char* key : {"format", "name", "metal", "weights", "albedo_rgb", "ior", "mu_t_deg",
                            "mu_b_deg", "rho_deg", "chi", "beta"}) {
        const std::string found = refusal(replaced(good, std::string(key) + " =", "# "));
        EXPECT_NE(found.find(std::string(key) + " is missing"), std::string::npos)
            << key << ": " << found;
    }
}

TEST(Material, TornTextIsRefusedAndNothingElse) {
    const std::string good = material_to_toml(default_material());
    // Cut anywhere, a file is refused in our own words (or is whole but for the last line's end).
    for (std::size_t length = 0; length + 24 < good.size(); length += 7)
        EXPECT_NE(refusal(good.substr(0, length)), "") << "cut at " << length;
    std::mt19937 random(11);  // NOLINT(bugprone-random-generator-seed): the same damage every time
    for (int i = 0; i < 400; ++i) {
        std::string text = good;
        for (int hit = 0; hit < 3; ++hit)
            text[random() % text.size()] = static_cast<char>(random() % 256);
        try {
            const Material m = material_from_toml(text, "mine.toml");
            EXPECT_EQ(material_from_toml(material_to_toml(m), "again"), m);
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("mine.toml"), std::string::npos);
        }
    }
    EXPECT_NE(refusal(std::string(20000, '[')), "") << "deep nesting";
}

TEST(Material, LinesAreShownOnlyWhereTheyAreTheUsers) {
    const std::string text =
        replaced(material_to_toml(default_material()), "format = 1", "format = 9");
    EXPECT_EQ(refusal(text).rfind("mine.toml:1: format", 0), 0U) << refusal(text);
    try {
        (void)material_from_toml(text, "a dict", SourceLines::hidden);
        FAIL() << "no error";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).rfind("a dict: format", 0), 0U) << error.what();
    }
}

TEST(Material, FilesThatAreNoneAreRefused) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(::testing::TempDir()) / "togishi_material";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const auto said = [](const std::string& name) -> std::string {
        try {
            (void)load_material(name);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(said("rust").find("polished_katana"), std::string::npos);
    EXPECT_NE(said(folder.string()), "") << "a folder";
    EXPECT_NE(said((folder / "none.toml").string()).find("none.toml"), std::string::npos);
    std::ofstream(folder / "big.toml") << std::string((1U << 20U) + 1, '#');
    EXPECT_NE(said((folder / "big.toml").string()).find("up to 1 MiB"), std::string::npos);
    std::ofstream(folder / "good.toml") << material_to_toml(measured());
    EXPECT_EQ(load_material((folder / "good.toml").string()), measured());
    fs::remove_all(folder);
}

}  // namespace
}  // namespace togishi
