// Scans from files of the formats that our own readers read, without any library.
#pragma once
#include <filesystem>

#include "mesh_file/read_mesh.hpp"

namespace togishi {

/// PLY, OBJ and STL as read_mesh() reads them; InputError for glTF.
[[nodiscard]] MeshFile read_own_mesh(const std::filesystem::path& path,
                                     const MeshLimits& limits = {});

}  // namespace togishi
