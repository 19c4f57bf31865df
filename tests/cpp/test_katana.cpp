// The generated katana: topology, measures, chart, normals, refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "blade/katana_file.hpp"
#include "blade/katana_frame.hpp"
#include "blade/katana_mesh.hpp"
#include "blade/katana_shape.hpp"
#include "spectral/embedded_data.hpp"

namespace togishi {
namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;

// Every edge once in each direction, no vertex unused or twice in a face; returns the Euler
// characteristic.
int check_closed(const KatanaMesh& mesh) {
    std::vector<Edge> edges;
    std::vector<bool> used(mesh.positions_mm.size(), false);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const std::int32_t begin = mesh.face_start[f];
        const std::int32_t end = mesh.face_start[f + 1];
        EXPECT_GE(end - begin, 3);
        EXPECT_LE(end - begin, 4);
        for (std::int32_t c = begin; c < end; ++c) {
            const std::int32_t a = mesh.corner_vertex[static_cast<std::size_t>(c)];
            const std::int32_t b =
                mesh.corner_vertex[static_cast<std::size_t>(c + 1 < end ? c + 1 : begin)];
            EXPECT_NE(a, b);
            used[static_cast<std::size_t>(a)] = true;
            edges.emplace_back(a, b);
        }
    }
    std::sort(edges.begin(), edges.end());
    EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end())
        << "an edge twice in one direction";
    for (const auto& [a, b] : edges) {
        if (!std::binary_search(edges.begin(), edges.end(), Edge{b, a})) {
            ADD_FAILURE() << "open edge " << a << " " << b;
            break;
        }
    }
    EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << "unused vertices";
    return static_cast<int>(mesh.positions_mm.size()) - static_cast<int>(edges.size() / 2) +
           static_cast<int>(mesh.face_count());
}

void check_corners(const KatanaMesh& mesh) {
    double worst_length = 0;
    double worst_angle = 0;
    for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
        const glm::dvec3 n(mesh.corner_normal[c]);
        const glm::dvec3 t(mesh.corner_tangent[c]);
        worst_length =
            std::max({worst_length, std::abs(glm::length(n) - 1), std::abs(glm::length(t) - 1)});
        worst_angle = std::max(worst_angle, std::abs(glm::dot(n, t)));
        if (!std::isfinite(n.x + n.y + n.z + t.x + t.y + t.z + mesh.corner_uv[c].x +
                           mesh.corner_uv[c].y)) {
            ADD_FAILURE() << "not finite at corner " << c;
            return;
        }
    }
    EXPECT_LT(worst_length, 1e-5);
    EXPECT_LT(worst_angle, 1e-5);
}

void check_measures(const KatanaMesh& mesh, const KatanaParameters& p, double tolerance) {
    const std::map<std::string, double> m = measure_katana(mesh, p);
    for (const DimensionField& d : katana_dimensions()) {
        const auto found = m.find(std::string(d.key));
        if (found == m.end()) continue;
        if (d.key == "mune_height_mm" && p.mune == MuneType::kaku) {
            EXPECT_NEAR(found->second, 0, 1e-9);
            continue;
        }
        // A coarse mesh cuts the corner of the mune's curve by a part of the sori.
        const double allowed = d.key == "sori_mm" ? tolerance + 0.03 * p.sori_mm : tolerance;
        EXPECT_NEAR(found->second, p.*d.member, allowed) << d.key;
    }
    EXPECT_GT(m.at("volume_mm3"), 0);
}

TEST(Katana, DefaultHasItsMeasures) {
    const KatanaParameters p;
    const KatanaMesh mesh = make_katana(p);
    const auto m = measure_katana(mesh, p);
    for (const char* key :
         {"nagasa_mm", "sori_mm", "motohaba_mm", "sakihaba_mm", "motokasane_mm", "sakikasane_mm",
          "kissaki_mm", "mune_height_mm", "moto_shinogi_haba_mm", "saki_shinogi_haba_mm"}) {
        const auto field = std::find_if(katana_dimensions().begin(), katana_dimensions().end(),
                                        [&](const DimensionField& d) { return d.key == key; });
        ASSERT_NE(field, katana_dimensions().end());
        EXPECT_NEAR(m.at(key), p.*field->member, 0.01) << key;
    }
    EXPECT_NEAR(m.at("sori_at_mm"), 368, 3) << "torii-zori is deepest in the middle";
    EXPECT_LE(m.at("uv_stretch_percent"), 2.0);
    EXPECT_GE(m.at("vertices"), 40000);
    EXPECT_LE(m.at("vertices"), 80000);
}

