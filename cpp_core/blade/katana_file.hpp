// Blade presets (data/blades/*.toml) and mesh files.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "blade/katana_mesh.hpp"
#include "blade/katana_parameters.hpp"

namespace togishi {

struct KatanaPreset {
    std::string title;
    std::string source;
    std::string licence;
    KatanaParameters parameters;
};

/// TOML with title, source, licence and a table [katana] with the keys of katana_defaults; missing
/// dimensions take the default of its zukuri. `where` names the file in errors. Throws InputError.
KatanaPreset parse_katana_preset(std::string_view text, std::string_view where);

/// Writes by extension, whole or not at all. Throws InputError for other extensions and unwritable
/// folders. .obj: mm; corners keep their own normals and UVs, vertices stay shared (watertight);
/// one material per part. .ply: binary little endian, mm; x y z nx ny nz s t and s_mm t_mm per
/// vertex, so vertices are split where normals or UVs break; per face its vertex_indices and `part`
/// (shaders/shared/parts.glsl).
void write_katana_mesh(const std::filesystem::path& target, const BladeMesh& mesh);

}  // namespace togishi
