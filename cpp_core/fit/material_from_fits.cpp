#include "base/error.hpp"
#include "brdf/model.hpp"
#include "fit/fit.hpp"

namespace togishi {
namespace {

constexpr double rad_per_deg = 0.017453292519943295769;

// What a lobe without a measured constant reflects with: the normalised weight.
double normalised_weight(const MaterialLobe& lobe) {
    const f64::Lobe stored = f64::lobe_from_mu(
        lobe.mu_t_deg * rad_per_deg, lobe.mu_b_deg * rad_per_deg, lobe.rho_deg * rad_per_deg);
    return f64::lobe_normalised_weight(f64::lobe_form(stored));
}

}  // namespace

Material material_from_fits(const std::vector<const Fit*>& fits, const Material& base,
                            const std::string& name) {
    Material material = base;
    if (!name.empty()) material.name = name;
    bool absolute = false;
    for (const Fit* fit : fits) absolute = absolute || fit->record.calibration == "absolute";
    if (absolute && material.weights == Weights::normalised) {
        material.weights = Weights::measured;
        for (const MaterialLobeField& field : material_lobes) {
            if (field.weight_key.empty()) continue;
            (material.*field.member).weight = normalised_weight(material.*field.member);
        }
    }
    for (std::size_t i = 0; i < fits.size(); ++i) {
        const Fit& fit = *fits[i];
        for (std::size_t j = 0; j < i; ++j) {
            if (fits[j]->record.part == fit.record.part) {
                throw InputError("fits", "part", fit.record.part + " twice", "one fit a part");
            }
        }
        MaterialLobe& lobe = fit.record.part == "ji" ? material.ji : material.ha;
        const double before = lobe.weight;
        lobe = fit.lobe;
        if (material.weights == Weights::normalised) {
            lobe.weight = -1;
        } else if (fit.record.calibration != "absolute") {
            // A relative factor says nothing about how much is reflected.
            lobe.weight = before < 0 ? before : normalised_weight(lobe);
        }
        material.metal = fit.record.metal;
        std::erase_if(material.fits, [&](const FitRecord& r) { return r.part == fit.record.part; });
        material.fits.push_back(fit.record);
        if (fit.record.part == "ji" && material.fits.size() > 1)
            std::swap(material.fits.front(), material.fits.back());
    }
    if (!fits.empty()) {
        // Where the rest comes from stays readable.
        material.source = "Goniometer fit (see fit); other parts: " + base.name +
                          (base.source.empty() ? "" : ", " + base.source);
    }
    return material;
}

}  // namespace togishi
