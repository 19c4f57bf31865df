// togishi capture: from photographs to property maps.
#include "cli/commands.hpp"

namespace togishi::cli {

void add_capture_command(CLI::App& app, const Common& common) {
    auto* capture = app.add_subcommand("capture", "From photographs to property maps");
    capture->require_subcommand(1);
    capture->fallthrough();
    add_capture_diffuse_command(*capture, common);
    add_capture_lights_command(*capture, common);
    add_capture_project_command(*capture, common);
    add_capture_simulate_command(*capture, common);
}

}  // namespace togishi::cli
