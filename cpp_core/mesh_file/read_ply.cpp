#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/readers.hpp"

namespace togishi {
namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
constexpr std::array<std::size_t, 8> type_size{1, 1, 2, 2, 4, 4, 4, 8};
std::size_t size_of(Type type) {
    return type_size[static_cast<std::size_t>(type)];
}

std::optional<Type> type_named(std::string_view name) {
    struct Name {
        std::string_view name;
        Type type;
    };
    constexpr std::array<Name, 16> names{{{"char", Type::i8},
                                          {"int8", Type::i8},
                                          {"uchar", Type::u8},
                                          {"uint8", Type::u8},
                                          {"short", Type::i16},
                                          {"int16", Type::i16},
                                          {"ushort", Type::u16},
                                          {"uint16", Type::u16},
                                          {"int", Type::i32},
                                          {"int32", Type::i32},
                                          {"uint", Type::u32},
                                          {"uint32", Type::u32},
                                          {"float", Type::f32},
                                          {"float32", Type::f32},
                                          {"double", Type::f64},
                                          {"float64", Type::f64}}};
    const auto* found =
        std::find_if(names.begin(), names.end(), [&](const Name& n) { return n.name == name; });
    if (found == names.end()) return std::nullopt;
    return found->type;
}

/// What a property is to us.
enum class Role : std::uint8_t { none, x, y, z, red, green, blue, alpha, corners };

Role role_of(std::string_view name) {
    struct Name {
        std::string_view name;
        Role role;
    };
    constexpr std::array<Name, 17> names{{{"x", Role::x},
                                          {"y", Role::y},
                                          {"z", Role::z},
                                          {"red", Role::red},
                                          {"green", Role::green},
                                          {"blue", Role::blue},
                                          {"alpha", Role::alpha},
                                          {"diffuse_red", Role::red},
                                          {"diffuse_green", Role::green},
                                          {"diffuse_blue", Role::blue},
                                          {"diffuse_alpha", Role::alpha},
                                          {"r", Role::red},
                                          {"g", Role::green},
                                          {"b", Role::blue},
                                          {"a", Role::alpha},
                                          {"vertex_indices", Role::corners},
                                          {"vertex_index", Role::corners}}};
    const auto* found =
        std::find_if(names.begin(), names.end(), [&](const Name& n) { return n.name == name; });
    return found == names.end() ? Role::none : found->role;
}

struct Property {
    Role role = Role::none;
    Type type = Type::f32;  ///< of a list: of its items
    bool list = false;
    Type count_type = Type::u8;
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Format { ascii, little, big };

struct Header {
    Format format = Format::ascii;
    std::vector<Element> elements;
};

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    while (!(line = trim(line)).empty()) {
        const auto end = std::min(line.find_first_of(" \t"), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
    return words;
}

Property read_property(const std::vector<std::string_view>& words, const std::string& where) {
    const auto type = [&](std::string_view name) {
        const auto found = type_named(name);
        if (!found) {
            throw InputError(where, "property type", shown(name),
                             "char, uchar, short, ushort, int, uint, float, double and their "
                             "names with bits");
        }
        return *found;
    };
    Property p;
    if (words.size() == 5 && words[1] == "list") {
        p.list = true;
        p.count_type = type(words[2]);
        p.type = type(words[3]);
        p.role = role_of(words[4]) == Role::corners ? Role::corners : Role::none;
        if (p.count_type == Type::f32 || p.count_type == Type::f64)
            throw InputError(where, "count type", shown(words[2]), "a whole number's type");
    } else if (words.size() == 3) {
        p.type = type(words[1]);
        p.role = role_of(words[2]) == Role::corners ? Role::none : role_of(words[2]);
    } else {
        throw InputError(where, "property", std::to_string(words.size()) + " words",
                         "property TYPE NAME, or property list TYPE TYPE NAME");
    }
    return p;
}

Header read_header(ByteSource& source) {
    Header header;
    bool has_format = false;
    constexpr std::size_t most_lines = 10'000, most_parts = 200;
    for (std::size_t number = 1; number <= most_lines; ++number) {
        const std::string where = source.where() + ", line " + std::to_string(number);
        if (source.left() == 0) break;
        const std::string line = source.line_text();
        const auto words = words_of(line);
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
        if (number == 1 && words[0] == "ply") continue;
        if (words[0] == "end_header") {
            if (!has_format) break;
            return header;
        }
        if (words[0] == "format" && words.size() == 3) {
            if (words[1] == "ascii") {
                header.format = Format::ascii;
            } else if (words[1] == "binary_little_endian") {
                header.format = Format::little;
            } else if (words[1] == "binary_big_endian") {
                header.format = Format::big;
            } else {
                throw InputError(where, "format", shown(words[1]),
                                 "ascii, binary_little_endian, binary_big_endian");
            }
            has_format = true;
        } else if (words[0] == "element" && words.size() == 3) {
            Element& element = header.elements.emplace_back();
            element.name = words[1];
            const char* const end = words[2].data() + words[2].size();
            const auto [last, error] = std::from_chars(words[2].data(), end, element.count);
            if (error != std::errc() || last != end)
                throw InputError(where, "count", shown(words[2]), "a whole number");
            if (header.elements.size() > most_parts)
                throw InputError(where, "elements", "more than 200", "at most 200");
        } else if (words[0] == "property" && !header.elements.empty()) {
            auto& properties = header.elements.back().properties;
            properties.push_back(read_property(words, where));
            if (properties.size() > most_parts)
                throw InputError(where, "properties", "more than 200", "at most 200");
        } else {
            throw InputError(where, "text", shown(line),
                             "format, comment, element, property, end_header");
        }
    }
    throw InputError(source.where(), "header", "cut off", "format, elements and end_header");
}

/// The least bytes that a row takes.
std::uint64_t least_row(const Element& element, Format format) {
    std::uint64_t bytes = 0;
    for (const Property& p : element.properties) {
        // In text a digit and what parts it from the next.
        bytes += format == Format::ascii ? 2 : size_of(p.list ? p.count_type : p.type);
        // A face has three corners at least; other lists may be empty.
        if (p.list && p.role == Role::corners && element.name == "face")
            bytes += 3 * (format == Format::ascii ? 2 : size_of(p.type));
    }
    return bytes;
}

void check_promises(const Header& header, const ByteSource& source) {
    // The last number of a text needs nothing after it.
    std::uint64_t left = source.left() + (header.format == Format::ascii ? 1 : 0);
    for (const Element& element : header.elements) {
        const std::uint64_t row = least_row(element, header.format);
        if (row == 0) continue;
        if (element.count > left / row) {
            throw InputError(source.where(), "element " + shown(element.name),
                             std::to_string(element.count) + " rows",
                             "at most " + std::to_string(left / row) +
                                 ", which the rest of the file has room for; is it cut off?");
        }
        left -= element.count * row;
    }
}

template <class T>
double loaded(const char* at, bool swap) {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), at, sizeof(T));
    if (swap) std::reverse(bytes.begin(), bytes.end());
    return static_cast<double>(std::bit_cast<T>(bytes));
}

/// Numbers one after the other, as they stand in the file.
class BinaryNumbers {
  public:
    BinaryNumbers(ByteSource& source, bool swap) : source_(source), swap_(swap) {}

