#include "simulate_scan_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "base/error.hpp"
#include "base/random_normal.hpp"
#include "blade/katana_frame.hpp"

namespace togishi {
namespace {

// A rotation from four normal numbers: every pose as likely as any other.
glm::dmat3 random_rotation(RandomNormal& random) {
    glm::dvec4 q(random.normal(), random.normal(), random.normal(), random.normal());
    q /= glm::length(q);
    const double x = q.x;
    const double y = q.y;
    const double z = q.z;
    const double w = q.w;
    return {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
            {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
            {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
}

struct Soup {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles;
    std::vector<Part> part;

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, Part p) {
        triangles.push_back({a, b, c});
        part.push_back(p);
    }
    // Each triangle becomes four, with new vertices in the middle of its edges.
    void quarter() {
        std::unordered_map<std::uint64_t, std::uint32_t> middle;
        middle.reserve(triangles.size() * 3 / 2);
        auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
            const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
            const auto [found, made] =
                middle.try_emplace(key, static_cast<std::uint32_t>(positions.size()));
            if (made) positions.push_back(0.5 * (positions[a] + positions[b]));
            return found->second;
        };
        const std::vector<Triangle> whole = std::move(triangles);
        const std::vector<Part> whole_part = std::move(part);
        triangles.clear();
        part.clear();
        triangles.reserve(4 * whole.size());
        part.reserve(4 * whole.size());
        for (std::size_t f = 0; f < whole.size(); ++f) {
            const Triangle& t = whole[f];
            const std::uint32_t ab = middle_of(t[0], t[1]);
            const std::uint32_t bc = middle_of(t[1], t[2]);
            const std::uint32_t ca = middle_of(t[2], t[0]);
            add(t[0], ab, ca, whole_part[f]);
            add(ab, t[1], bc, whole_part[f]);
            add(ca, bc, t[2], whole_part[f]);
            add(ab, bc, ca, whole_part[f]);
        }
    }
    // A box with `cells` cells along each of its edges' longest direction, some mm each.
    void box(const glm::dvec3& low, const glm::dvec3& high, double cell_mm) {
        const glm::dvec3 size = high - low;
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            const int nu = std::max(1, static_cast<int>(size[u] / cell_mm));
            const int nv = std::max(1, static_cast<int>(size[v] / cell_mm));
            for (const bool top : {false, true}) {
                const auto first = static_cast<std::uint32_t>(positions.size());
                for (int j = 0; j <= nv; ++j) {
                    for (int i = 0; i <= nu; ++i) {
                        glm::dvec3 p(0);
                        p[axis] = top ? high[axis] : low[axis];
                        p[u] = low[u] + size[u] * i / nu;
                        p[v] = low[v] + size[v] * j / nv;
                        positions.push_back(p);
                    }
                }
                for (int j = 0; j < nv; ++j) {
                    for (int i = 0; i < nu; ++i) {
                        const auto a = first + static_cast<std::uint32_t>(j * (nu + 1) + i);
                        const auto b = a + 1;
                        const auto c = a + static_cast<std::uint32_t>(nu + 1);
                        const auto d = c + 1;
                        if (top) {
                            add(a, b, d, Part::other);
                            add(a, d, c, Part::other);
                        } else {
                            add(a, d, b, Part::other);
                            add(a, c, d, Part::other);
                        }
                    }
                }
            }
        }
    }
};

// Smooth noise: values on a lattice, blended over its cells. Of unit variance on the average.
class SmoothNoise {
  public:
    SmoothNoise(std::uint64_t seed, double cell_mm) : seed_(seed), cell_(cell_mm) {}
    [[nodiscard]] glm::dvec3 at(const glm::dvec3& p) const {
        const glm::dvec3 q = p / cell_;
        const glm::dvec3 base = glm::floor(q);
        const glm::dvec3 f = q - base;
        glm::dvec3 sum(0);
        double squares = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 o(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
            const glm::dvec3 w = o * f + (1.0 - o) * (1.0 - f);
            const double weight = w.x * w.y * w.z;
            const glm::dvec3 cell = base + o;
            auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(cell.x) * 73856093 ^
                                                  static_cast<std::int64_t>(cell.y) * 19349663 ^
                                                  static_cast<std::int64_t>(cell.z) * 83492791);
            RandomNormal random(seed_ * 0x9e3779b97f4a7c15U ^ key);
            sum += weight * glm::dvec3(random.normal(), random.normal(), random.normal());
            squares += weight * weight;
        }
        return sum / std::sqrt(squares);
    }

