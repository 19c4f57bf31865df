#include "mesh_file/write_ply.hpp"

#include <bit>
#include <cstring>

#include "base/atomic_file.hpp"

namespace togishi {
namespace {

static_assert(std::endian::native == std::endian::little, "rows are written as they lie in memory");

/// Rows that are handed to the file in pieces of a megabyte.
class Rows {
  public:
    explicit Rows(AtomicFile& file) : file_(file) { buffer_.reserve(piece + 64); }
    template <class T>
    void add(const T& value) {
        const std::size_t at = buffer_.size();
        buffer_.resize(at + sizeof(T));
        std::memcpy(buffer_.data() + at, &value, sizeof(T));
    }
    void end_row() {
        if (buffer_.size() >= piece) flush();
    }
    void flush() {
        file_.write(buffer_);
        buffer_.clear();
    }

  private:
    static constexpr std::size_t piece = std::size_t{1} << 20U;
    AtomicFile& file_;
    std::string buffer_;
};

}  // namespace

void write_ply(const std::filesystem::path& path, const TriangleMesh& mesh,
               const std::string& comment, bool as_float) {
    AtomicFile file(path);
    std::string line;
    for (const char c : comment) line += c == '\n' || c == '\r' ? ' ' : c;
    const std::string type = as_float ? "float" : "double";
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    if (!line.empty()) header += "comment " + line + "\n";
    header += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
    for (const char axis : {'x', 'y', 'z'}) header += "property " + type + " " + axis + "\n";
    if (!mesh.colours.empty()) {
        for (const char* channel : {"red", "green", "blue", "alpha"})
            header += std::string("property uchar ") + channel + "\n";
    }
    header += "element face " + std::to_string(mesh.triangles.size()) +
              "\nproperty list uchar uint vertex_indices\nend_header\n";
    file.write(header);
    Rows rows(file);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const glm::dvec3 at = mesh.origin + glm::dvec3(mesh.positions[v]);
        if (as_float) {
            rows.add(glm::vec3(at));
        } else {
            rows.add(at);
        }
        if (!mesh.colours.empty()) rows.add(mesh.colours[v]);
        rows.end_row();
    }
    for (const Triangle& t : mesh.triangles) {
        rows.add(std::uint8_t{3});
        rows.add(t);
        rows.end_row();
    }
    rows.flush();
    file.commit();
}

}  // namespace togishi