    /// False at the file's end.
    bool next(Type type, double& value) {
        const char* const at = source_.take(size_of(type));
        if (at == nullptr) return false;
        switch (type) {
            case Type::i8:
                value = loaded<std::int8_t>(at, false);
                break;
            case Type::u8:
                value = loaded<std::uint8_t>(at, false);
                break;
            case Type::i16:
                value = loaded<std::int16_t>(at, swap_);
                break;
            case Type::u16:
                value = loaded<std::uint16_t>(at, swap_);
                break;
            case Type::i32:
                value = loaded<std::int32_t>(at, swap_);
                break;
            case Type::u32:
                value = loaded<std::uint32_t>(at, swap_);
                break;
            case Type::f32:
                value = loaded<float>(at, swap_);
                break;
            case Type::f64:
                value = loaded<double>(at, swap_);
                break;
        }
        return true;
    }
    bool skip(Type type, std::uint64_t count) { return source_.skip(count * size_of(type)); }

  private:
    ByteSource& source_;
    bool swap_;
};

class TextNumbers {
  public:
    explicit TextNumbers(ByteSource& source) : source_(source) {}

    bool next(Type /*type*/, double& value) {
        const std::string_view word = source_.word();
        if (word.empty()) return false;
        const auto number = parse_number(word);
        if (!number) {
            throw InputError(source_.where() + ", line " + std::to_string(source_.line()), "number",
                             shown(word), "a number with a decimal point");
        }
        value = *number;
        return true;
    }
    bool skip(Type type, std::uint64_t count) {
        double ignored = 0;
        for (; count > 0; --count) {
            if (!next(type, ignored)) return false;
        }
        return true;
    }

