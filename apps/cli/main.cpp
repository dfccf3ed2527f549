// sfumato: screen-space effects on rendered frames, from the command line.
#include "apps/cli/command.h"
#include "apps/cli/guarded.h"
#include "sfumato/context.h"

#include <algorithm>
#include <clocale>
#include <cstdio>
#include <fmt/format.h>
#include <string_view>

namespace sfumato::cli {

namespace {

struct Registered {
    const char* name;
    const char* summary;
    Command (*make)(CLI::App&);
};

constexpr Registered commands[] = {
    {"apply", "run effects on images or a sequence", make_apply},
    {"render", "render a built-in scene, with effects and ground truth", make_render},
    {"compare", "metrics of a picture against a reference", make_compare},
    {"view", "look at a scene and its effects in a window", make_view},
    {"inspect", "what an EXR holds, and what its channels mean", make_inspect},
    {"list", "effects, presets, parameters, devices, scenes", make_list},
};

std::string help_text() {
    std::string text = "Sfumato: screen-space effects on rendered frames, by Vulkan compute.\n\n"
                       "sfumato COMMAND [OPTION…]\n\n";
    for (const Registered& command : commands)
        text += fmt::format("  {:<9} {}\n", command.name, command.summary);
    return text + "\n  sfumato COMMAND --help   options of a command\n"
                  "  sfumato --version\n\n"
                  "  sfumato apply motion-blur shot.####.exr -o blur.####.exr --preset high";
}

std::string version_text() {
    return fmt::format("sfumato {}.{}.{}", SFUMATO_VERSION_MAJOR, SFUMATO_VERSION_MINOR, SFUMATO_VERSION_PATCH);
}

// Quoted where a shell would need it.
std::string command_line(const std::vector<std::string>& arguments) {
    std::string text = "sfumato";
    for (const std::string& argument : arguments) {
        const bool plain =
            !argument.empty() && argument.find_first_of(" \t\n\"'\\$`*?;&|<>()[]{}~!") == std::string::npos;
        text += plain ? " " + argument : " '" + argument + "'";
    }
    return text;
}

std::vector<std::string> option_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames())
            names.push_back("--" + name);
    return names;
}

// The parser's complaint in one line, with the option that was probably meant.
Error parse_error(const CLI::App& app, const std::string& name, const CLI::ParseError& error) {
    if (dynamic_cast<const CLI::ExtrasError*>(&error)) {
        // The app keeps what it did not understand.
        const std::vector<std::string> left = app.remaining();
        const auto option =
            std::find_if(left.begin(), left.end(), [](const auto& text) { return text.starts_with("-"); });
        if (option != left.end()) {
            const std::string typed = option->substr(0, option->find('='));
            return usage_error(
                fmt::format("{} has no option '{}'{}", name, typed, did_you_mean(typed, option_names(app))));
        }
        return usage_error(fmt::format("{}: unexpected argument '{}'", name, left.empty() ? "" : left.front()));
    }
    return usage_error(fmt::format("{}: {}", name, error.what()));
}

Outcome run_command(const Registered& registered, const std::vector<std::string>& arguments) {
    CLI::App app(registered.summary, std::string("sfumato ") + registered.name);
    app.set_help_flag("-h,--help", "This text");
    app.get_formatter()->column_width(34);
    Verbosity verbosity;
    const Command command = registered.make(app);
    app.add_flag("-q,--quiet", verbosity.quiet, "Say nothing but errors");
    app.add_flag("-v,--verbose", verbosity.verbose, "Say what was found and why");
    app.add_flag("--json", verbosity.json, "Results as JSON on standard output");
    try {
        std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
        app.parse(reversed);
    } catch (const CLI::CallForHelp&) {
        std::fputs(app.help().c_str(), stdout);
        return exit_done;
    } catch (const CLI::ParseError& error) {
        return parse_error(app, registered.name, error);
    }
    Console console(verbosity);
    return guarded([&] { return command({command_line(arguments), verbosity}, console); });
}

Outcome dispatch(const std::vector<std::string>& arguments) {
    if (arguments.empty())
        return usage_error("no command; sfumato --help tells what there is");
    const std::string& name = arguments.front();
    if (name == "--help" || name == "-h" || name == "help" || name == "--version") {
        std::puts((name == "--version" ? version_text() : help_text()).c_str());
        return exit_done;
    }
    std::vector<std::string> names;
    for (const Registered& command : commands) {
        if (name == command.name)
            return run_command(command, arguments);
        names.emplace_back(command.name);
    }
    const std::string kind = name.starts_with("-") ? "option" : "command";
    if (kind == "option")
        names = {"--help", "--version"};
    const std::string hint = did_you_mean(name, names);
    return usage_error(
        fmt::format("unknown {} '{}'{}", kind, name, hint.empty() ? "; sfumato --help tells what there is" : hint));
}

} // namespace

} // namespace sfumato::cli

int main(int argc, char** argv) {
    using namespace sfumato::cli;
    const auto outcome = guarded([&] { return dispatch({argv + 1, argv + argc}); });
    if (outcome)
        return *outcome;
    Console({}).error(outcome.error());
    return exit_code_of(outcome.error().code);
}
