#include "brdf/fit_record_toml.hpp"

#include <algorithm>
#include <functional>
#include <limits>

namespace togishi::material_file {
namespace {

constexpr double largest = 1e300;
constexpr std::size_t most_entries = 100'000;

std::int64_t count(Reader& r, std::string_view key) {
    constexpr double most = 9e15;
    return static_cast<std::int64_t>(r.number(key, 0, most, "a whole number, 0 or more"));
}

double any(Reader& r, std::string_view key) {
    return r.number(key, -largest, largest, "a finite number");
}

double positive(Reader& r, std::string_view key) {
    return r.number(key, 0, largest, "a finite number, 0 or more");
}

bool truth(Reader& r, std::string_view key) {
    const toml::node& node = r.require(key, "true or false");
    const auto value = node.value_exact<bool>();
    if (!value) r.fail(node, key, text_of(node), "true or false");
    return *value;
}

const toml::array& list(Reader& r, std::string_view key) {
    const toml::node& node = r.require(key, "a list");
    const toml::array* array = node.as_array();
    if (array == nullptr) r.fail(node, key, text_of(node), "a list");
    if (array->size() > most_entries) {
        r.fail(node, key, std::to_string(array->size()) + " entries", "at most 100000");
    }
    return *array;
}

// Calls read for each table of a list of tables.
void tables(Reader& r, const std::string& prefix, std::string_view key, const Source& source,
            const std::function<void(Reader&)>& read) {
    if (r.find(key) == nullptr) return;
    for (const toml::node& node : list(r, key)) {
        if (!node.is_table()) r.fail(node, key, text_of(node), "tables");
        Reader entry(*node.as_table(), prefix + std::string(key) + ".", source);
        read(entry);
        entry.refuse_unknown();
    }
}

FitParameter read_parameter(Reader& r) {
    FitParameter p;
    p.name = r.text("name", "text", false);
    p.value = any(r, "value");
    p.sigma = positive(r, "sigma");
    p.unit = r.text("unit", "text", false);
    p.determined = truth(r, "determined");
    p.reason = r.text("reason", "text", true);
    p.text = r.text("text", "text", true);
    return p;
}

FitScanRecord read_scan(Reader& r) {
    FitScanRecord s;
    s.file = r.text("file", "text", false);
    s.incidence_deg = any(r, "incidence_deg");
    s.turn_deg = any(r, "turn_deg");
    s.readings = count(r, "readings");
    s.rms_sigma = positive(r, "rms_sigma");
    s.gain = positive(r, "gain");
    s.gain_sigma = positive(r, "gain_sigma");
    s.mu_eff_deg = positive(r, "mu_eff_deg");
    s.mu_eff_sigma_deg = positive(r, "mu_eff_sigma_deg");
    return s;
}

void read_correlations(Reader& r, FitRecord& record) {
    const toml::array& rows = list(r, "correlations");
    const std::size_t n = record.parameters.size();
    const std::string allowed = "a square of numbers from -1 to 1, a row for each parameter";
    const auto wrong = [&] { r.fail(rows, "correlations", "of another shape", allowed); };
    if (rows.size() != n) wrong();
    for (const toml::node& node : rows) {
        const toml::array* row = node.as_array();
        if (row == nullptr || row->size() != n) wrong();
        std::vector<double> values;
        for (const toml::node& cell : *row)
            values.push_back(r.checked_number(cell, "correlations", -1, 1, allowed));
        record.correlations.push_back(std::move(values));
    }
}

void read_metals(Reader& r, FitRecord& record) {
    const std::string allowed = "pairs of a metal's name and a number";
    for (const toml::node& node : list(r, "metals")) {
        const toml::array* pair = node.as_array();
        if (pair == nullptr || pair->size() != 2) r.fail(node, "metals", text_of(node), allowed);
        const auto name = pair->get(0)->value_exact<std::string>();
        if (!name) r.fail(node, "metals", text_of(node), allowed);
        record.metals.emplace_back(
            *name, r.checked_number(*pair->get(1), "metals", -largest, largest, allowed));
    }
}

FitRecord read_record(Reader& r, const std::string& prefix, const std::string& part,
                      const Source& source) {
    FitRecord record;
    record.part = part;
    record.model = r.text("model", "\"ji\" or \"hamon\"", false);
    if (record.model != (part == "ji" ? "ji" : "hamon")) {
        r.fail(*r.find("model"), "model", "\"" + record.model + "\"",
               part == "ji" ? "\"ji\"" : "\"hamon\"");
    }
    record.software = r.text("software", "text", false);
    record.metal = r.text("metal", "text", false);
    record.quantity = r.text("quantity", "text", false);
    record.calibration = r.text("calibration", "text", false);
    record.light = r.text("light", "text", false);
    record.noise_relative = positive(r, "noise_relative");
    record.noise_floor = positive(r, "noise_floor");
    record.noise_estimated = truth(r, "noise_estimated");
    record.chi2_reduced = positive(r, "chi2_reduced");
    record.bic = any(r, "bic");
    record.readings = count(r, "readings");
    record.outliers = count(r, "outliers");
    record.clipped = count(r, "clipped");
    read_metals(r, record);
    for (const toml::node& node : list(r, "notes")) {
        const auto note = node.value_exact<std::string>();
        if (!note) r.fail(node, "notes", text_of(node), "texts");
        record.notes.push_back(*note);
    }
    tables(r, prefix, "parameter", source,
           [&](Reader& entry) { record.parameters.push_back(read_parameter(entry)); });
    read_correlations(r, record);
    tables(r, prefix, "scan", source,
           [&](Reader& entry) { record.scans.push_back(read_scan(entry)); });
    tables(r, prefix, "input", source, [&](Reader& entry) {
        std::string file = entry.text("file", "text", false);
        record.inputs.emplace_back(std::move(file), entry.text("sha256", "text", false));
    });
    return record;
}

}  // namespace

std::vector<FitRecord> read_fit_records(const toml::table& fit, const Source& source) {
    Reader reader(fit, "fit.", source);
    std::vector<FitRecord> records;
    for (const char* part : {"ji", "ha"}) {
        if (reader.find(part) == nullptr) continue;
        const std::string prefix = "fit." + std::string(part) + ".";
        Reader record(reader.table(part), prefix, source);
        records.push_back(read_record(record, prefix, part, source));
        record.refuse_unknown();
    }
    reader.refuse_unknown();
    return records;
}

std::string fit_record_text(const FitRecord& record) {
    std::string text;
    const auto line = [&](std::string_view key, const std::string& value) {
        text += std::string(key) + " = " + value + "\n";
    };
    const auto words = [&](std::string_view key, const std::string& value) {
        line(key, quoted(value));
    };
    const auto number = [&](std::string_view key, double value) { line(key, number_text(value)); };
    const auto whole = [&](std::string_view key, std::int64_t value) {
        line(key, std::to_string(value));
    };
    const auto head = [&](std::string_view what) {
        text += "\n[[fit." + record.part + "." + std::string(what) + "]]\n";
    };
    text += "[fit." + record.part + "]\n";
    words("model", record.model);
    words("software", record.software);
    words("metal", record.metal);
    words("quantity", record.quantity);
    words("calibration", record.calibration);
    words("light", record.light);
    number("noise_relative", record.noise_relative);
    number("noise_floor", record.noise_floor);
    line("noise_estimated", record.noise_estimated ? "true" : "false");
    number("chi2_reduced", record.chi2_reduced);
    number("bic", record.bic);
    whole("readings", record.readings);
    whole("outliers", record.outliers);
    whole("clipped", record.clipped);
    std::string metals, notes, correlations;
    for (const auto& [name, bic] : record.metals)
        metals += (metals.empty() ? "[" : ", [") + quoted(name) + ", " + number_text(bic) + "]";
    line("metals", "[" + metals + "]");
    for (const std::string& note : record.notes)
        notes += (notes.empty() ? "" : ", ") + quoted(note);
    line("notes", "[" + notes + "]");
    for (const auto& row : record.correlations) {
        std::string cells;
        for (const double c : row) cells += (cells.empty() ? "" : ", ") + number_text(c);
        correlations += (correlations.empty() ? "\n  [" : ",\n  [") + cells + "]";
    }
    line("correlations", "[" + correlations + "]");
    for (const FitParameter& p : record.parameters) {
        head("parameter");
        words("name", p.name);
        number("value", p.value);
        number("sigma", p.sigma);
        words("unit", p.unit);
        line("determined", p.determined ? "true" : "false");
        if (!p.reason.empty()) words("reason", p.reason);
        if (!p.text.empty()) words("text", p.text);
    }
    for (const FitScanRecord& s : record.scans) {
        head("scan");
        words("file", s.file);
        number("incidence_deg", s.incidence_deg);
        number("turn_deg", s.turn_deg);
        whole("readings", s.readings);
        number("rms_sigma", s.rms_sigma);
        number("gain", s.gain);
        number("gain_sigma", s.gain_sigma);
        number("mu_eff_deg", s.mu_eff_deg);
        number("mu_eff_sigma_deg", s.mu_eff_sigma_deg);
    }
    for (const auto& [file, hash] : record.inputs) {
        head("input");
        words("file", file);
        words("sha256", hash);
    }
    return text;
}

}  // namespace togishi::material_file