TEST(Katana, SoriLiesWhereItsNameSays) {
    std::map<SoriType, double> at;
    for (const SoriType type : {SoriType::koshi, SoriType::torii, SoriType::saki, SoriType::even}) {
        KatanaParameters p;
        p.sori_type = type;
        const auto m = measure_katana(make_katana(p, 0.2), p);
        EXPECT_NEAR(m.at("sori_mm"), p.sori_mm, 0.01);
        at[type] = m.at("sori_at_mm") / p.nagasa_mm;
    }
    EXPECT_LT(at[SoriType::koshi], 0.44);
    EXPECT_GT(at[SoriType::saki], 0.56);
    EXPECT_NEAR(at[SoriType::torii], 0.5, 0.01);
    EXPECT_NEAR(at[SoriType::even], 0.5, 0.01);
}

TEST(Katana, EveryZukuriAndMuneIsClosedAndTrue) {
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"}) {
        for (const MuneType mune :
             {MuneType::iori, MuneType::mitsu, MuneType::maru, MuneType::kaku}) {
            for (const double hole : {0.0, 4.0}) {
                for (const double detail : {0.002, 0.3}) {
                    KatanaParameters p = katana_defaults(zukuri);
                    p.mune = mune;
                    p.mekugi_ana_mm = hole;
                    SCOPED_TRACE(std::string(zukuri) + " mune " +
                                 std::to_string(static_cast<int>(mune)) + " hole " +
                                 std::to_string(hole) + " detail " + std::to_string(detail));
                    const KatanaMesh mesh = make_katana(p, detail);
                    EXPECT_EQ(check_closed(mesh), hole > 0 ? 0 : 2);
                    check_corners(mesh);
                    check_measures(mesh, p, 0.05);
                }
            }
        }
    }
}

TEST(Katana, MirrorsLeftToRight) {
    const KatanaMesh mesh = make_katana(KatanaParameters{}, 0.05);
    std::set<std::array<std::int64_t, 3>> places;
    auto key = [](const glm::dvec3& p) {
        return std::array<std::int64_t, 3>{std::llround(p.x * 1e6), std::llround(p.y * 1e6),
                                           std::llround(p.z * 1e6)};
    };
    for (const glm::dvec3& p : mesh.positions_mm) places.insert(key(p));
    EXPECT_EQ(places.size(), mesh.positions_mm.size()) << "two vertices in one place";
    for (const glm::dvec3& p : mesh.positions_mm)
        EXPECT_TRUE(places.contains(key({p.x, -p.y, p.z})));
}

TEST(Katana, NormalsAgreeWithFiniteDifferences) {
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"}) {
        for (const MuneType mune :
             {MuneType::iori, MuneType::mitsu, MuneType::maru, MuneType::kaku}) {
            KatanaParameters p = katana_defaults(zukuri);
            p.mune = mune;
            const KatanaShape shape(p);
            for (const Stretch stretch : stretches) {
                const auto [first, last] = shape.range(stretch);
                for (const double x : {0.07, 0.3, 0.62, 0.93}) {
                    const double q = first + (last - first) * x;
                    for (const Strip strip : strips) {
                        if (!shape.has(strip, stretch)) continue;
                        for (const double f : {0.1, 0.5, 0.9}) {
                            const double h = 1e-4;
                            const double hq = h * std::min(1.0, last - first);
                            const glm::dvec3 along =
                                shape.row(stretch, q + hq).at(strip, f).position_mm -
                                shape.row(stretch, q - hq).at(strip, f).position_mm;
                            const glm::dvec3 across =
                                shape.row(stretch, q).at(strip, f + h).position_mm -
                                shape.row(stretch, q).at(strip, f - h).position_mm;
                            const glm::dvec3 n = glm::normalize(glm::cross(along, across));
                            EXPECT_LT(glm::distance(n, shape.row(stretch, q).at(strip, f).normal),
                                      1e-5)
                                << zukuri << " stretch " << static_cast<int>(stretch) << " strip "
                                << static_cast<int>(strip) << " at " << x << ", " << f;
                        }
                    }
                }
            }
        }
    }
}

