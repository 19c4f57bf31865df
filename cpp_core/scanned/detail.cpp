#include "scanned/detail.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace togishi {
namespace {

// Texels are gathered in bands of columns, which are independent of each other and small enough for
// a processor's cache.
constexpr std::size_t band_width = 128;

float linear_of(std::uint8_t code) {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (std::size_t i = 0; i < t.size(); ++i) {
            const double c = static_cast<double>(i) / 255;
            t[i] =
                static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
        }
        return t;
    }();
    return table[code];
}

std::uint8_t code_of(float linear) {
    const double c = std::clamp(double(linear), 0.0, 1.0);
    const double coded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * coded));
}

constexpr std::uint32_t nobody = 0xffffffffU;

// What the scan's pieces in one texel add up to.
struct Sum {
    std::uint32_t owner = nobody;  // the lighter mesh's triangle at the texel's centre
    float area = 0;                // of all pieces
    float own_area = 0;            // of those on the owner's own surface, not beyond a ridge
    float displacement = 0;
    glm::vec3 normal{0};
    glm::vec3 colour{0};
};

// Where a place of the chart lies on a triangle, and going on from it.
class Below {
  public:
    Below(const CornerMesh& mesh, std::uint32_t triangle, const glm::vec2& texel,
          const glm::vec2& size)
        : t_(mesh.triangles[triangle]) {
        const glm::vec2 from = mesh.uv[t_[0]] * size;
        const glm::vec2 e1 = mesh.uv[t_[1]] * size - from;
        const glm::vec2 e2 = mesh.uv[t_[2]] * size - from;
        const glm::vec2 d = texel - from;
        const float determinant = e1.x * e2.y - e2.x * e1.y;
        if (determinant == 0) return;
        a_ = (d.x * e2.y - e2.x * d.y) / determinant;
        b_ = (e1.x * d.y - d.x * e1.y) / determinant;
        inside_ = a_ >= slack && b_ >= slack && a_ + b_ <= 1 - slack;
    }
    [[nodiscard]] bool inside() const { return inside_; }
    [[nodiscard]] glm::vec3 mixed(const std::vector<glm::vec3>& values) const {
        return values[t_[0]] * (1 - a_ - b_) + values[t_[1]] * a_ + values[t_[2]] * b_;
    }

  private:
    static constexpr float slack = -1e-4F;
    const Triangle& t_;
    float a_ = 0, b_ = 0;
    bool inside_ = false;
};

// Which triangles reach into which band.
struct Bands {
    std::vector<std::size_t> first;  // of each band, and the end
    std::vector<std::uint32_t> triangles;
};

template <class Taken>
Bands sort_into_bands(const CornerMesh& mesh, std::size_t width, const Taken& taken) {
    const std::size_t count = (width + band_width - 1) / band_width;
    Bands bands;
    auto each = [&](auto&& visit) {
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
            if (!taken(f)) continue;
            const Triangle& t = mesh.triangles[f];
            const float low = std::min({mesh.uv[t[0]].x, mesh.uv[t[1]].x, mesh.uv[t[2]].x});
            const float high = std::max({mesh.uv[t[0]].x, mesh.uv[t[1]].x, mesh.uv[t[2]].x});
            auto band = [&](float u) {
                const float texel = std::clamp(u, 0.0F, 1.0F) * static_cast<float>(width);
                return std::min(static_cast<std::size_t>(texel) / band_width, count - 1);
            };
            for (std::size_t b = band(low); b <= band(high); ++b)
                visit(b, static_cast<std::uint32_t>(f));
        }
    };
    bands.first.assign(count + 1, 0);
    each([&](std::size_t b, std::uint32_t) { ++bands.first[b + 1]; });
    for (std::size_t b = 0; b < count; ++b) bands.first[b + 1] += bands.first[b];
    bands.triangles.resize(bands.first.back());
    std::vector<std::size_t> next(bands.first.begin(), bands.first.end() - 1);
    each([&](std::size_t b, std::uint32_t f) { bands.triangles[next[b]++] = f; });
    return bands;
}

