#include "spectral/light.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "spectral/daylight.hpp"
#include "spectral/embedded_data.hpp"
#include "spectral/file_cache.hpp"
#include "spectral/linear_table.hpp"

namespace togishi {

namespace {

// Second radiation constant hc/k, CODATA 2018, in nm K.
constexpr double radiation_c2_nm_k = 1.438776877e7;
constexpr double noise_share = 0.02;
// What the CIE recommends that colorimetry should cover at least (CIE 015:2018, 7.2).
constexpr double wanted_first_nm = 380.0;
constexpr double wanted_last_nm = 780.0;
constexpr double wanted_spacing_nm = 5.0;

std::string text_of(double value) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%g", value);
    return buffer.data();
}

double planck(double nm, double temperature_k) {
    constexpr double at_nm = 560.0;
    const double ratio = std::expm1(radiation_c2_nm_k / (at_nm * temperature_k)) /
                         std::expm1(radiation_c2_nm_k / (nm * temperature_k));
    const double r = at_nm / nm;
    return 100.0 * r * r * r * r * r * ratio;
}

// Gives `amount` at `nm` to its two neighbours among increasing wavelengths, in proportion.
void split_line(const std::vector<double>& wavelengths_nm, double nm, double amount,
                std::vector<double>& values) {
    if (wavelengths_nm.empty() || nm < wavelengths_nm.front() || nm > wavelengths_nm.back()) return;
    const auto above = std::upper_bound(wavelengths_nm.begin(), wavelengths_nm.end(), nm);
    const auto i = static_cast<std::size_t>(above - wavelengths_nm.begin()) - 1;
    if (above == wavelengths_nm.end()) {
        values[i] += amount;
        return;
    }
    const double t = (nm - wavelengths_nm[i]) / (wavelengths_nm[i + 1] - wavelengths_nm[i]);
    values[i] += (1.0 - t) * amount;
    values[i + 1] += t * amount;
}

bool finer_than(const TableSpectrum& table, double step_nm) {
    for (std::size_t i = 0; i + 1 < table.wavelengths_nm.size(); ++i) {
        const double spacing = table.wavelengths_nm[i + 1] - table.wavelengths_nm[i];
        if (spacing < step_nm * (1.0 - 1e-6)) return true;
    }
    return false;
}

struct Sampler {
    const Grid& grid;

    std::vector<double> operator()(const TableSpectrum& table) const {
        return finer_than(table, grid.step_nm)
                   ? linear_shared_out(table.wavelengths_nm, table.power, grid)
                   : linear_at(table.wavelengths_nm, table.power, grid.wavelengths_nm());
    }
    std::vector<double> operator()(const LineSpectrum& line) const {
        std::vector<double> values(grid.count, 0.0);
        split_line(grid.wavelengths_nm(), line.wavelength_nm, 1.0 / grid.step_nm, values);
        return values;
    }
    std::vector<double> operator()(const BlackbodySpectrum& body) const {
        std::vector<double> values(grid.count);
        for (std::size_t i = 0; i < grid.count; ++i)
            values[i] = planck(grid.wavelength_nm(i), body.temperature_k);
        return values;
    }
};

// The number behind "daylight:", "blackbody:" or "line:".
double parameter(std::string_view name, std::string_view text, double low, double high,
                 std::string_view unit) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() ||
        !(value >= low && value <= high)) {
        throw InputError("light \"" + std::string(name) + "\"", "number",
                         "\"" + std::string(text) + "\"",
                         text_of(low) + " to " + text_of(high) + " " + std::string(unit));
    }
    return value;
}

std::string known_lights() {
    std::string known;
    for (const auto& light : builtin_lights()) known += light->description().name + ", ";
    return known + "daylight:K, blackbody:K, line:NM, csv:FILE";
}