TEST(Katana, NormalsBreakAtRidgesOnly) {
    const KatanaMesh mesh = make_katana(KatanaParameters{}, 0.6);
    // Along the blade, between neighbouring corners of a face, no normal of the ji jumps.
    double widest = 0;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        if (mesh.face_part[f] != Part::ji && mesh.face_part[f] != Part::shinogi_ji &&
            mesh.face_part[f] != Part::ha)
            continue;
        const auto begin = static_cast<std::size_t>(mesh.face_start[f]);
        const auto end = static_cast<std::size_t>(mesh.face_start[f + 1]);
        for (std::size_t c = begin; c + 1 < end; ++c) {
            widest = std::max<double>(
                widest, glm::distance(mesh.corner_normal[c], mesh.corner_normal[c + 1]));
        }
    }
    EXPECT_LT(widest, 0.02);
    // At the yokote, kissaki and ji meet at one vertex with two normals; at the shinogi too.
    const std::int32_t mitsukado = mesh.landmarks.yokote_shinogi[0];
    std::map<Part, glm::vec3> normal;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        for (std::int32_t c = mesh.face_start[f]; c < mesh.face_start[f + 1]; ++c) {
            if (mesh.corner_vertex[static_cast<std::size_t>(c)] == mitsukado) {
                normal[mesh.face_part[f]] = mesh.corner_normal[static_cast<std::size_t>(c)];
            }
        }
    }
    ASSERT_TRUE(normal.contains(Part::ji) && normal.contains(Part::kissaki) &&
                normal.contains(Part::shinogi_ji));
    EXPECT_GT(glm::distance(normal[Part::ji], normal[Part::kissaki]), 0.02);
    EXPECT_GT(glm::distance(normal[Part::ji], normal[Part::shinogi_ji]), 0.05);
}

TEST(Katana, ChartHasNoOverlapAndFindsItsPoints) {
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"}) {
        const KatanaMesh mesh = make_katana(katana_defaults(zukuri), 0.3);
        const BladeFrame& frame = mesh.frame;
        double last_x = -1e9;
        double last_ridge_x = -1e9;
        for (double s = -frame.nakago_mm; s <= frame.nagasa_mm; s += 0.5) {
            // Lines of constant s never cross: x grows with s at the ridge as at the edge.
            const double x = frame.chart_x_mm(s, frame.at(frame.edge_mm, s));
            EXPECT_GT(x, last_x);
            last_x = x;
            const double ridge_x = frame.chart_x_mm(s, 0);
            EXPECT_GT(ridge_x, last_ridge_x);
            last_ridge_x = ridge_x;
        }
        int wrong_part = 0;
        int faces = 0;
        double worst = 0;
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            glm::dvec2 uv(0);
            const std::int32_t begin = mesh.face_start[f];
            const std::int32_t end = mesh.face_start[f + 1];
            double area = 0;
            for (std::int32_t c = begin; c < end; ++c) {
                const glm::dvec2 a(mesh.corner_uv[static_cast<std::size_t>(c)]);
                const glm::dvec2 b(
                    mesh.corner_uv[static_cast<std::size_t>(c + 1 < end ? c + 1 : begin)]);
                area += a.x * b.y - a.y * b.x;
                uv += a / static_cast<double>(end - begin);
                EXPECT_GE(a.x, -1e-6);
                EXPECT_LE(a.x, 1 + 1e-6);
                EXPECT_GE(a.y, 0);
                EXPECT_LE(a.y, 1);
            }
            if (mesh.face_part[f] == Part::nakago) continue;
            EXPECT_LT(area, 0) << "a face is turned over in the chart";
            ++faces;
            const ChartPoint p = frame.locate(uv.x, uv.y);
            wrong_part += p.part != mesh.face_part[f] ? 1 : 0;
            EXPECT_EQ(p.omote, uv.y < 0.5);
            double s = 0;
            for (std::int32_t c = begin; c < end; ++c) {
                s += mesh.s_mm[static_cast<std::size_t>(
                         mesh.corner_vertex[static_cast<std::size_t>(c)])] /
                     static_cast<double>(end - begin);
            }
            worst = std::max(worst, std::abs(p.s_mm - s));
        }
        EXPECT_LT(worst, 0.05);
        EXPECT_LE(wrong_part, faces / 200) << "faces cut by a border of the chart's samples";
    }
}

