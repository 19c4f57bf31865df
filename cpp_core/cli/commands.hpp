// The subcommands of `togishi`. Each adds itself to the app and runs as its callback.
#pragma once
#include <CLI/CLI.hpp>

namespace togishi::cli {

/// Options that every subcommand knows.
struct Common {
    bool json = false;  ///< print one JSON object for machines instead of text for people
};

void add_spectrum_command(CLI::App& app, const Common& common);
void add_info_command(CLI::App& app, const Common& common);
void add_katana_command(CLI::App& app, const Common& common);
void add_bake_command(CLI::App& app, const Common& common);
void add_fit_command(CLI::App& app, const Common& common);
void add_simulate_scan_command(CLI::App& app, const Common& common);
void add_scan_command(CLI::App& app, const Common& common);
void add_capture_command(CLI::App& app, const Common& common);

// Below `togishi capture`.
void add_capture_diffuse_command(CLI::App& capture, const Common& common);
void add_capture_lights_command(CLI::App& capture, const Common& common);
void add_capture_project_command(CLI::App& capture, const Common& common);
void add_capture_simulate_command(CLI::App& capture, const Common& common);

}  // namespace togishi::cli