// Power of a user's table, checked; small negative values become zero and are counted.
std::vector<double> checked_power(const TableFile& table, std::vector<std::string>& notes) {
    std::vector<double> power = table.columns[1];
    const double peak = *std::max_element(power.begin(), power.end());
    std::size_t noisy = 0;
    for (std::size_t row = 0; row < power.size(); ++row) {
        if (power[row] < -noise_share * std::max(peak, 0.0)) {
            throw InputError(table.at(row), "power", text_of(power[row]),
                             "0 or more (noise down to -2 % of the peak is taken as 0)");
        }
        // Sums over the table must stay finite, and what is scaled away must not be all of it.
        if (power[row] > 1e100)
            throw InputError(table.at(row), "power", text_of(power[row]), "at most 1e100");
        if (power[row] < 0.0) {
            power[row] = 0.0;
            ++noisy;
        }
    }
    if (noisy > 0)
        notes.push_back(std::to_string(noisy) + " values below zero (noise) were taken as zero");
    return power;
}

void note_range_and_spacing(const TableSpectrum& table, std::vector<std::string>& notes) {
    const auto& nm = table.wavelengths_nm;
    auto shortfall = [&](double from, double to) {
        notes.push_back(
            "no data from " + text_of(from) + " to " + text_of(to) +
            " nm: taken as no light there" +
            (from < 700.0 && to > 400.0 ? ", within the 400 to 700 nm that are rendered" : ""));
    };
    if (nm.front() > wanted_first_nm) shortfall(wanted_first_nm, nm.front());
    if (nm.back() < wanted_last_nm) shortfall(nm.back(), wanted_last_nm);
    double widest = 0.0;
    for (std::size_t i = 0; i + 1 < nm.size(); ++i) {
        if (nm[i + 1] > grid_61.first_nm && nm[i] < grid_61.last_nm())
            widest = std::max(widest, nm[i + 1] - nm[i]);
    }
    if (finer_than(table, grid_full.step_nm)) {
        notes.emplace_back("resampled: rows closer than 1 nm were averaged over 1 nm");
    }
    if (widest > wanted_spacing_nm * (1.0 + 1e-6)) {
        notes.push_back("resampled: rows up to " + text_of(widest) +
                        " nm apart were joined by straight lines");
    }
}

}  // namespace

Light::Light(LightDescription description, SpectrumShape shape)
    : description_(std::move(description)), shape_(std::move(shape)) {
    const auto samples = sample(grid_61);
    if (std::none_of(samples.begin(), samples.end(), [](double s) { return s > 0.0; })) {
        throw InputError("light " + description_.name, "power from 400 to 700 nm",
                         "zero everywhere",
                         "a spectrum with light in that range (wavelengths in nm)");
    }
}

std::vector<double> Light::sample(const Grid& grid) const {
    return std::visit(Sampler{grid}, shape_);
}

std::vector<double> Light::power_at(const std::vector<double>& wavelengths_nm) const {
    if (const auto* line = std::get_if<LineSpectrum>(&shape_)) {
        std::vector<double> values(wavelengths_nm.size(), 0.0);
        split_line(wavelengths_nm, line->wavelength_nm, 1.0, values);
        return values;
    }
    if (const auto* table = std::get_if<TableSpectrum>(&shape_)) {
        return linear_at(table->wavelengths_nm, table->power, wavelengths_nm);
    }
    std::vector<double> values(wavelengths_nm.size());
    std::transform(wavelengths_nm.begin(), wavelengths_nm.end(), values.begin(), [&](double nm) {
        return planck(nm, std::get<BlackbodySpectrum>(shape_).temperature_k);
    });
    return values;
}

