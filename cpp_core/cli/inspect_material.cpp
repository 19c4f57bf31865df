#include "brdf/material.hpp"
#include "cli/inspect.hpp"
#include "spectral/metal.hpp"

namespace togishi::cli {

nlohmann::ordered_json inspect_material(const std::filesystem::path& path) {
    const auto material = load_material(path.string());
    (void)find_metal(
        material.metal);  // a check of its own: the file names it, this program must know it
    nlohmann::ordered_json facts{
        {"kind", "material"},
        {"name", material.name},
        {"metal", material.metal},
        {"weights", material.weights == Weights::measured ? "measured" : "normalised"},
        {"source", material.source},
        {"licence", material.licence}};
    for (const auto& field : material_lobes) {
        const auto& lobe = material.*field.member;
        facts[std::string(field.key) + "_mu_deg"] = {lobe.mu_t_deg, lobe.mu_b_deg};
    }
    facts["checks"] = "passed";
    return facts;
}

}  // namespace togishi::cli
