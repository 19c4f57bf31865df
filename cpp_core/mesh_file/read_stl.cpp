#include <array>
#include <bit>
#include <cstring>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/readers.hpp"

namespace togishi {
namespace {

constexpr std::uint64_t head_bytes = 84, row_bytes = 50;

std::uint32_t little_endian(const char* at) {
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8U | static_cast<unsigned char>(at[i]);
    return value;
}

void read_binary(ByteSource& source, MeshBuilder& builder, std::uint64_t count) {
    const auto cut_off = [&] {
        throw InputError(
            source.where(), "size", std::to_string(source.size()) + " bytes",
            "84 bytes and 50 for each of " + std::to_string(count) + " triangles; is it cut off?");
    };
    if (head_bytes + row_bytes * count > source.size()) cut_off();
    if (!source.skip(head_bytes)) cut_off();
    builder.expect(0, count);
    for (std::uint64_t t = 0; t < count; ++t) {
        const char* const row = source.take(row_bytes);
        if (row == nullptr) cut_off();
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            glm::dvec3 at;
            for (std::size_t i = 0; i < 3; ++i) {
                // After the normal.
                const std::uint32_t bits = little_endian(row + 12 + 12 * k + 4 * i);
                at[static_cast<int>(i)] = std::bit_cast<float>(bits);
            }
            corners[k] = builder.welded_vertex(at);
        }
        builder.triangle(corners[0], corners[1], corners[2]);
    }
}

class Text {
  public:
    Text(ByteSource& source, MeshBuilder& builder) : source_(source), builder_(builder) {}

    void read() {
        for (std::string_view word = source_.word(); !word.empty(); word = source_.word()) {
            if (word == "solid" || word == "endsolid") {
                source_.skip_line();  // a name of any words
            } else if (word == "facet") {
                facet();
            } else {
                refuse(word, "solid, facet or endsolid");
            }
        }
    }

  private:
    [[noreturn]] void refuse(std::string_view word, std::string_view allowed) const {
        throw InputError(source_.where() + ", line " + std::to_string(source_.line()), "text",
                         word.empty() ? "cut off" : shown(word), allowed);
    }
    void want(std::string_view word) {
        const std::string_view found = source_.word();
        if (found != word) refuse(found, word);
    }
    double number() {
        const std::string_view word = source_.word();
        const auto value = parse_number(word);
        if (!value) refuse(word, "a number with a decimal point");
        return *value;
    }
    void facet() {
        want("normal");
        // Some programs write "nan" for the normals of flat triangles: not used, so not refused.
        for (int i = 0; i < 3; ++i) (void)source_.word();
        want("outer");
        want("loop");
        std::array<std::uint32_t, 3> corners{};
        for (std::uint32_t& corner : corners) {
            want("vertex");
            glm::dvec3 at;
            for (int i = 0; i < 3; ++i) at[i] = number();
            corner = builder_.welded_vertex(at);
        }
        want("endloop");
        want("endfacet");
        builder_.triangle(corners[0], corners[1], corners[2]);
    }

    ByteSource& source_;
    MeshBuilder& builder_;
};

}  // namespace

void read_stl(ByteSource& source, MeshBuilder& builder, MeshFile& file) {
    const std::string_view start = source.peek(head_bytes);
    const std::uint64_t count = start.size() == head_bytes ? little_endian(&start[80]) : 0;
    // Binary files may begin with "solid" as well: their size tells.
    const bool exact =
        start.size() == head_bytes && source.size() == head_bytes + row_bytes * count;
    if (exact || !start.starts_with("solid")) {
        if (start.size() < head_bytes) {
            throw InputError(source.where(), "size", std::to_string(source.size()) + " bytes",
                             "84 bytes at least, or text that begins with solid");
        }
        file.format = "STL, binary";
        read_binary(source, builder, count);
    } else {
        file.format = "STL, ascii";
        Text(source, builder).read();
    }
}

}  // namespace togishi
