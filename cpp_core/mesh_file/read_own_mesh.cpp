#include "mesh_file/read_own_mesh.hpp"

#include "base/error.hpp"
#include "mesh_file/open_mesh.hpp"
#include "mesh_file/readers.hpp"

namespace togishi {

void read_own_format(ByteSource& source, const std::string& format, MeshBuilder& builder,
                     MeshFile& file) {
    if (format == ".ply") {
        read_ply(source, builder, file);
    } else if (format == ".obj") {
        read_obj(source, builder, file);
    } else if (format == ".stl") {
        read_stl(source, builder, file);
    } else {
        throw InputError(source.where(), "format", "glTF under another name",
                         "a glTF file's name ends in .gltf or .glb");
    }
}

MeshFile read_own_mesh(const std::filesystem::path& path, const MeshLimits& limits) {
    MeshFile file;
    open_mesh(path, [&](ByteSource& source, const std::string& format) {
        MeshBuilder builder(source.where(), limits);
        read_own_format(source, format, builder, file);
        file.mesh = builder.finish();
        file.polygons = builder.polygons();
    });
    return file;
}

}  // namespace togishi