const std::vector<std::shared_ptr<const Light>>& builtin_lights() {
    static const auto lights = [] {
        // As a user would look for them; files not named here follow by name.
        constexpr std::array<std::string_view, 10> order{
            "D65", "D55", "D50", "A", "E", "FL11", "LED-B3", "LED-RGB1", "HPS", "LPS"};
        std::vector<std::shared_ptr<const Light>> all;
        for (const auto& file : embedded_files()) {
            if (!file.path.starts_with("lights/") || file.path == daylight_components_path)
                continue;
            auto table = parse_table(file.text, "data/" + std::string(file.path), "light", 2,
                                     TableMetadata::required);
            LightDescription description{std::string(table.value("name")),
                                         std::string(table.value("title")),
                                         std::string(table.value("source")),
                                         std::string(table.value("licence")),
                                         {}};
            all.push_back(std::make_shared<const Light>(
                std::move(description),
                TableSpectrum{std::move(table.columns[0]), std::move(table.columns[1])}));
        }
        std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
            return std::find(order.begin(), order.end(), a->description().name) <
                   std::find(order.begin(), order.end(), b->description().name);
        });
        return all;
    }();
    return lights;
}

Light light_from_csv(std::string_view text, const std::string& where, const std::string& name) {
    auto table = parse_table(text, where, "light", 2, TableMetadata::optional);
    auto or_else = [&](std::string_view key, std::string_view other) {
        const auto value = table.value(key);
        return std::string(value.empty() ? other : value);
    };
    LightDescription description{name,
                                 or_else("title", std::filesystem::path(where).filename().string()),
                                 or_else("source", "not stated in " + where),
                                 or_else("licence", "not stated"),
                                 {}};
    if (table.columns[0].back() < 100.0) {
        throw InputError(where, "wavelengths", "at most " + text_of(table.columns[0].back()),
                         "nanometres (these look like micrometres)");
    }
    if (!table.column_titles.empty()) {
        description.notes.push_back("\"" + table.column_titles + "\" was taken as column titles");
    }
    auto power = checked_power(table, description.notes);
    if (table.rows() == 1) {
        const double nm = table.columns[0][0];
        if (!(power[0] > 0.0 && nm >= grid_61.first_nm && nm <= grid_61.last_nm())) {
            throw InputError(table.at(0), "power from 400 to 700 nm", "zero everywhere",
                             "a spectrum with light in that range");
        }
        description.notes.emplace_back("one row only: taken as a spectral line");
        return {std::move(description), LineSpectrum{nm}};
    }
    TableSpectrum shape{std::move(table.columns[0]), std::move(power)};
    note_range_and_spacing(shape, description.notes);
    return {std::move(description), std::move(shape)};
}

std::shared_ptr<const Light> find_light(std::string_view name) {
    for (const auto& light : builtin_lights()) {
        if (light->description().name == name) return light;
    }
    const auto colon = name.find(':');
    const auto kind = name.substr(0, colon);
    const auto rest = colon == std::string_view::npos ? std::string_view{} : name.substr(colon + 1);
    const std::string full(name);
    const std::string value(rest);
    if (kind == "daylight") {
        const double cct_k = parameter(name, rest, daylight_min_cct_k, daylight_max_cct_k, "K");
        return std::make_shared<const Light>(
            LightDescription{
                full, "CIE daylight of " + value + " K", daylight_source(), daylight_licence(), {}},
            daylight(cct_k));
    }
    if (kind == "blackbody") {
        const double kelvin = parameter(name, rest, 500.0, 100000.0, "K");
        return std::make_shared<const Light>(LightDescription{full,
                                                              "Blackbody of " + value + " K",
                                                              "Planck's law, CODATA 2018 constants",
                                                              "formula",
                                                              {}},
                                             BlackbodySpectrum{kelvin});
    }
    if (kind == "line") {
        const double nm = parameter(name, rest, grid_61.first_nm, grid_61.last_nm(), "nm");
        return std::make_shared<const Light>(
            LightDescription{
                full, "Spectral line at " + value + " nm", "one wavelength", "formula", {}},
            LineSpectrum{nm});
    }
    if (kind == "csv" && !rest.empty()) {
        static FileCache<Light> files;
        const std::filesystem::path path(rest);
        return files.get(path, [&] {
            return std::make_shared<const Light>(
                light_from_csv(read_table_text(path), path.string(), full));
        });
    }
    throw InputError("light", "name", "\"" + full + "\"", known_lights());
}

}  // namespace togishi
