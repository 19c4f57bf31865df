#include "blade/katana_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <unordered_map>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace togishi {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the PLY writer copies numbers as they lie in memory");

// Text and bytes gathered and handed on in large pieces.
class Writer {
  public:
    explicit Writer(AtomicFile& file) : file_(file) {}
    template <typename Value>
    void raw(const Value& value) {
        static_assert(std::is_trivially_copyable_v<Value>);
        std::array<char, sizeof(Value)> bytes{};
        std::memcpy(bytes.data(), &value, sizeof(Value));
        text(std::string_view(bytes.data(), bytes.size()));
    }
    void text(std::string_view piece) {
        buffer_.append(piece);
        if (buffer_.size() > (1U << 20)) flush();
    }
    template <typename... Values>
    void print(const char* format, Values... values) {
        std::array<char, 200> line{};
        const int length = std::snprintf(line.data(), line.size(), format, values...);
        text(std::string_view(line.data(), static_cast<std::size_t>(length)));
    }
    /// Hands on what is left.
    void flush() {
        file_.write(buffer_);
        buffer_.clear();
    }

  private:
    AtomicFile& file_;
    std::string buffer_;
};

// What one vertex of a PLY file holds.
struct PlyVertex {
    std::int32_t vertex;
    std::array<float, 5> normal_uv;
    bool operator==(const PlyVertex&) const = default;
};
struct PlyVertexHash {
    std::size_t operator()(const PlyVertex& v) const {
        std::size_t h = std::hash<std::int32_t>{}(v.vertex);
        for (const float f : v.normal_uv) h = h * 1000003U ^ std::hash<float>{}(f);
        return h;
    }
};

void write_ply(Writer& out, const BladeMesh& mesh) {
    std::unordered_map<PlyVertex, std::int32_t, PlyVertexHash> known;
    std::vector<PlyVertex> vertices;
    std::vector<std::int32_t> corners;
    corners.reserve(mesh.corner_vertex.size());
    for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
        const glm::vec3& n = mesh.corner_normal[c];
        const glm::vec2& uv = mesh.corner_uv[c];
        const PlyVertex v{mesh.corner_vertex[c], {n.x, n.y, n.z, uv.x, uv.y}};
        const auto [place, fresh] = known.emplace(v, static_cast<std::int32_t>(vertices.size()));
        if (fresh) vertices.push_back(v);
        corners.push_back(place->second);
    }
    out.text(
        "ply\nformat binary_little_endian 1.0\ncomment Togishi katana, mm, +X to the tip, +Z to "
        "the mune\n");
    out.text("comment part:");
    for (std::size_t i = 0; i < part_names.size(); ++i) {
        out.text(" " + std::to_string(i) + "=" + std::string(part_names[i]));
    }
    out.print("\nelement vertex %zu\n", vertices.size());
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "s", "t", "s_mm", "t_mm"}) {
        out.print("property float %s\n", name);
    }
    out.print(
        "element face %zu\nproperty list uchar int vertex_indices\nproperty uchar "
        "part\nend_header\n",
        mesh.face_count());
    for (const PlyVertex& v : vertices) {
        const auto i = static_cast<std::size_t>(v.vertex);
        out.raw(glm::vec3(mesh.positions_mm[i]));
        out.raw(v.normal_uv);
        out.raw(mesh.s_mm[i]);
        out.raw(mesh.t_mm[i]);
    }
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto begin = static_cast<std::size_t>(mesh.face_start[f]);
        const auto end = static_cast<std::size_t>(mesh.face_start[f + 1]);
        out.raw(static_cast<std::uint8_t>(end - begin));
        for (std::size_t c = begin; c < end; ++c) out.raw(corners[c]);
        out.raw(static_cast<std::uint8_t>(mesh.face_part[f]));
    }
}

void write_obj(Writer& out, const BladeMesh& mesh) {
    out.text("# Togishi katana, mm, +X to the tip, +Z to the mune\no katana\n");
    for (const glm::dvec3& p : mesh.positions_mm) out.print("v %.6f %.6f %.6f\n", p.x, p.y, p.z);
    for (const glm::vec2& t : mesh.corner_uv) out.print("vt %.7f %.7f\n", t.x, t.y);
    for (const glm::vec3& n : mesh.corner_normal) out.print("vn %.6f %.6f %.6f\n", n.x, n.y, n.z);
    // By part, since a material lasts until the next is named.
    for (std::size_t part = 0; part < part_names.size(); ++part) {
        bool named = false;
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            if (static_cast<std::size_t>(mesh.face_part[f]) != part) continue;
            if (!named)
                out.print("g %s\nusemtl togishi_%s\n", part_names[part].data(),
                          part_names[part].data());
            named = true;
            out.text("f");
            for (std::int32_t c = mesh.face_start[f]; c < mesh.face_start[f + 1]; ++c) {
                out.print(" %d/%d/%d", mesh.corner_vertex[static_cast<std::size_t>(c)] + 1, c + 1,
                          c + 1);
            }
            out.text("\n");
        }
    }
}

}  // namespace

void write_katana_mesh(const std::filesystem::path& target, const BladeMesh& mesh) {
    std::string extension = target.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
        return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
    });
    if (extension != ".ply" && extension != ".obj") {
        throw InputError(target.string(), "file extension",
                         extension.empty() ? "missing" : extension, ".ply, .obj");
    }
    AtomicFile file(target);
    Writer out(file);
    if (extension == ".ply") {
        write_ply(out, mesh);
    } else {
        write_obj(out, mesh);
    }
    out.flush();
    file.commit();
}

}  // namespace togishi
