#include "mesh_file/check_gltf.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/gltf_promises.hpp"
#include "mesh_file/open_mesh.hpp"

namespace togishi {
namespace {

using nlohmann::json;

/// A whole number that is no larger than any file.
std::uint64_t number(const json& from, const char* name, std::uint64_t otherwise,
                     const std::string& where) {
    const auto found = from.find(name);
    if (found == from.end()) return otherwise;
    if (!found->is_number_unsigned() || found->get<double>() > 1e15)
        throw InputError(where, name, shown(found->dump()), "a whole number, 0 to 1e15");
    return found->get<std::uint64_t>();
}

std::uint64_t component_bytes(const json& accessor, const std::string& where) {
    const std::uint64_t type = number(accessor, "componentType", 0, where);
    switch (type) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            throw InputError(where, "componentType", std::to_string(type),
                             "5120 to 5123, 5125 or 5126");
    }
}

std::uint64_t components(const json& accessor, const std::string& where) {
    constexpr std::array<std::pair<std::string_view, std::uint64_t>, 7> types{{{"SCALAR", 1},
                                                                               {"VEC2", 2},
                                                                               {"VEC3", 3},
                                                                               {"VEC4", 4},
                                                                               {"MAT2", 4},
                                                                               {"MAT3", 9},
                                                                               {"MAT4", 16}}};
    const auto found = accessor.find("type");
    const std::string type =
        found != accessor.end() && found->is_string() ? found->get<std::string>() : std::string();
    for (const auto& [name, count] : types) {
        if (type == name) return count;
    }
    throw InputError(where, "type", shown(type), "SCALAR, VEC2 to VEC4, MAT2 to MAT4");
}

/// The entry that an index names.
const json& part(const json& root, const char* list, std::uint64_t index,
                 const std::string& where) {
    const auto found = root.find(list);
    if (found == root.end() || !found->is_array() || index >= found->size())
        throw InputError(where, list, std::to_string(index), "one that is there");
    return (*found)[index];
}

void check_view(const json& view, const json& root, const std::string& where) {
    const json& buffer = part(root, "buffers", number(view, "buffer", 0, where), where);
    const std::uint64_t size = number(buffer, "byteLength", 0, where);
    const std::uint64_t offset = number(view, "byteOffset", 0, where);
    const std::uint64_t length = number(view, "byteLength", 0, where);
    if (offset > size || length > size - offset) {
        throw InputError(where, "byteLength",
                         std::to_string(length) + " from " + std::to_string(offset),
                         "within the " + std::to_string(size) + " bytes of its buffer");
    }
}

void check_accessor(const json& accessor, const json& root, const MeshLimits& limits,
                    const std::string& where) {
    const std::uint64_t count = number(accessor, "count", 0, where);
    // Three corners a triangle.
    const std::uint64_t most = 3 * limits.max_triangles;
    if (count > most)
        throw InputError(where, "count", std::to_string(count), "at most " + std::to_string(most));
    if (!accessor.contains("bufferView") || accessor.contains("sparse")) {
        throw InputError(where, "bufferView", "missing, or sparse",
                         "a buffer view; sparse accessors are not read");
    }
    const json& view = part(root, "bufferViews", number(accessor, "bufferView", 0, where), where);
    const std::uint64_t row = component_bytes(accessor, where) * components(accessor, where);
    const std::uint64_t stride = number(view, "byteStride", row, where);
    const std::uint64_t length = number(view, "byteLength", 0, where);
    const std::uint64_t offset = number(accessor, "byteOffset", 0, where);
    const bool inside =
        stride >= row && stride <= 4096 && offset <= length &&
        (count == 0 || (row <= length - offset && count - 1 <= (length - offset - row) / stride));
    if (!inside) {
        throw InputError(
            where, "count", std::to_string(count),
            "no more than its buffer view of " + std::to_string(length) + " bytes holds");
    }
}

void check_numbers(const json& root, const MeshLimits& limits, const std::string& file) {
    for (const char* list : {"bufferViews", "accessors"}) {
        const auto found = root.find(list);
        if (found == root.end()) continue;
        if (!found->is_array())
            throw InputError(file, list, "not a list of objects", "a list of objects");
        for (std::size_t i = 0; i < found->size(); ++i) {
            if (list == std::string_view("accessors")) {
                check_accessor((*found)[i], root, limits, file + ", accessor " + std::to_string(i));
            } else {
                check_view((*found)[i], root, file + ", buffer view " + std::to_string(i));
            }
        }
    }
}

}  // namespace

void check_gltf(ByteSource& source, const std::filesystem::path& folder, const MeshLimits& limits) {
    MeshFile file;
    GltfParts parts = read_gltf_parts(source, folder, file);
    parts.buffers = {};
    check_numbers(json::parse(parts.json), limits, source.where());
}

void check_gltf(const std::filesystem::path& path, const MeshLimits& limits) {
    open_mesh(path, [&](ByteSource& source, const std::string& format) {
        if (format != ".gltf") {
            throw InputError(source.where(), "format", format + " under another name",
                             "a glTF file's name ends in .gltf or .glb");
        }
        check_gltf(source, path.parent_path(), limits);
    });
}

}  // namespace togishi
