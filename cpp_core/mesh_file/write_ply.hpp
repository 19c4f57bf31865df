// A mesh as a PLY file: pieces that were kept aside, tests, benchmarks.
#pragma once
#include <filesystem>
#include <string>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

/// Binary little-endian, whole or not at all. Coordinates as doubles with the origin added;
/// as_float: as floats, which is what most scanners write and loses what the origin keeps. comment:
/// one line for the header. Throws InputError as AtomicFile does.
void write_ply(const std::filesystem::path& path, const TriangleMesh& mesh,
               const std::string& comment = {}, bool as_float = false);

}  // namespace togishi
