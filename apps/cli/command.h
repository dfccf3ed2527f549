// The commands: each adds its options to the command line and runs with what they received.
#pragma once

#include "apps/cli/console.h"
#include "apps/cli/effect_chain.h"
#include "apps/cli/exit_code.h"
#include "sfumato/image.h"

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace sfumato::cli {

// The whole command line as it was typed, for provenance.
struct Invocation {
    std::string command_line;
    Verbosity verbosity;
};

// What a command returns: the exit code, or an error that has one.
using Outcome = Result<ExitCode>;

// Runs with the options that it was registered with.
using Command = std::function<Outcome(const Invocation&, Console&)>;

Command make_apply(CLI::App& app);
Command make_render(CLI::App& app);
Command make_view(CLI::App& app);
Command make_compare(CLI::App& app);
Command make_inspect(CLI::App& app);
Command make_list(CLI::App& app);

// Options that several commands have.
void add_chain_options(CLI::App& app, ChainOptions& options, std::string& save_config);
CLI::Option* add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& doc);

// WIDTHxHEIGHT, as --size takes it. Error (invalid_argument): another text, sides beyond 1 to 16384.
Result<Extent> parse_size(const std::string& text);

// Threads for coding files: both ends of the pipeline share the machine.
int coding_threads();

} // namespace sfumato::cli