TEST(Katana, EveryMuneOfEverySwordLiesFlatInTheChart) {
    std::vector<KatanaParameters> swords;
    for (const std::string_view zukuri : {"shinogi", "hira", "shobu"})
        swords.push_back(katana_defaults(zukuri));
    const std::size_t defaults = swords.size();
    for (const EmbeddedFile& file : embedded_files()) {
        if (file.path.starts_with("blades/"))
            swords.push_back(parse_katana_preset(file.text, file.path).parameters);
    }
    double worst = 0;
    for (KatanaParameters p : swords) {
        for (const MuneType mune :
             {MuneType::iori, MuneType::mitsu, MuneType::maru, MuneType::kaku}) {
            p.mune = mune;
            const KatanaMesh mesh = make_katana(p, 0.1);
            const double stretch = measure_katana(mesh, p).at("uv_stretch_percent");
            EXPECT_LE(stretch, 1.25) << static_cast<int>(p.zukuri) << static_cast<int>(mune);
            worst = std::max(worst, stretch);
        }
    }
    EXPECT_GT(worst, 0.7) << "the sori alone stretches the edge against the mune by 0.8 %";
    // What the shape of the point depends on, a fifth smaller and a quarter larger.
    for (std::size_t i = 0; i < defaults; ++i) {
        for (const DimensionField& d : katana_dimensions()) {
            constexpr std::array<std::string_view, 6> point{
                "sori_mm",    "sakihaba_mm",    "sakikasane_mm",
                "kissaki_mm", "mune_height_mm", "saki_shinogi_haba_mm"};
            if (std::find(point.begin(), point.end(), d.key) == point.end()) continue;
            for (const double factor : {0.8, 1.25}) {
                KatanaParameters p = swords[i];
                p.mune = MuneType::kaku;
                p.*d.member *= factor;
                try {
                    check_katana(p, "test");
                } catch (const InputError&) {
                    continue;
                }
                const KatanaMesh mesh = make_katana(p, 0.05);
                EXPECT_LE(measure_katana(mesh, p).at("uv_stretch_percent"), 2.0)
                    << d.key << " " << p.*d.member;
            }
        }
    }
}

TEST(Katana, RandomLegalDimensions) {
    std::mt19937 random(
        20240611);  // NOLINT(bugprone-random-generator-seed): the same blades every time
    auto pick = [&](double lo, double hi) {
        return std::uniform_real_distribution<double>(lo, hi)(random);
    };
    constexpr int random_blades = 60;
    int made = 0;
    int tried = 0;
    while (made < random_blades && tried < 25 * random_blades) {
        ++tried;
        KatanaParameters p;
        p.zukuri = static_cast<Zukuri>(tried % 3);
        p.mune = static_cast<MuneType>(tried / 3 % 4);
        p.sori_type = static_cast<SoriType>(tried / 12 % 4);
        p.nakago_jiri = static_cast<Jiri>(tried / 48 % 3);
        p.nagasa_mm = pick(120, 1200);
        p.sori_mm = pick(0, 0.06) * p.nagasa_mm;
        p.motohaba_mm = pick(15, 45);
        p.sakihaba_mm = p.motohaba_mm * pick(0.5, 1.1);
        p.motokasane_mm = pick(3, 10);
        p.sakikasane_mm = p.motokasane_mm * pick(0.5, 1.1);
        p.kissaki_mm = pick(0.7, 5) * p.sakihaba_mm;
        p.fukura = pick(0, 1);
        p.mune_height_mm = pick(0.05, 0.5) * p.motokasane_mm;
        p.moto_shinogi_haba_mm = p.motohaba_mm * pick(0.15, 0.7);
        p.saki_shinogi_haba_mm = p.sakihaba_mm * pick(0.15, 0.7);
        p.shinogi_rise_mm = pick(0, 1);
        p.niku_mm = pick(0, 0.6);
        p.ha_haba_mm = pick(1, 12);
        p.nakago_mm = pick(60, 350);
        p.nakago_sakihaba_mm = p.motohaba_mm * pick(0.3, 0.8);
        p.nakago_sakikasane_mm = pick(2, 8);
        p.ha_machi_mm = pick(0.2, 5);
        p.mune_machi_mm = pick(0.2, 4);
        p.mekugi_ana_mm = tried % 2 == 0 ? 0 : pick(1, 7);
        p.mekugi_ana_from_machi_mm = pick(10, 120);
        try {
            check_katana(p, "test");
        } catch (const InputError&) {
            continue;
        }
        ++made;
        std::string all = "blade " + std::to_string(tried);
        for (const DimensionField& d : katana_dimensions())
            all += " " + std::string(d.key) + "=" + std::to_string(p.*d.member);
        SCOPED_TRACE(all);
        const KatanaMesh mesh = make_katana(p, 0.02);
        EXPECT_EQ(check_closed(mesh), p.mekugi_ana_mm > 0 ? 0 : 2);
        check_corners(mesh);
        check_measures(mesh, p, 0.05);
        if (HasFailure()) return;
    }
    EXPECT_EQ(made, random_blades) << "of " << tried;
}

