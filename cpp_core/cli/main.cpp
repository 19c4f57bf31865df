// The `togishi` command. Exit codes: 0 done, 1 something failed here, 2 the input was wrong.
#include <exception>
#include <iostream>

#include "base/error.hpp"
#include "cli/commands.hpp"

int main(int argc, char** argv) {
    try {
        CLI::App app{"Togishi: Japanese swords as they really look, from measurements."};
        togishi::cli::Common common;
        app.add_flag("--json", common.json, "Print one JSON object instead of text");
        app.require_subcommand(1);
        app.fallthrough();
        togishi::cli::add_spectrum_command(app, common);
        togishi::cli::add_info_command(app, common);
        togishi::cli::add_katana_command(app, common);
        togishi::cli::add_bake_command(app, common);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : 2;
        }
        return 0;
    } catch (const togishi::InputError& error) {
        std::cerr << "togishi: " << error.what() << '\n';
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "togishi: " << error.what() << '\n';
        return 1;
    }
}
