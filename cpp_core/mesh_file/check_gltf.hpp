// A glTF file held to its promises before another program reads it: Blender's importer, which makes
// arrays as large as an accessor says.
#pragma once
#include <filesystem>

#include "mesh_file/byte_source.hpp"
#include "mesh_file/read_mesh.hpp"

namespace togishi {

/// Throws InputError as read_gltf_parts() does, for buffer views outside of their buffers and for
/// accessors of more values than their views hold or than the limits allow.
void check_gltf(const std::filesystem::path& path, const MeshLimits& limits = {});

/// The same of a source; folder: where its buffers lie.
void check_gltf(ByteSource& source, const std::filesystem::path& folder, const MeshLimits& limits);

}  // namespace togishi
