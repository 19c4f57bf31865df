// A blade's material: which metal, and how each part of the blade was polished.
//
// TOML file and Python dict have the same keys. All lengths of lobes are half widths in degrees.
//
// | key                  | type   | range           | meaning |
// |----------------------|--------|-----------------|---------|
// | format               | int    | 1               | version of this schema |
// | name                 | string | not empty       | for people |
// | metal                | string |                 | as find_metal takes it (spectral/metal.hpp) |
// | weights              | string |                 | "normalised" or "measured" |
// | source, licence      | string | may be missing  | where the figures come from |
// | parts.<part>         | table  | all seven       | ji shinogi_ji mune kissaki ha hadori nakago |
// | ... mu_t_deg         | number | 0.001 to 80     | half width along the wide axis |
// | ... mu_b_deg         | number | mu_t_deg/100 to mu_t_deg, at least 0.001 | narrow axis |
// | ... rho_deg          | number | 0 to 180        | wide axis from T; strokes at rho + 90 |
// | ... chi              | number | > 0 to 1e8      | measured: ji, shinogi_ji, mune, kissaki |
// | ... beta             | number | > 0 to 1e8      | measured: ha, hadori |
// | nakago.albedo_rgb    | list   | 3 x 0 to 1      | linear Rec.709 |
// | nakago.ior           | number | 1 to 4          | of its gloss |
// | fit.ji, fit.ha       | table  | may be missing  | how the part was measured
// (brdf/fit_record.hpp) |
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "brdf/fit_record.hpp"

namespace togishi {

inline constexpr int material_format = 1;

/// normalised: the weight follows from the roughness; measured: constants chi and beta as fitted.
enum class Weights { normalised, measured };

/// One part's lobe. weight: chi or beta where measured; -1 (as the shared formulas have it) where
/// normalised.
struct MaterialLobe {
    double mu_t_deg = 1;
    double mu_b_deg = 1;
    double rho_deg = 0;  ///< in [0, 180); 180 is read as 0
    double weight = -1;
    friend bool operator==(const MaterialLobe&, const MaterialLobe&) = default;
};

struct Material {
    std::string name;
    std::string metal;
    Weights weights = Weights::normalised;
    std::string source;
    std::string licence;
    MaterialLobe ji, shinogi_ji, mune, kissaki, ha, hadori, nakago;
    std::array<double, 3> nakago_albedo_rgb{};
    double nakago_ior = 1.5;
    std::vector<FitRecord> fits;  ///< at most one for each of ji and ha
    friend bool operator==(const Material&, const Material&) = default;
};

/// One lobe of the schema: its key, where it lies, and the name of its measured weight ("" for
/// none).
struct MaterialLobeField {
    std::string_view key;
    MaterialLobe Material::*member;
    std::string_view weight_key;
};
inline constexpr std::array<MaterialLobeField, 7> material_lobes{{
    {"ji", &Material::ji, "chi"},
    {"shinogi_ji", &Material::shinogi_ji, "chi"},
    {"mune", &Material::mune, "chi"},
    {"kissaki", &Material::kissaki, "chi"},
    {"ha", &Material::ha, "beta"},
    {"hadori", &Material::hadori, "beta"},
    {"nakago", &Material::nakago, ""},
}};

/// Whether errors name the line: not where the text was made from something else.
enum class SourceLines { shown, hidden };

/// From TOML text; `where` names it in errors ("file.toml" becomes "file.toml:12"). Throws
/// InputError for text that is no TOML, an unknown or missing field, a wrong type, a value out of
/// range.
[[nodiscard]] Material material_from_toml(std::string_view text, const std::string& where,
                                          SourceLines lines = SourceLines::shown);

/// TOML text that material_from_toml reads back as an equal material.
[[nodiscard]] std::string material_to_toml(const Material& material);

/// A built-in preset by its name (builtin_materials), else a file. Throws InputError.
[[nodiscard]] Material load_material(const std::string& name_or_path);

/// Names of data/materials/*.toml without extension, the default first.
[[nodiscard]] std::vector<std::string> builtin_materials();
inline constexpr std::string_view default_material_name = "polished_katana";
[[nodiscard]] Material default_material();

}  // namespace togishi
