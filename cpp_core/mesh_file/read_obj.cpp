#include <array>
#include <charconv>
#include <cmath>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/readers.hpp"

namespace togishi {
namespace {

class Obj {
  public:
    Obj(ByteSource& source, MeshBuilder& builder) : source_(source), builder_(builder) {}

    void read() {
        for (std::string_view word = source_.word(); !word.empty(); word = source_.word()) {
            if (word == "v") {
                vertex();
            } else if (word == "f") {
                face();
            } else {
                other_ = other_ || word == "curv" || word == "surf" || word == "curv2";
                rest_of_line();
            }
        }
    }
    [[nodiscard]] bool has_other_surfaces() const { return other_; }

  private:
    [[nodiscard]] std::string place() const {
        return source_.where() + ", line " + std::to_string(source_.line());
    }

    /// A comment may end any line.
    std::string_view next() {
        const std::string_view word = source_.word_of_line();
        return word.starts_with('#') ? std::string_view{} : word;
    }
    void rest_of_line() {
        while (!source_.word_of_line().empty()) {
        }
    }

    /// x y z, then w or a colour of three channels from 0 to 1, or both.
    void vertex() {
        std::array<double, 7> value{};
        std::size_t count = 0;
        for (std::string_view word = next(); !word.empty(); word = next()) {
            const auto number = parse_number(word);
            if (!number || count == value.size()) {
                throw InputError(place(), "v", shown(word),
                                 "x y z as numbers, and a colour as three more");
            }
            value[count++] = *number;
        }
        if (count < 3) {
            throw InputError(place(), "v", std::to_string(count) + " numbers",
                             "x y z as numbers, and a colour as three more");
        }
        builder_.vertex({value[0], value[1], value[2]});
        rest_of_line();
        if (count < 6) return;
        Colour8 colour{0, 0, 0, 255};
        for (std::size_t i = 0; i < 3; ++i) {
            const double c = value[count - 3 + i];
            colour[i] = c >= 1 ? 255 : c > 0 ? static_cast<std::uint8_t>(std::lround(255 * c)) : 0;
        }
        builder_.colour(colour);
    }

    void face() {
        std::size_t count = 0;
        for (std::string_view word = next(); !word.empty(); word = next()) {
            if (count == corners_.size())
                throw InputError(place(), "corners", "more than 256", "3 to 256");
            corners_[count++] = index(word);
        }
        rest_of_line();
        if (count < 3) throw InputError(place(), "corners", std::to_string(count), "3 to 256");
        builder_.polygon({corners_.data(), count}, ++faces_);
    }

    /// "7", "7/1", "7//3", "-1": counted from 1, or back from the last vertex so far.
    std::uint32_t index(std::string_view word) const {
        std::int64_t value = 0;
        const char* const end = word.data() + word.size();
        const auto [last, error] = std::from_chars(word.data(), end, value);
        const auto known = static_cast<std::int64_t>(builder_.vertices());
        const bool good = error == std::errc() && (last == end || *last == '/') && value != 0 &&
                          value >= -known && value <= 0xfffffffeLL;
        if (!good) {
            throw InputError(place(), "vertex index", shown(word),
                             "1 to the number of vertices, or back from -1");
        }
        return static_cast<std::uint32_t>(value > 0 ? value - 1 : known + value);
    }

    ByteSource& source_;
    MeshBuilder& builder_;
    std::array<std::uint32_t, MeshBuilder::most_corners> corners_{};
    std::uint64_t faces_ = 0;
    bool other_ = false;
};

}  // namespace

void read_obj(ByteSource& source, MeshBuilder& builder, MeshFile& file) {
    file.format = "OBJ";
    Obj obj(source, builder);
    obj.read();
    if (obj.has_other_surfaces()) {
        file.notes.emplace_back("It holds curved surfaces (curv, surf) too; they are not read.");
    }
}

}  // namespace togishi
