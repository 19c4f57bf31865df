// The [fit.<part>] tables of a material file.
#pragma once
#include <string>
#include <vector>

#include "brdf/fit_record.hpp"
#include "brdf/toml_reader.hpp"

namespace togishi::material_file {

/// From the table "fit" of a material. Throws InputError that names the field.
[[nodiscard]] std::vector<FitRecord> read_fit_records(const toml::table& fit, const Source& source);

/// Text that read_fit_records reads back as the same record.
[[nodiscard]] std::string fit_record_text(const FitRecord& record);

}  // namespace togishi::material_file
