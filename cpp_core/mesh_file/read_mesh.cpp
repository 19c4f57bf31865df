#include "mesh_file/read_mesh.hpp"

#include "mesh_file/open_mesh.hpp"
#include "mesh_file/readers.hpp"

namespace togishi {

MeshFile read_mesh(const std::filesystem::path& path, const MeshLimits& limits) {
    MeshFile file;
    open_mesh(path, [&](ByteSource& source, const std::string& format) {
        MeshBuilder builder(source.where(), limits);
        if (format == ".gltf") {
            read_gltf(source, path.parent_path(), builder, file);
        } else {
            read_own_format(source, format, builder, file);
        }
        file.mesh = builder.finish();
        file.polygons = builder.polygons();
    });
    return file;
}

}  // namespace togishi
