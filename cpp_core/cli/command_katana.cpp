// togishi katana: a blade of given dimensions as a mesh file, and its measures.
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "blade/katana_file.hpp"
#include "cli/blade_options.hpp"
#include "cli/commands.hpp"

namespace togishi::cli {
namespace {

struct Options {
    BladeOptions blade;
    std::string output;
    double detail = 1;
};

void run(const Options& options, const Common& common) {
    const KatanaPreset blade = chosen_blade(options.blade);
    const KatanaMesh mesh = make_katana(blade.parameters, options.detail);
    const std::map<std::string, double> measures = measure_katana(mesh, blade.parameters);
    write_katana_mesh(options.output, mesh);
    if (common.json) {
        nlohmann::ordered_json report;
        report["file"] = options.output;
        report["title"] = blade.title;
        report["parameters"] = json_of(blade.parameters);
        report["measures"] = measures;
        std::cout << report.dump(2) << '\n';
        return;
    }
    std::cout << blade.title << ": " << options.output << '\n';
    for (const auto& [key, value] : measures) {
        std::cout << "  " << std::left << std::setw(26) << key << std::setprecision(9) << value
                  << '\n';
    }
}

}  // namespace

void add_katana_command(CLI::App& app, const Common& common) {
    auto options = std::make_shared<Options>();
    auto* command = app.add_subcommand(
        "katana", "Write a blade of given dimensions as a mesh (.ply or .obj, in mm)");
    command->add_option("-o,--output", options->output, "File to write: .ply or .obj")->required();
    command->add_option("--detail", options->detail, "Vertices: 1 gives some 50,000; 0.002 to 64")
        ->capture_default_str();
    add_blade_options(*command, options->blade);
    command->callback([options, &common] { run(*options, common); });
}

}  // namespace togishi::cli
