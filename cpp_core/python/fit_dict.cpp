#include "python/fit_dict.hpp"

namespace py = pybind11;

namespace togishi {

py::dict dict_from_fit_record(const FitRecord& record) {
    py::dict d;
    d["model"] = record.model;
    d["software"] = record.software;
    d["metal"] = record.metal;
    d["quantity"] = record.quantity;
    d["calibration"] = record.calibration;
    d["light"] = record.light;
    d["noise_relative"] = record.noise_relative;
    d["noise_floor"] = record.noise_floor;
    d["noise_estimated"] = record.noise_estimated;
    d["chi2_reduced"] = record.chi2_reduced;
    d["bic"] = record.bic;
    d["readings"] = record.readings;
    d["outliers"] = record.outliers;
    d["clipped"] = record.clipped;
    py::list metals, notes, correlations, parameters, scans, inputs;
    for (const auto& [name, bic] : record.metals) {
        py::list pair;
        pair.append(name);
        pair.append(bic);
        metals.append(pair);
    }
    for (const auto& note : record.notes) notes.append(note);
    for (const auto& row : record.correlations) {
        py::list cells;
        for (const double c : row) cells.append(c);
        correlations.append(cells);
    }
    for (const FitParameter& p : record.parameters) {
        py::dict entry;
        entry["name"] = p.name;
        entry["value"] = p.value;
        entry["sigma"] = p.sigma;
        entry["unit"] = p.unit;
        entry["determined"] = p.determined;
        entry["reason"] = p.reason;
        entry["text"] = p.text;
        parameters.append(entry);
    }
    for (const FitScanRecord& s : record.scans) {
        py::dict entry;
        entry["file"] = s.file;
        entry["incidence_deg"] = s.incidence_deg;
        entry["turn_deg"] = s.turn_deg;
        entry["readings"] = s.readings;
        entry["rms_sigma"] = s.rms_sigma;
        entry["gain"] = s.gain;
        entry["gain_sigma"] = s.gain_sigma;
        entry["mu_eff_deg"] = s.mu_eff_deg;
        entry["mu_eff_sigma_deg"] = s.mu_eff_sigma_deg;
        scans.append(entry);
    }
    for (const auto& [file, hash] : record.inputs) {
        py::dict entry;
        entry["file"] = file;
        entry["sha256"] = hash;
        inputs.append(entry);
    }
    d["metals"] = metals;
    d["notes"] = notes;
    d["correlations"] = correlations;
    d["parameter"] = parameters;
    d["scan"] = scans;
    d["input"] = inputs;
    return d;
}

}  // namespace togishi