TEST(Katana, ImpossibleDimensionsAreRefusedWithTheReason) {
    struct Case {
        const char* key;
        double value;
        const char* said;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const Case& c : {Case{"nagasa_mm", 0, "nagasa_mm"},
                          {"nagasa_mm", -5, "nagasa_mm"},
                          {"nagasa_mm", nan, "nan"},
                          {"nagasa_mm", infinity, "inf"},
                          {"nagasa_mm", 1e9, "2500"},
                          {"sori_mm", 60, "folds"},
                          {"sori_mm", -1, "sori_mm"},
                          {"kissaki_mm", 390, "part of the blade"},
                          {"kissaki_mm", 6, "0.7 sakihaba"},
                          {"sakihaba_mm", 40, "widen"},
                          {"sakikasane_mm", 7.8, "thicken"},
                          {"moto_shinogi_haba_mm", 29, "between"},
                          {"saki_shinogi_haba_mm", 19, "between"},
                          {"fukura", 1.5, "0 to 1"},
                          {"mekugi_ana_mm", 14, "mekugi_ana_mm"},
                          {"mekugi_ana_from_machi_mm", 205, "inside the nakago"},
                          {"ha_machi_mm", 12, "at the machi"},
                          {"niku_mm", 1.9, "bulge"},
                          {"mune_height_mm", 9, "half of"}}) {
        KatanaParameters p;
        set_katana_value(p, c.key, c.value, "test");
        try {
            make_katana(p, 0.002);
            ADD_FAILURE() << c.key << " = " << c.value << " was taken";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(c.said), std::string::npos) << error.what();
        }
    }
    KatanaParameters p;
    EXPECT_THROW(set_katana_value(p, "nagase_mm", 700.0, "test"), InputError);
    EXPECT_THROW(set_katana_value(p, "zukuri", 1.0, "test"), InputError);
    EXPECT_THROW(set_katana_value(p, "zukuri", "moroha", "test"), InputError);
    EXPECT_THROW(set_katana_value(p, "nagasa_mm", "long", "test"), InputError);
    EXPECT_THROW(katana_defaults("moroha"), InputError);
    for (const double detail : {0.0, -1.0, 100.0, nan, infinity})
        EXPECT_THROW(make_katana(p, detail), InputError);
}

TEST(Katana, PresetsAreLegalAndTrue) {
    int found = 0;
    for (const EmbeddedFile& file : embedded_files()) {
        if (!file.path.starts_with("blades/")) continue;
        ++found;
        SCOPED_TRACE(std::string(file.path));
        const KatanaPreset preset = parse_katana_preset(file.text, file.path);
        const KatanaMesh mesh = make_katana(preset.parameters, 0.3);
        check_closed(mesh);
        check_measures(mesh, preset.parameters, 0.05);
        EXPECT_LE(measure_katana(mesh, preset.parameters).at("uv_stretch_percent"), 2.0);
    }
    EXPECT_GE(found, 5);
}

TEST(Katana, BadPresetsAreRefused) {
    const std::string head = "title = \"t\"\nsource = \"s\"\nlicence = \"l\"\n";
    EXPECT_NO_THROW(parse_katana_preset(head + "[katana]\n", "x.toml"));
    for (const std::string& text :
         {std::string("title = "), std::string("[katana]\n"), head,
          head + "[katana]\nnagase_mm = 3\n", head + "[katana]\nnagasa_mm = \"3\"\n",
          head + "[katana]\nnagasa_mm = nan\n", head + "[katana]\nnagasa_mm = [3]\n",
          head + "[katana]\nzukuri = 3\n", head + "extra = 1\n[katana]\n",
          head + "[katana]\nsori_mm = 400\n", std::string("\0\x01\xff", 3)}) {
        try {
            parse_katana_preset(text, "x.toml");
            ADD_FAILURE() << text;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("x.toml"), std::string::npos);
        }
    }
}

}  // namespace
}  // namespace togishi
