#include "mesh_file/open_mesh.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <new>

#include "base/error.hpp"
#include "base/text.hpp"

namespace togishi {
namespace {

constexpr const char* known_formats = "a mesh as PLY, OBJ, STL, glTF or GLB";

std::string lower_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

/// What the first bytes say wins over the name's end.
std::string format_of(std::string_view start, const std::filesystem::path& path) {
    if (start.starts_with("ply\n") || start.starts_with("ply\r")) return ".ply";
    if (start.starts_with("glTF")) return ".gltf";
    std::string extension = lower_extension(path);
    if (extension == ".glb" || extension == ".gltf") return ".gltf";
    if (extension == ".obj" || extension == ".stl") return extension;
    if (start.starts_with("solid")) return ".stl";
    return {};
}

}  // namespace

void open_mesh(const std::filesystem::path& path, const MeshReader& read) {
    const std::string where = path.string();
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status))
        throw InputError(where, "file", "missing", "an existing file: a mesh");
    if (!std::filesystem::is_regular_file(status))
        throw InputError(where, "file", "a folder or a device", known_formats);
    const std::uint64_t size = std::filesystem::file_size(path, error);
    std::ifstream in(path, std::ios::binary);
    if (!in || error) throw InputError(where, "file", "unreadable", "a file that you may read");

    ByteSource source(in, size, where);
    const std::string_view start = source.peek(16);
    const std::string format = format_of(start, path);
    if (format.empty()) {
        throw InputError(where, "format", start.empty() ? "an empty file" : shown(start),
                         known_formats);
    }
    try {
        read(source, format);
    } catch (const std::bad_alloc&) {
        throw InputError(where, "memory", "not enough for this mesh",
                         "80 MB for every million triangles; or a lighter mesh");
    }
}

}  // namespace togishi
