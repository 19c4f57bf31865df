#include "cli/commands.hpp"

namespace togishi::cli {

void add_info_command(CLI::App& app, const Common& common) {
    (void)app;
    (void)common;
}

}  // namespace togishi::cli
