// togishi fit: goniometer scans become a material that says how sure it is.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "cli/commands.hpp"
#include "fit/fit.hpp"
#include "fit/option_fields.hpp"
#include "image/picture_file.hpp"
#include "plot/fit_plot.hpp"
#include "scan/scan_file.hpp"

namespace togishi::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::vector<std::string> files;
    std::string output;
    std::string plots;  // folder
    std::string base{default_material_name};
    std::string name;
    std::vector<std::string> settings;  // key=value of the header
    std::string anisotropy = "auto", haze = "auto";
    bool curves = false;
    FitOptions fit;
};

FitChoice choice(const char* option, const std::string& value) {
    const auto found = std::find(fit_choice_names.begin(), fit_choice_names.end(), value);
    if (found == fit_choice_names.end())
        throw InputError(option, "argument", value, "off, on or auto");
    return static_cast<FitChoice>(found - fit_choice_names.begin());
}

ScanSettings settings_of(const std::vector<std::string>& assignments) {
    ScanSettings settings;
    for (const std::string& assignment : assignments) {
        const auto equals = assignment.find('=');
        if (equals == std::string::npos)
            throw InputError("--set", "argument", assignment, "KEY=VALUE, e.g. quantity=flux");
        settings.insert_or_assign(assignment.substr(0, equals), assignment.substr(equals + 1));
    }
    return settings;
}

Json json_of(const FitParameter& p) {
    return {{"name", p.name}, {"value", p.value},           {"sigma", p.sigma},
            {"unit", p.unit}, {"determined", p.determined}, {"reason", p.reason},
            {"text", p.text}};
}

Json curves_of(const ScanSet& scans, const Scan& scan, const FittedScan& fitted) {
    Json rows = Json::array();
    const std::size_t channels = scans.channels.size();
    for (std::size_t i = 0; i < scan.rows.size(); ++i) {
        for (std::size_t c = 0; c < channels; ++c) {
            const std::size_t at = i * channels + c;
            if (fitted.state[at] == ReadingState::gap) continue;
            rows.push_back({scan.rows[i].receive_deg, scan.rows[i].azimuth_deg, c,
                            scan.intensity[at], fitted.modelled[at], fitted.residual_sigma[at],
                            static_cast<int>(fitted.state[at])});
        }
    }
    return rows;
}

Json json_of(const Fit& fit, bool curves) {
    const FitRecord& r = fit.record;
    Json out{{"part", r.part},
             {"model", r.model},
             {"metal", r.metal},
             {"quantity", r.quantity},
             {"calibration", r.calibration},
             {"light", r.light},
             {"noise",
              {{"relative", r.noise_relative},
               {"floor", r.noise_floor},
               {"estimated", r.noise_estimated}}},
             {"chi2_reduced", r.chi2_reduced},
             {"bic", r.bic},
             {"readings", r.readings},
             {"outliers", r.outliers},
             {"clipped", r.clipped},
             {"seconds", fit.seconds},
             {"evaluations", fit.evaluations},
             {"metals", r.metals},
             {"notes", r.notes}};
    for (const FitParameter& p : r.parameters) out["parameters"].push_back(json_of(p));
    out["correlations"] = r.correlations;
    for (std::size_t s = 0; s < r.scans.size(); ++s) {
        const FitScanRecord& scan = r.scans[s];
        Json one{{"file", scan.file},
                 {"incidence_deg", scan.incidence_deg},
                 {"turn_deg", scan.turn_deg},
                 {"readings", scan.readings},
                 {"rms_sigma", scan.rms_sigma},
                 {"gain", scan.gain},
                 {"gain_sigma", scan.gain_sigma},
                 {"mu_eff_deg", scan.mu_eff_deg},
                 {"mu_eff_sigma_deg", scan.mu_eff_sigma_deg}};
        if (curves) {
            one["columns"] = {"receive_deg", "azimuth_deg",    "channel", "measured",
                              "modelled",    "residual_sigma", "state"};
            one["rows"] = curves_of(fit.scans, fit.scans.scans[s], fit.fitted[s]);
        }
        out["scans"].push_back(std::move(one));
    }
    for (const auto& [file, hash] : r.inputs)
        out["inputs"].push_back({{"file", file}, {"sha256", hash}});
    return out;
}

void print(const Fit& fit) {
    const FitRecord& r = fit.record;
    std::cout << r.part << " (" << r.model << ", " << r.metal << ", " << r.calibration
              << "): " << r.readings << " readings, reduced chi^2 " << std::setprecision(4)
              << r.chi2_reduced << '\n';
    for (const FitParameter& p : r.parameters) {
        std::cout << "  " << std::left << std::setw(20) << p.name << std::right << std::setw(12)
                  << std::setprecision(6) << p.value << " +- " << std::setw(10)
                  << std::setprecision(2) << p.sigma << ' ' << p.unit;
        if (!p.determined) std::cout << "  NOT DETERMINED";
        if (!p.reason.empty()) std::cout << " (" << p.reason << ": " << p.text << ')';
        std::cout << '\n';
    }
    for (const FitScanRecord& s : r.scans) {
        std::cout << "  incidence " << std::setprecision(6) << s.incidence_deg << ", turn "
                  << s.turn_deg << ": residual " << std::setprecision(3) << s.rms_sigma
                  << " sigma, gain " << std::setprecision(5) << s.gain << ", half width "
                  << s.mu_eff_deg << " deg\n";
    }
    for (const std::string& note : r.notes) std::cout << "  note: " << note << '\n';
}