  private:
    std::uint64_t seed_;
    double cell_;
};

// Half thickness of the blade at a depth below the ridge, whatever the strip.
double half_thickness(const Section& s, double d) {
    if (d <= s.corner_d.v) return s.corner_d.v > 0 ? s.corner_y.v * d / s.corner_d.v : s.corner_y.v;
    if (d <= s.shinogi_d.v)
        return std::lerp(s.corner_y.v, s.shinogi_y.v,
                         (d - s.corner_d.v) / (s.shinogi_d.v - s.corner_d.v));
    const double g = std::min(1.0, (d - s.shinogi_d.v) / (s.edge_d.v - s.shinogi_d.v));
    return std::lerp(s.shinogi_y.v, 0.0, g) + 4 * s.niku.v * g * (1 - g);
}

constexpr double habaki_from_mm = 2;
constexpr double habaki_to_mm = 28;

// The habaki: a collar 1.2 mm off the blade, closed towards it at both ends.
void add_habaki(Soup& soup, const KatanaShape& shape, double cell_mm) {
    constexpr double from_mm = habaki_from_mm;
    constexpr double to_mm = habaki_to_mm;
    constexpr double stand_off_mm = 1.2;
    const auto rows = static_cast<std::uint32_t>(std::max(4.0, (to_mm - from_mm) / cell_mm)) + 2;
    constexpr std::uint32_t columns = 48;
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (std::uint32_t r = 0; r <= rows; ++r) {
        const bool lip = r == 0 || r == rows;
        const double arc = from_mm + (to_mm - from_mm) *
                                         static_cast<double>(std::clamp(r, 1U, rows - 1) - 1) /
                                         (rows - 2);
        const Section s = shape.section(Stretch::blade, Dual(arc));
        const MuneLine::Point line = shape.mune_line().at(arc);
        const double off = lip ? -0.2 : stand_off_mm;
        for (std::uint32_t c = 0; c < columns; ++c) {
            // Down omote (+y) from the back, round the edge, up ura.
            const double turn = static_cast<double>(c) / columns;
            const double down = turn < 0.5 ? 2 * turn : 2 - 2 * turn;
            const double depth = s.edge_d.v * down;
            const double side = turn < 0.5 ? 1 : -1;
            const bool middle = c == 0 || 2 * c == columns;
            const double y = middle ? 0 : side * (half_thickness(s, depth) + off);
            const double d = std::lerp(-off, s.edge_d.v + off, down);
            const glm::dvec2 p = line.position_mm - d * glm::dvec2(-line.tangent.y, line.tangent.x);
            soup.positions.emplace_back(p.x, y, p.y);
        }
    }
    for (std::uint32_t r = 0; r < rows; ++r) {
        for (std::uint32_t c = 0; c < columns; ++c) {
            const std::uint32_t a = first + r * columns + c;
            const std::uint32_t b = first + r * columns + (c + 1) % columns;
            soup.add(a, a + columns, b + columns, Part::other);
            soup.add(a, b + columns, b, Part::other);
        }
    }
}

}  // namespace

