// The `togishi` command. Results go to stdout; progress and errors to stderr.
// Exit codes: 0 done, 1 something failed here, 2 the input was wrong.
#include <csignal>
#include <exception>
#include <iostream>

#include "base/error.hpp"
#include "cli/commands.hpp"

namespace {

constexpr int done = 0;
constexpr int failed = 1;
constexpr int wrong_input = 2;

int run(int argc, char** argv) {
    CLI::App app{"Togishi: Japanese swords as they really look, from measurements."};
    togishi::cli::Common common;
    app.add_flag("--json", common.json, "Print one JSON object instead of text");
    app.set_version_flag("--version", "togishi " TOGISHI_VERSION, "Print the version and exit");
    app.require_subcommand(1);
    app.fallthrough();
    app.footer("Exit codes: 0 done, 1 something failed here, 2 the input was wrong.");
    togishi::cli::add_spectrum_command(app, common);
    togishi::cli::add_info_command(app, common);
    togishi::cli::add_katana_command(app, common);
    togishi::cli::add_bake_command(app, common);
    togishi::cli::add_fit_command(app, common);
    togishi::cli::add_simulate_scan_command(app, common);
    togishi::cli::add_scan_command(app, common);
    togishi::cli::add_capture_command(app, common);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? done : wrong_input;
    }
    return done;
}

}  // namespace

int main(int argc, char** argv) {
    // A quota then fails the write, and we can say so, instead of killing us over a half file.
    std::signal(SIGXFSZ, SIG_IGN);
    try {
        const int code = run(argc, argv);
        // A full disk or a closed pipe shows itself only here.
        if (!std::cout.flush()) {
            throw togishi::InputError("standard output", "output", "not written whole (disk full?)",
                                      "a place with room for it");
        }
        return code;
    } catch (const togishi::InputError& error) {
        std::cerr << "togishi: " << error.what() << '\n';
        return wrong_input;
    } catch (const std::exception& error) {
        std::cerr << "togishi: " << error.what() << '\n';
        return failed;
    }
}
