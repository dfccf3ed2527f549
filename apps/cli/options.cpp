// Options that several commands share.
#include "apps/cli/command.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <thread>

namespace sfumato::cli {

CLI::Option* add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& doc) {
    return app.add_option(name, target, doc)->type_name("");
}

void add_chain_options(CLI::App& app, ChainOptions& options, std::string& save_config) {
    add_text(app, "--preset", options.preset, "Preset for all effects, or EFFECT=NAME,… (list presets)");
    app.add_option("--set", options.settings, "effect.parameter=value, as often as wanted (list parameters)")
        ->type_name("")
        ->allow_extra_args(false);
    add_text(app, "--config", options.config, "Parameters from a TOML file; --preset and --set win");
    add_text(app, "--save-config", save_config, "Write the effective parameters to a TOML file");
}

Result<Extent> parse_size(const std::string& text) {
    Extent extent;
    const char* end = text.data() + text.size();
    const auto [x, width_error] = std::from_chars(text.data(), end, extent.width);
    const bool has_x = width_error == std::errc() && x != end && (*x == 'x' || *x == 'X');
    const auto [last, height_error] = std::from_chars(has_x ? x + 1 : end, end, extent.height);
    if (!has_x || height_error != std::errc() || last != end || !extent || extent.width > 16384 ||
        extent.height > 16384)
        return usage_error(
            fmt::format("--size {}: write WIDTHxHEIGHT, as in 1920x1080, with sides from 1 to 16384", text));
    return extent;
}

int coding_threads() {
    return static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 8u));
}

} // namespace sfumato::cli