KatanaParameters scan_shape(std::string_view name) {
    KatanaParameters p;
    if (name == "katana") return p;
    if (name == "long_katana") {
        p.nagasa_mm = 820;
        p.sori_mm = 27;
        p.sori_type = SoriType::koshi;
        p.mune = MuneType::mitsu;
        p.motohaba_mm = 32;
        p.sakihaba_mm = 19;
        p.motokasane_mm = 7.6;
        p.sakikasane_mm = 4.6;
        p.kissaki_mm = 28;
        p.nakago_mm = 235;
        return p;
    }
    if (name == "o_kissaki") {
        p.nagasa_mm = 695;
        p.sori_mm = 15;
        p.sori_type = SoriType::saki;
        p.mune = MuneType::maru;
        p.motohaba_mm = 32;
        p.sakihaba_mm = 25;
        p.kissaki_mm = 66;
        p.saki_shinogi_haba_mm = 8.6;
        p.mune_height_mm = 1.1;
        return p;
    }
    if (name == "wakizashi") {
        p.nagasa_mm = 455;
        p.sori_mm = 9;
        p.sori_type = SoriType::even;
        p.mune = MuneType::kaku;
        p.mune_height_mm = 0;
        p.motohaba_mm = 28;
        p.sakihaba_mm = 19;
        p.motokasane_mm = 6.2;
        p.sakikasane_mm = 4.2;
        p.moto_shinogi_haba_mm = 9.5;
        p.saki_shinogi_haba_mm = 6.8;
        p.kissaki_mm = 29;
        p.nakago_mm = 140;
        p.nakago_sakihaba_mm = 16;
        p.mekugi_ana_from_machi_mm = 48;
        p.nakago_jiri = Jiri::haagari;
        return p;
    }
    if (name == "shobu") return katana_defaults("shobu");
    if (name == "tanto") return katana_defaults("hira");
    throw InputError("scan_shape", "name", name, "a shape of scan_shapes");
}