// PART-scans.png and PART-half-width.png for each fit.
std::vector<std::string> write_plots(const std::vector<Fit>& fits,
                                     const std::filesystem::path& folder) {
    std::vector<std::string> files;
    const auto write = [&](const std::string& name, const Picture& picture) {
        write_png(folder / name, picture.width, picture.height, picture.rgb);
        files.push_back((folder / name).string());
    };
    for (const Fit& fit : fits) {
        write(fit.record.part + "-scans.png", plot_scans(fit));
        write(fit.record.part + "-half-width.png", plot_mu_eff(fit));
    }
    return files;
}

void run(Options o, const Common& common) {
    if (!o.plots.empty()) check_output_folder(std::filesystem::path(o.plots) / "ji-scans.png");
    if (!o.output.empty()) {
        if (!o.output.ends_with(".toml"))
            throw InputError("--output", "file name", o.output, "a name that ends in .toml");
        check_output_folder(o.output);
    }
    o.fit.anisotropy = choice("--anisotropy", o.anisotropy);
    o.fit.haze = choice("--haze", o.haze);
    const Material base = load_material(o.base);
    const std::vector<std::filesystem::path> files(o.files.begin(), o.files.end());
    const bool show = isatty(STDERR_FILENO) != 0;
    const FitProgress progress = [show](double done) {
        if (show) {
            std::cerr << "\rtogishi fit: " << std::setw(3) << static_cast<int>(100 * done) << " %"
                      << (done < 1 ? "" : "\n") << std::flush;
        }
        return true;
    };
    std::vector<Fit> fits;
    for (const ScanSet& scans : read_scans(files, settings_of(o.settings)))
        fits.push_back(fit_scans(scans, o.fit, progress));
    std::vector<const Fit*> all;
    all.reserve(fits.size());
    for (const Fit& fit : fits) all.push_back(&fit);
    if (!o.output.empty()) {
        const std::string name = !o.name.empty() ? o.name
                                 : !fits.front().scans.name.empty()
                                     ? fits.front().scans.name
                                     : std::filesystem::path(o.output).stem().string();
        write_text_file(o.output, material_to_toml(material_from_fits(all, base, name)));
    }
    const std::vector<std::string> plots =
        o.plots.empty() ? std::vector<std::string>{} : write_plots(fits, o.plots);
    if (common.json) {
        Json report;
        report["plots"] = plots;
        report["material"] = o.output.empty() ? Json(nullptr) : Json(o.output);
        for (const Fit& fit : fits) report["fits"].push_back(json_of(fit, o.curves));
        std::cout << report.dump(1, ' ', false, Json::error_handler_t::replace) << '\n';
        return;
    }
    for (const Fit& fit : fits) print(fit);
    if (!o.output.empty()) std::cout << "material: " << o.output << '\n';
    for (const std::string& file : plots) std::cout << "plot: " << file << '\n';
}

}  // namespace

void add_fit_command(CLI::App& app, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command =
        app.add_subcommand("fit", "Fit goniometer scans; write the material with its record");
    command
        ->add_option("files", o->files,
                     "Scan files (docs/measurement.md); those of one part are fitted together")
        ->required();
    command->add_option("-o,--output", o->output, "Material to write (.toml)");
    command->add_option("--plots", o->plots,
                        "Folder for pictures of the fit: PART-scans.png, PART-half-width.png");
    command->add_option("--base", o->base, "Material that the other parts come from")
        ->capture_default_str();
    command->add_option("--name", o->name, "Name of the material");
    command->add_option("--set", o->settings,
                        "KEY=VALUE of the scans' header, over what the files say");
    command->add_option("--metal", o->fit.metal,
                        "Metal, or auto: chosen by evidence (default: as the scans say)");
    command->add_option("--anisotropy", o->anisotropy, "Two half widths: off, on or auto")
        ->capture_default_str();
    command->add_option("--haze", o->haze, "A second, wider lobe: off, on or auto")
        ->capture_default_str();
    for (const auto& field : fit_option_fields()) {
        std::string name = "--" + std::string(field.name);
        std::replace(name.begin(), name.end(), '_', '-');
        if (const auto* flag = std::get_if<bool FitOptions::*>(&field.member)) {
            command->add_flag("--no-" + std::string(field.name) + "{false}", o->fit.*(*flag),
                              "Without: " + std::string(field.help));
        } else if (const auto* real = std::get_if<double FitOptions::*>(&field.member)) {
            command->add_option(name, o->fit.*(*real), std::string(field.help))
                ->capture_default_str();
        } else if (const auto* whole = std::get_if<int FitOptions::*>(&field.member)) {
            command->add_option(name, o->fit.*(*whole), std::string(field.help))
                ->capture_default_str();
        }
    }
    command->add_flag("--curves", o->curves, "With --json: every reading beside the model");
    command->callback([o, &common] { run(*o, common); });
}

}  // namespace togishi::cli
