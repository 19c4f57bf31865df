// togishi simulate-scan: what a goniometer would measure of a material, as a scan file.
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "brdf/material.hpp"
#include "cli/commands.hpp"
#include "fit/option_fields.hpp"
#include "scan/scan_file.hpp"
#include "scan/simulate_scan.hpp"

namespace togishi::cli {
namespace {

struct Options {
    std::string output;
    std::string material{default_material_name};
    std::string part = "hamon";
    std::string protocol = "a";
    std::vector<double> incidences_deg, turns_deg, azimuths_deg;
    double receive_first_deg = 0, receive_last_deg = 0, step_deg = 0;
    std::string quantity = "radiance", calibration = "absolute";
    SimulationOptions simulation;
};

template <class Names>
std::size_t choice(const char* option, const std::string& value, const Names& names) {
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == value) return i;
        all += (i > 0 ? ", " : "") + std::string(names[i]);
    }
    throw InputError(option, "argument", value, all);
}

void run(const CLI::App& command, Options o, const Common& common) {
    check_output_folder(o.output);
    SimulationOptions& s = o.simulation;
    s.protocol = scan_protocol(o.protocol);
    if (!o.incidences_deg.empty()) s.protocol.incidences_deg = o.incidences_deg;
    if (!o.turns_deg.empty()) s.protocol.turns_deg = o.turns_deg;
    if (!o.azimuths_deg.empty()) s.protocol.azimuths_deg = o.azimuths_deg;
    if (command.count("--receive-first") > 0) s.protocol.receive_first_deg = o.receive_first_deg;
    if (command.count("--receive-last") > 0) s.protocol.receive_last_deg = o.receive_last_deg;
    if (command.count("--step") > 0) s.protocol.step_deg = o.step_deg;
    s.quantity = static_cast<ScanQuantity>(choice("--quantity", o.quantity, scan_quantity_names));
    s.calibration = static_cast<ScanCalibration>(
        choice("--calibration", o.calibration, scan_calibration_names));
    const auto part = static_cast<ScanPart>(choice("--part", o.part, scan_part_names));
    const ScanSet scans = simulate_scan(load_material(o.material), part, s);
    write_text_file(o.output, scans_to_text(scans));
    if (common.json) {
        nlohmann::ordered_json report{{"file", o.output},
                                      {"part", o.part},
                                      {"scans", scans.scans.size()},
                                      {"rows", scans.rows()},
                                      {"seed", s.seed}};
        std::cout << report.dump(2) << '\n';
    } else {
        std::cout << o.output << ": " << scans.scans.size() << " scans, " << scans.rows()
                  << " rows\n";
    }
}

}  // namespace

void add_simulate_scan_command(CLI::App& app, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command = app.add_subcommand(
        "simulate-scan",
        "Write the goniometer scans that a material would give, with stated errors");
    command->add_option("-o,--output", o->output, "Scan file to write (.csv)")->required();
    command->add_option("--material", o->material, "Built-in material or .toml file")
        ->capture_default_str();
    command->add_option("--part", o->part, "ji, or hamon: the material's ha")
        ->capture_default_str();
    command
        ->add_option("--protocol", o->protocol,
                     "a: incidence 45, receive 25 to 65, turned 0, 45, 135, 180; b: incidences 15 "
                     "to 65, not turned")
        ->capture_default_str();
    command->add_option("--incidence", o->incidences_deg,
                        "Incidences in degrees, instead of the protocol's");
    command->add_option("--turn", o->turns_deg,
                        "Turns of the sample in degrees, counter-clockwise");
    command->add_option("--azimuth", o->azimuths_deg,
                        "Azimuths of the detector in degrees, out of the plane of incidence");
    command->add_option("--receive-first", o->receive_first_deg, "First receive angle in degrees");
    command->add_option("--receive-last", o->receive_last_deg, "Last receive angle in degrees");
    command->add_option("--step", o->step_deg, "Step of the receive angle in degrees");
    command->add_option("--quantity", o->quantity, "radiance, flux or brdf")->capture_default_str();
    command->add_option("--calibration", o->calibration, "absolute, relative or per_scan")
        ->capture_default_str();
    command->add_option("--channel", o->simulation.channels,
                        "intensity, intensity_r, intensity_550nm, ...");
    command->add_option("--light", o->simulation.light, "Light spectrum")->capture_default_str();
    for (const SimulationField& field : simulation_fields()) {
        std::string name = "--" + std::string(field.name);
        std::replace(name.begin(), name.end(), '_', '-');
        command->add_option(name, o->simulation.*field.member, std::string(field.help))
            ->capture_default_str();
    }
    command->add_flag("--state-sigma", o->simulation.state_sigma, "Write the noise into the file");
    command->add_option("--seed", o->simulation.seed, "Of the random numbers")
        ->capture_default_str();
    command->callback([o, command, &common] { run(*command, *o, common); });
}

}  // namespace togishi::cli