// dP/du at each corner, at right angles to its normal: what Blender's tangents of a UV map are too.
std::vector<glm::vec3> chart_tangents(const CornerMesh& mesh) {
    std::vector<glm::vec3> tangents(mesh.source.size(), glm::vec3(0));
    for (const Triangle& t : mesh.triangles) {
        const glm::vec3 e1 = mesh.positions[t[1]] - mesh.positions[t[0]];
        const glm::vec3 e2 = mesh.positions[t[2]] - mesh.positions[t[0]];
        const glm::vec2 d1 = mesh.uv[t[1]] - mesh.uv[t[0]];
        const glm::vec2 d2 = mesh.uv[t[2]] - mesh.uv[t[0]];
        const float determinant = d1.x * d2.y - d2.x * d1.y;
        if (determinant == 0) continue;
        const glm::vec3 by_u = (e1 * d2.y - e2 * d1.y) / determinant;
        const float length = glm::length(by_u);
        if (!(length > 0) || !std::isfinite(length)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = t[k];
            const glm::vec3 a = mesh.positions[t[(k + 1) % 3]] - mesh.positions[v];
            const glm::vec3 b = mesh.positions[t[(k + 2) % 3]] - mesh.positions[v];
            const float angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
            tangents[v] += by_u * (angle / length);
        }
    }
    for (std::size_t v = 0; v < tangents.size(); ++v) {
        const glm::vec3 n = mesh.normals[v];
        glm::vec3 t = tangents[v] - n * glm::dot(n, tangents[v]);
        if (!(glm::length(t) > 0)) t = glm::cross(glm::vec3(0, 1, 0), n);
        const float length = glm::length(t);
        tangents[v] = length > 0 ? t / length : glm::vec3(1, 0, 0);
    }
    return tangents;
}

class Baker {
  public:
    Baker(const ChartedMesh& scan, const ChartedMesh& lighter, const BladeFrame& frame,
          const DetailOptions& options)
        : scan_(scan),
          frame_(frame),
          reach_(static_cast<float>(options.reach_mm)),
          threads_(options.threads),
          high_(split_corners(scan, frame, options.threads)),
          low_(split_corners(lighter, frame, options.threads)),
          tangents_(chart_tangents(low_)),
          lighter_(lighter) {
        maps_.width = options.width;
        maps_.height = options.height;
    }

