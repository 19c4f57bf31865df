// Scans from files: PLY, OBJ, STL, glTF and GLB. Only for the command line; inside Blender its own
// importers read.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/triangle_mesh.hpp"

namespace togishi {

/// What a file may ask for. Reading takes at most 0.08 GiB per million triangles beside the file's
/// own 50 MiB (glTF: and 3 times the file).
struct MeshLimits {
    std::uint64_t max_triangles = 60'000'000;
    std::uint64_t max_vertices = 60'000'000;
};

struct MeshFile {
    TriangleMesh mesh;   ///< unit: the file's; glTF: metres, as that format says
    std::string format;  ///< e.g. "PLY, binary little-endian"
    std::string unit;    ///< "m" where the format says so, else empty
    std::uint64_t polygons =
        0;  ///< faces of more than three corners, which were cut into triangles
    std::vector<std::string> notes;  ///< what the file holds that is not read, in sentences
};

/// The format is told from the first bytes, then from the name's end. Throws InputError that names
/// the file, the place in it (line, vertex, face), what was found and what is allowed: no such
/// file, another format, truncated, counts beyond the file's size or the limits, indices out of
/// range, coordinates that are no finite numbers below 1e9, no triangles.
[[nodiscard]] MeshFile read_mesh(const std::filesystem::path& path, const MeshLimits& limits = {});

}  // namespace togishi
