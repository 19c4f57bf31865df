// A glTF file as a library may have it: what its JSON promises is held against the file first,
// buffers are at hand, and what no mesh needs (pictures, materials, animations) is left out.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "mesh_file/byte_source.hpp"
#include "mesh_file/read_mesh.hpp"

namespace togishi {

struct GltfParts {
    std::string json;  ///< each buffer's uri is its number
    std::vector<std::vector<unsigned char>> buffers;
};

/// Throws InputError: chunks or buffers longer than what is there, JSON deeper or of more parts
/// than any mesh has, compression, buffers outside the file's own folder.
[[nodiscard]] GltfParts read_gltf_parts(ByteSource& source, const std::filesystem::path& folder,
                                        MeshFile& file);

}  // namespace togishi
