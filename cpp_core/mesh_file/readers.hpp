// One reader per format; read_mesh() chooses. They stop at the first thing that cannot be believed.
#pragma once
#include <filesystem>
#include <string>

#include "mesh_file/byte_source.hpp"
#include "mesh_file/mesh_builder.hpp"
#include "mesh_file/read_mesh.hpp"

namespace togishi {

// Ours: no library of Debian's reads ten million triangles of a binary PLY in bounded memory (CGAL
// holds each polygon as a list of its own), and tinyobjloader takes "v 1 x 3" for 1 0 3 and has no
// vertex colours where it streams.

/// PLY 1.0: ascii and binary of both byte orders; elements vertex, face and tristrips; other
/// elements and properties are passed over.
void read_ply(ByteSource& source, MeshBuilder& builder, MeshFile& file);

/// OBJ: v (with colours after the coordinates) and f; everything else is passed over.
void read_obj(ByteSource& source, MeshBuilder& builder, MeshFile& file);

/// STL, ascii and binary. Its triangles have no common vertices: those at one place are welded.
void read_stl(ByteSource& source, MeshBuilder& builder, MeshFile& file);

/// ".ply", ".obj" or ".stl", as open_mesh() tells it.
void read_own_format(ByteSource& source, const std::string& format, MeshBuilder& builder,
                     MeshFile& file);

/// glTF 2.0 and GLB by tinygltf, which gets the file only after its promises were held against its
/// size: the triangles of the default scene, placed by its nodes.
void read_gltf(ByteSource& source, const std::filesystem::path& folder, MeshBuilder& builder,
               MeshFile& file);

}  // namespace togishi
