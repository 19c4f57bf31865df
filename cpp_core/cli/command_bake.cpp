#include "cli/commands.hpp"

namespace togishi::cli {

void add_bake_command(CLI::App& app, const Common& common) {
    (void)app;
    (void)common;
}

}  // namespace togishi::cli