  private:
    ByteSource& source_;
};

std::uint8_t channel(double value, Type type) {
    const double scale = type == Type::f32 || type == Type::f64 ? 255.0
                         : type == Type::u16                    ? 1.0 / 257
                                                                : 1.0;
    const double scaled = value * scale;
    return scaled >= 255 ? 255 : scaled > 0 ? static_cast<std::uint8_t>(std::lround(scaled)) : 0;
}

template <class Numbers>
class Rows {
  public:
    Rows(const ByteSource& source, Numbers numbers, MeshBuilder& builder, std::uint64_t vertices)
        : source_(source), numbers_(numbers), builder_(builder), vertices_(vertices) {}

    void read(const Element& element) {
        element_ = &element;
        const bool vertices = element.name == "vertex";
        const bool faces = element.name == "face", strips = element.name == "tristrips";
        if (element.properties.empty()) return;
        for (row_ = 1; row_ <= element.count; ++row_) {
            if (vertices) {
                vertex();
            } else {
                face(faces, strips);
            }
        }
    }

  private:
    [[noreturn]] void cut_off() const {
        throw InputError(
            place(), "row",
            "cut off (the file ends after " + std::to_string(source_.offset()) + " bytes)",
            "all " + std::to_string(element_->count) + " rows that the header promises");
    }
    [[nodiscard]] std::string place() const {
        return source_.where() + ", " + element_->name + " " + std::to_string(row_);
    }
    double number(Type type) {
        double value = 0;
        if (!numbers_.next(type, value)) cut_off();
        return value;
    }
    std::uint64_t list_length(const Property& p) {
        const double count = number(p.count_type);
        if (!(count >= 0 && count < 4294967296.0 && count == std::floor(count)))
            throw InputError(place(), "list length", std::to_string(count), "a whole number");
        return static_cast<std::uint64_t>(count);
    }
    void pass_over(const Property& p) {
        if (!p.list) {
            (void)number(p.type);
        } else if (!numbers_.skip(p.type, list_length(p))) {
            cut_off();
        }
    }

    void vertex() {
        glm::dvec3 at(0);
        Colour8 colour{0, 0, 0, 255};
        bool coloured = false;
        for (const Property& p : element_->properties) {
            if (p.list || p.role == Role::none) {
                pass_over(p);
                continue;
            }
            const double value = number(p.type);
            if (p.role <= Role::z) {
                at[static_cast<int>(p.role) - static_cast<int>(Role::x)] = value;
            } else {
                colour[static_cast<std::size_t>(p.role) - static_cast<std::size_t>(Role::red)] =
                    channel(value, p.type);
                coloured = true;
            }
        }
        builder_.vertex(at);
        if (coloured) builder_.colour(colour);
    }

    std::uint32_t corner(Type type) {
        const double value = number(type);
        if (!(value >= 0 && value < static_cast<double>(vertices_) && value == std::floor(value))) {
            throw InputError(place(), "vertex index", std::to_string(value),
                             "0 to " + std::to_string(vertices_) + " - 1, counted from 0");
        }
        return static_cast<std::uint32_t>(value);
    }

