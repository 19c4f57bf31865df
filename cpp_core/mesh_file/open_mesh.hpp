// A scan's file, opened, and which format it has.
#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "mesh_file/byte_source.hpp"

namespace togishi {

/// format: ".ply", ".obj", ".stl" or ".gltf" (GLB too).
using MeshReader = std::function<void(ByteSource& source, const std::string& format)>;

/// Calls read. The format is told from the first bytes, then from the name's end. Throws
/// InputError: no such file, another format, memory that is not enough for what read asks for.
void open_mesh(const std::filesystem::path& path, const MeshReader& read);

}  // namespace togishi