    DetailMaps bake(std::size_t margin) {
        const std::size_t texels = maps_.width * maps_.height;
        maps_.normal.assign(texels, glm::vec3(0, 0, 1));
        maps_.displacement_mm.assign(texels, 0);
        if (!scan_.mesh.colours.empty()) maps_.colour.assign(texels, Colour8{0, 0, 0, 255});
        maps_.state.assign(texels, TexelState::outside);
        const Bands of_scan = sort_into_bands(high_, maps_.width, [&](std::size_t f) {
            if (scan_.region[f].part() == Part::other) return false;
            const Triangle& t = high_.triangles[f];
            return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
                return std::abs(scan_.off_mm[high_.source[v]]) <= reach_;
            });
        });
        const Bands of_lighter = sort_into_bands(low_, maps_.width, [&](std::size_t f) {
            return lighter_.region[f].part() != Part::other;
        });
        parallel_for(
            of_scan.first.size() - 1, 1,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Sum> sums;
                for (std::size_t b = begin; b < end; ++b) {
                    sums.assign(band_width * maps_.height, Sum{});
                    find_owners(b, of_lighter, sums);
                    gather(b, of_scan, sums);
                    write(b, sums);
                }
            },
            threads_);
        fill(margin);
        return std::move(maps_);
    }

  private:
    struct Columns {
        std::size_t begin, end;
    };
    [[nodiscard]] Columns columns(std::size_t band) const {
        return {band * band_width, std::min(maps_.width, (band + 1) * band_width)};
    }
    // Rows of one side: omote's below the middle, ura's above.
    [[nodiscard]] Columns rows(bool omote) const {
        const std::size_t half = maps_.height / 2;
        return omote ? Columns{0, half} : Columns{half, maps_.height};
    }
    static std::size_t into(float texel, const Columns& range) {
        const float low = static_cast<float>(range.begin);
        const float high = static_cast<float>(range.end - 1);
        return static_cast<std::size_t>(std::clamp(std::floor(texel), low, high));
    }

    // Each triangle by so many pieces that none is larger than half a texel.
    void gather(std::size_t band, const Bands& bands, std::vector<Sum>& sums) const {
        const Columns across = columns(band);
        const bool coloured = !maps_.colour.empty();
        const glm::vec2 size(static_cast<float>(maps_.width), static_cast<float>(maps_.height));
        for (std::size_t i = bands.first[band]; i < bands.first[band + 1]; ++i) {
            const std::uint32_t f = bands.triangles[i];
            const Triangle& t = high_.triangles[f];
            const std::array<glm::vec3, 3> p{high_.positions[t[0]], high_.positions[t[1]],
                                             high_.positions[t[2]]};
            const float area = 0.5F * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
            if (!(area > 0)) continue;
            const std::array<glm::vec2, 3> uv{high_.uv[t[0]] * size, high_.uv[t[1]] * size,
                                              high_.uv[t[2]] * size};
            const std::array<glm::vec3, 3> n{high_.normals[t[0]], high_.normals[t[1]],
                                             high_.normals[t[2]]};
            std::array<glm::vec3, 3> colour{};
            if (coloured) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const Colour8& c = scan_.mesh.colours[high_.source[t[k]]];
                    colour[k] = {linear_of(c[0]), linear_of(c[1]), linear_of(c[2])};
                }
            }
            const glm::vec2 low = glm::min(glm::min(uv[0], uv[1]), uv[2]);
            const glm::vec2 high = glm::max(glm::max(uv[0], uv[1]), uv[2]);
            const float extent = std::max(high.x - low.x, high.y - low.y);
            const int pieces = std::clamp(static_cast<int>(std::ceil(2 * extent)), 1, 8192);
            const float share = 1 / static_cast<float>(pieces);
            const float piece_area = area * share * share;
            const Columns up = rows(scan_.region[f].omote());
            const std::uint8_t surface = scan_.region[f].smooth_surface();
            auto add = [&](float a, float b) {
                const float c = 1 - a - b;
                const glm::vec2 at = uv[0] * c + uv[1] * a + uv[2] * b;
                const float x = std::floor(at.x);
                if (x < static_cast<float>(across.begin) || x >= static_cast<float>(across.end)) {
                    // The chart's very ends belong to its first and last column.
                    const bool first = across.begin == 0 && x < 0;
                    const bool last = across.end == maps_.width && x >= size.x;
                    if (!first && !last) return;
                }
                Sum& sum = sums[into(at.y, up) * band_width + into(at.x, across) - across.begin];
                sum.area += piece_area;
                if (coloured)
                    sum.colour += piece_area * (colour[0] * c + colour[1] * a + colour[2] * b);
                if (sum.owner == nobody || lighter_.region[sum.owner].smooth_surface() != surface) {
                    return;
                }
                const Below below(low_, sum.owner, at, size);
                sum.own_area += piece_area;
                sum.normal += piece_area * (n[0] * c + n[1] * a + n[2] * b);
                sum.displacement +=
                    piece_area *
                    glm::dot(p[0] * c + p[1] * a + p[2] * b - below.mixed(low_.positions),
                             glm::normalize(below.mixed(low_.normals)));
            };
            for (int row = 0; row < pieces; ++row) {
                for (int k = 0; k + row < pieces; ++k) {
                    const auto a = static_cast<float>(row);
                    const auto b = static_cast<float>(k);
                    add((a + 1.0F / 3) * share, (b + 1.0F / 3) * share);
                    if (k + row + 1 < pieces) add((a + 2.0F / 3) * share, (b + 2.0F / 3) * share);
                }
            }
        }
    }

    // Which triangle of the lighter mesh lies at each texel's centre.
    void find_owners(std::size_t band, const Bands& bands, std::vector<Sum>& sums) const {
        const Columns across = columns(band);
        const glm::vec2 size(static_cast<float>(maps_.width), static_cast<float>(maps_.height));
        for (std::size_t i = bands.first[band]; i < bands.first[band + 1]; ++i) {
            const std::uint32_t f = bands.triangles[i];
            const Triangle& t = low_.triangles[f];
            const Columns up = rows(lighter_.region[f].omote());
            const glm::vec2 low =
                size * glm::min(glm::min(low_.uv[t[0]], low_.uv[t[1]]), low_.uv[t[2]]);
            const glm::vec2 high =
                size * glm::max(glm::max(low_.uv[t[0]], low_.uv[t[1]]), low_.uv[t[2]]);
            const std::size_t x1 = into(high.x, across);
            const std::size_t y1 = into(high.y, up);
            for (std::size_t y = into(low.y, up); y <= y1; ++y) {
                for (std::size_t x = into(low.x, across); x <= x1; ++x) {
                    const Below below(low_, f, centre(x, y), size);
                    if (below.inside()) sums[y * band_width + x - across.begin].owner = f;
                }
            }
        }
    }

    void write(std::size_t band, const std::vector<Sum>& sums) {
        const Columns across = columns(band);
        const glm::vec2 size(static_cast<float>(maps_.width), static_cast<float>(maps_.height));
        for (std::size_t y = 0; y < maps_.height; ++y) {
            for (std::size_t x = across.begin; x < across.end; ++x) {
                const Sum& sum = sums[y * band_width + x - across.begin];
                const std::size_t texel = y * maps_.width + x;
                if (sum.owner == nobody || !(sum.area > 0)) {
                    if (is_hole(x, y)) maps_.state[texel] = TexelState::hole;
                    continue;
                }
                maps_.state[texel] = TexelState::measured;
                if (!maps_.colour.empty()) {
                    const glm::vec3 c = sum.colour / sum.area;
                    maps_.colour[texel] = {code_of(c.x), code_of(c.y), code_of(c.z), 255};
                }
                if (!(sum.own_area > 0)) continue;
                maps_.displacement_mm[texel] = sum.displacement / sum.own_area;
                const Below below(low_, sum.owner, centre(x, y), size);
                const glm::vec3 normal = glm::normalize(below.mixed(low_.normals));
                const glm::vec3 along = below.mixed(tangents_);
                const glm::vec3 tangent = glm::normalize(along - normal * glm::dot(normal, along));
                const glm::vec3 bitangent = glm::cross(tangent, normal);
                const glm::vec3 told(glm::dot(sum.normal, tangent), glm::dot(sum.normal, bitangent),
                                     glm::dot(sum.normal, normal));
                const float length = glm::length(told);
                if (told.z > 0 && std::isfinite(length)) maps_.normal[texel] = told / length;
            }
        }
    }

    [[nodiscard]] static glm::vec2 centre(std::size_t x, std::size_t y) {
        return {static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F};
    }

    // On the blade, and not only by a texel: the scan's own border is as uneven as its triangles.
    [[nodiscard]] bool is_hole(std::size_t x, std::size_t y) const {
        const auto w = static_cast<double>(maps_.width);
        const auto h = static_cast<double>(maps_.height);
        const double v = (static_cast<double>(y) + 0.5) / h;
        const ChartPoint at = frame_.locate((static_cast<double>(x) + 0.5) / w, v);
        const double texel_mm = std::max(frame_.length_mm() / w, frame_.chart_height_mm / h);
        const double least_mm = 1.5 * texel_mm;
        // Where the ridge opens, no blade lies between its two sides.
        const double open = frame_.at(frame_.lift_mm, at.s_mm);
        return at.part != Part::other && at.from_edge_mm > least_mm &&
               at.s_mm > least_mm - frame_.nakago_mm && at.s_mm < frame_.nagasa_mm - least_mm &&
               (open <= 0 || std::abs(v - 0.5) * frame_.chart_height_mm > open + texel_mm);
    }

    // Outwards from what was measured, ring by ring: holes to their end, the outside by a margin.
    void fill(std::size_t margin) {
        const std::size_t w = maps_.width;
        const std::size_t h = maps_.height;
        std::vector<std::uint8_t> filled(w * h, 0);
        std::vector<std::uint32_t> ring;
        std::vector<std::uint32_t> next;
        for (std::size_t i = 0; i < w * h; ++i)
            filled[i] = maps_.state[i] == TexelState::measured ? 1 : 0;
        auto grow = [&](std::uint32_t from, std::size_t step) {
            const std::size_t x = from % w;
            const std::size_t y = from / w;
            auto visit = [&](std::size_t to) {
                if (filled[to] != 0) return;
                const bool hole = maps_.state[to] == TexelState::hole;
                if (!hole && step > margin) return;
                filled[to] = 1;
                if (!maps_.colour.empty()) maps_.colour[to] = maps_.colour[from];
                if (!hole && maps_.state[from] != TexelState::hole) {
                    maps_.normal[to] = maps_.normal[from];
                    maps_.displacement_mm[to] = maps_.displacement_mm[from];
                }
                next.push_back(static_cast<std::uint32_t>(to));
            };
            if (x > 0) visit(from - 1);
            if (x + 1 < w) visit(from + 1);
            if (y > 0) visit(from - w);
            if (y + 1 < h) visit(from + w);
        };
        for (std::size_t i = 0; i < w * h; ++i) {
            if (maps_.state[i] == TexelState::measured) grow(static_cast<std::uint32_t>(i), 1);
        }
        for (std::size_t step = 2; !next.empty(); ++step) {
            ring.swap(next);
            next.clear();
            for (const std::uint32_t from : ring) grow(from, step);
        }
    }

    const ChartedMesh& scan_;
    const BladeFrame& frame_;
    float reach_;
    unsigned threads_;
    CornerMesh high_, low_;
    std::vector<glm::vec3> tangents_;
    const ChartedMesh& lighter_;
    DetailMaps maps_;
};

}  // namespace

std::uint32_t DetailMaps::code(float component, std::uint32_t most) {
    const double x = std::clamp((double(component) + 1) / 2, 0.0, 1.0);
    return static_cast<std::uint32_t>(std::lround(x * most));
}

DetailMaps bake_detail(const ChartedMesh& scan, const ChartedMesh& lighter, const BladeFrame& frame,
                       const DetailOptions& options) {
    DetailOptions o = options;
    if (o.height == 0) {
        const double square =
            static_cast<double>(o.width) * frame.chart_height_mm / frame.length_mm();
        o.height = 64 * static_cast<std::size_t>(std::ceil(square / 64));
    }
    for (const std::size_t size : {o.width, o.height}) {
        if (size < 16 || size > 32768 || (size == o.height && size % 2 != 0)) {
            throw InputError("scanned blade", "texture size",
                             std::to_string(o.width) + " x " + std::to_string(o.height),
                             "16 to 32768 texels either way, an even height");
        }
    }
    return Baker(scan, lighter, frame, o).bake(o.margin);
}

}  // namespace togishi