ScanMesh simulate_scan_mesh(const KatanaParameters& parameters, const ScanMeshOptions& o) {
    ScanMesh scan;
    scan.parameters = parameters;
    // `detail` 1 has some 100,000 triangles.
    constexpr double finest = 60;
    const bool quartered = o.triangles > finest * 1e5;
    const KatanaMesh katana = make_katana(
        parameters, std::clamp(o.triangles / 1e5 * (quartered ? 0.25 : 1), 0.002, finest));
    scan.truth = measure_katana(katana, parameters);
    // The mesh's rows are too far apart to tell where the mune is deepest.
    const MuneLine mune = KatanaShape(parameters).mune_line();
    const double arc = mune.blade_arc_mm();
    double deepest = 0;
    for (int i = 0; i <= 20000; ++i) {
        const glm::dvec2 p = mune.at(arc * i / 20000).position_mm;
        if (p.y < deepest) {
            deepest = p.y;
            scan.truth["sori_at_mm"] = p.x;
        }
    }
    // The nakago's length as it is measured: from the mune-machi to its farthest point.
    double nakago = 0;
    for (std::size_t v = 0; v < katana.positions_mm.size(); ++v) {
        if (katana.s_mm[v] < 0) nakago = std::max(nakago, glm::length(katana.positions_mm[v]));
    }
    scan.truth["nakago_mm"] = nakago;
    RandomNormal random(o.seed);

    Soup soup;
    soup.positions = katana.positions_mm;
    struct Hole {
        double from_s_mm, to_s_mm, depth_mm;
    };
    std::vector<Hole> holes;
    for (int i = 0; i < o.edge_holes; ++i) {
        const double at = parameters.nagasa_mm * (0.1 + 0.75 * random.uniform());
        const double long_mm = 4 + 10 * random.uniform();
        const double deep_mm = 0.5 + 1.5 * random.uniform();
        holes.push_back({at, at + long_mm, deep_mm});
    }
    auto keep = [&](std::size_t face) {
        double s = 0;
        double t = 0;
        const auto from = static_cast<std::size_t>(katana.face_start[face]);
        const auto to = static_cast<std::size_t>(katana.face_start[face + 1]);
        for (std::size_t c = from; c < to; ++c) {
            const auto v = static_cast<std::size_t>(katana.corner_vertex[c]);
            s += katana.s_mm[v] / static_cast<double>(to - from);
            t += katana.t_mm[v] / static_cast<double>(to - from);
        }
        if (!o.tang && katana.face_part[face] == Part::nakago) return false;
        // What the habaki covers no scanner sees.
        if (o.habaki && s > habaki_from_mm + 0.5 && s < habaki_to_mm - 0.5) return false;
        if (o.keep_from > 0 && s < o.keep_from * parameters.nagasa_mm) return false;
        if (o.keep_to < 1 && s > o.keep_to * parameters.nagasa_mm) return false;
        const double edge = katana.frame.at(katana.frame.edge_mm, s);
        return std::none_of(holes.begin(), holes.end(), [&](const Hole& h) {
            return s > h.from_s_mm && s < h.to_s_mm && t > edge - h.depth_mm;
        });
    };
    for (std::size_t f = 0; f < katana.face_count(); ++f) {
        if (!keep(f)) continue;
        const auto from = static_cast<std::size_t>(katana.face_start[f]);
        const auto to = static_cast<std::size_t>(katana.face_start[f + 1]);
        for (std::size_t c = from + 1; c + 1 < to; ++c) {
            soup.add(static_cast<std::uint32_t>(katana.corner_vertex[from]),
                     static_cast<std::uint32_t>(katana.corner_vertex[c]),
                     static_cast<std::uint32_t>(katana.corner_vertex[c + 1]), katana.face_part[f]);
        }
    }
    if (quartered) soup.quarter();
    const double cell_mm = std::sqrt(1.4e5 / std::max(1000.0, o.triangles));
    if (o.habaki) add_habaki(soup, KatanaShape(parameters), cell_mm);
    if (o.stand) {
        for (const double x : {0.15, 0.75}) {
            const double at = x * parameters.nagasa_mm;
            soup.box({at, -30, -110}, {at + 25, 30, -60}, std::max(2.0, 2 * cell_mm));
        }
        soup.box({100, 60, -80}, {200, 62, -60}, std::max(2.0, 2 * cell_mm));
    }

    scan.rotation = o.random_pose ? random_rotation(random) : glm::dmat3(1);
    glm::dvec3 away(0);
    if (o.offset_mm > 0) {
        away = glm::dvec3(random.normal(), random.normal(), random.normal());
        away *= o.offset_mm / glm::length(away);
    }
    scan.origin = away / o.mm_per_unit;
    // Positions are told from a point near the middle, as a reader does.
    const glm::dvec3 middle(0.5 * parameters.nagasa_mm, 0, 0);
    scan.mesh.origin = scan.origin + scan.rotation * middle / o.mm_per_unit;
    const SmoothNoise smooth(o.seed, o.correlation_mm);
    const double white = o.noise_mm * std::sqrt(1 - o.correlated);
    const double common = o.noise_mm * std::sqrt(o.correlated);
    std::vector<std::int64_t> used(soup.positions.size(), -1);
    for (const Triangle& t : soup.triangles) {
        for (const std::uint32_t v : t) used[v] = 0;
    }
    for (std::size_t v = 0; v < soup.positions.size(); ++v) {
        if (used[v] < 0) continue;
        glm::dvec3 p = soup.positions[v];
        p += white * glm::dvec3(random.normal(), random.normal(), random.normal());
        if (common > 0) p += common * smooth.at(p);
        used[v] = static_cast<std::int64_t>(scan.mesh.positions.size());
        scan.mesh.positions.emplace_back(scan.rotation * (p - middle) / o.mm_per_unit);
    }
    scan.mesh.triangles.reserve(soup.triangles.size());
    for (const Triangle& t : soup.triangles) {
        scan.mesh.triangles.push_back({static_cast<std::uint32_t>(used[t[0]]),
                                       static_cast<std::uint32_t>(used[t[1]]),
                                       static_cast<std::uint32_t>(used[t[2]])});
    }
    scan.part = std::move(soup.part);
    return scan;
}

}  // namespace togishi