    void face(bool is_face, bool is_strip) {
        for (const Property& p : element_->properties) {
            if (p.list && p.role == Role::corners && is_face) {
                const std::uint64_t count = list_length(p);
                if (count < 3 || count > MeshBuilder::most_corners)
                    throw InputError(place(), "corners", std::to_string(count), "3 to 256");
                for (std::uint64_t i = 0; i < count; ++i) corners_[i] = corner(p.type);
                builder_.polygon({corners_.data(), count}, row_);
            } else if (p.list && p.role == Role::corners && is_strip) {
                strip(p);
            } else {
                pass_over(p);
            }
        }
    }

    /// Every three in a row make a triangle, every other one turned; -1 begins anew.
    void strip(const Property& p) {
        const std::uint64_t count = list_length(p);
        std::uint64_t held = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            const double value = number(p.type);
            if (value == -1) {
                held = 0;
                continue;
            }
            if (!(value >= 0 && value < static_cast<double>(vertices_))) {
                throw InputError(place(), "vertex index", std::to_string(value),
                                 "0 to " + std::to_string(vertices_) + " - 1, counted from 0");
            }
            corners_[held % 3] = static_cast<std::uint32_t>(value);
            ++held;
            if (held < 3) continue;
            const std::uint32_t a = corners_[(held - 3) % 3], b = corners_[(held - 2) % 3];
            const std::uint32_t c = corners_[(held - 1) % 3];
            if (held % 2 == 1) {
                builder_.triangle(a, b, c);
            } else {
                builder_.triangle(b, a, c);
            }
        }
    }

    const ByteSource& source_;
    Numbers numbers_;
    MeshBuilder& builder_;
    std::uint64_t vertices_;
    const Element* element_ = nullptr;
    std::uint64_t row_ = 0;
    std::array<std::uint32_t, MeshBuilder::most_corners> corners_{};
};

template <class Numbers>
void read_elements(const Header& header, const ByteSource& source, Numbers numbers,
                   MeshBuilder& builder, std::uint64_t vertices) {
    Rows<Numbers> rows(source, numbers, builder, vertices);
    for (const Element& element : header.elements) rows.read(element);
}

const Element* element_named(const Header& header, std::string_view name,
                             const ByteSource& source) {
    const Element* found = nullptr;
    for (const Element& element : header.elements) {
        if (element.name != name) continue;
        if (found != nullptr)
            throw InputError(source.where(), "element " + shown(name), "there twice", "one");
        found = &element;
    }
    return found;
}

}  // namespace

void read_ply(ByteSource& source, MeshBuilder& builder, MeshFile& file) {
    const Header header = read_header(source);
    check_promises(header, source);
    const Element* const vertex = element_named(header, "vertex", source);
    const Element* const face = element_named(header, "face", source);
    int axes = 0;
    if (vertex != nullptr) {
        for (const Property& p : vertex->properties)
            axes += !p.list && p.role >= Role::x && p.role <= Role::z ? 1 : 0;
    }
    if (axes != 3) {
        throw InputError(source.where(), "vertex coordinates", std::to_string(axes),
                         "an element vertex with x, y and z");
    }
    builder.expect(vertex->count, face != nullptr ? face->count : 0);
    constexpr bool little = std::endian::native == std::endian::little;
    switch (header.format) {
        case Format::ascii:
            file.format = "PLY, ascii";
            read_elements(header, source, TextNumbers(source), builder, vertex->count);
            break;
        case Format::little:
            file.format = "PLY, binary little-endian";
            read_elements(header, source, BinaryNumbers(source, !little), builder, vertex->count);
            break;
        case Format::big:
            file.format = "PLY, binary big-endian";
            read_elements(header, source, BinaryNumbers(source, little), builder, vertex->count);
            break;
    }
}

}  // namespace togishi
