// Parses the command line.
#include "apps/bench/options.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "scene/scene.h"

#include <CLI/CLI.hpp>

namespace sfumato::bench {
namespace {

struct Texts {
    std::vector<std::string> sizes;
    std::string quality_size;
    std::string budget;
    bool next_velocity = false, no_rotate = false, no_passes = false, no_ssim = false;
};

Error usage(const std::string& message) {
    return {ErrorCode::invalid_argument, message};
}

Result<Extent> parse_size(const std::string& text) {
    Extent extent;
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, extent.width);
    if (width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x') {
        const auto height = std::from_chars(width.ptr + 1, end, extent.height);
        if (height.ec == std::errc{} && height.ptr == end && extent && extent.width <= 16384 && extent.height <= 16384)
            return extent;
    }
    return usage("'" + text + "' is no size: write WIDTHxHEIGHT, such as 1920x1080, each side 1 to 16384");
}

// "0.2ms", "200us" or "0.2", which is milliseconds.
Result<double> parse_budget(const std::string& text) {
    double value = 0.0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    const std::string unit(parsed.ptr, end);
    const double scale = unit.empty() || unit == "ms" ? 1.0 : unit == "us" ? 1e-3 : 0.0;
    if (parsed.ec != std::errc{} || scale == 0.0 || !(value > 0.0))
        return usage("'" + text + "' is no time: write 0.2ms or 200us");
    return value * scale;
}

void add_common(CLI::App& app, Options& options, Texts& texts) {
    app.add_option("--device", options.rig.device, "Index or part of the name of the Vulkan device");
    app.add_option("--json", options.json, "Writes the figures as JSON; - for standard output instead of the table");
    app.add_option("--effect", options.variants.effect, "Effect; all if not given");
    app.add_option("--preset", options.variants.presets, "Presets, or all, which is the default")->delimiter(',');
    app.add_option("--set", options.variants.sets, "EFFECT.PARAMETER=VALUE, over the preset")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--vary", options.variants.varied, "EFFECT.PARAMETER=VALUE,VALUE...: a row for each combination")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--scene", options.scenes,
                   "Analytic scenes; those made for the effect if not given, 'none' for files alone")
        ->delimiter(',');
    app.add_option("--input-raw", options.raw_files, "A frame rendered elsewhere, as exr_to_raw.py writes it")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--samples", options.samples, "Samples a side of each pixel of a scene")->check(CLI::Range(1, 8));
    app.add_flag("--next-velocity", texts.next_velocity, "Feeds the velocity to the next frame as well");
    app.add_option("--with", options.opted_in,
                   "Binds optional images that are left out else: next_velocity, shadow, colour, ambient, soft_shadow, "
                   "bent_normal, output")
        ->delimiter(',');
    app.add_flag("--validation", options.rig.validation, "Runs under the validation layer; times mean nothing then");
}

void add_timing_of_frames(CLI::App& app, Options& options) {
    app.add_option("--frames", options.frames, "Frames that are timed; 100 (10 on a CPU)")
        ->check(CLI::Range(1, 100000));
    app.add_option("--warm-up", options.warm_up, "Seconds of work before the first measurement")
        ->check(CLI::Range(0.0, 60.0));
    app.add_option("--batch", options.batch, "Frames in a command buffer; 8 (1 on a CPU)")->check(CLI::Range(1, 8));
}

void add_timing(CLI::App& app, Options& options, Texts& texts) {
    add_timing_of_frames(app, options);
    app.add_flag("--no-rotate", texts.no_rotate, "Feeds one frame again and again, which flatters caches");
}

void add_quality(CLI::App& app, Options& options, Texts& texts) {
    app.add_option("--subframes", options.sub_frames, "Sub-frames of the ground truth; 128 (32 on a CPU)")
        ->check(CLI::Range(2, 256));
    app.add_option("--rays", options.rays, "Rays a pixel of the ground truth of occlusion; 1024 (128 on a CPU)")
        ->check(CLI::Range(1, 65536));
    app.add_option("--truth-falloff", options.truth_falloff,
                   "Falloff of the ground truth of occlusion; own: that of each preset");
    app.add_option("--preroll", options.preroll, "Frames before the one that is scored, for presets with a history")
        ->check(CLI::Range(0, 1000));
    app.add_flag("--no-ssim", texts.no_ssim, "Leaves out structural similarity, the slow figure");
}

void add_commands(CLI::App& app, Options& options, Texts& texts) {
    CLI::App* times = app.add_subcommand("times", "GPU time per preset, scene and size, whole and per pass");
    add_common(*times, options, texts);
    add_timing(*times, options, texts);
    times->add_option("--size", texts.sizes, "Sizes; 1280x720,1920x1080,3840x2160 (256x144 on a CPU)")->delimiter(',');
    times->add_flag("--no-passes", texts.no_passes, "Leaves out the second run, which times every pass");

    CLI::App* quality = app.add_subcommand("quality", "Error against ground truth per preset and scene");
    add_common(*quality, options, texts);
    add_quality(*quality, options, texts);
    quality->add_option("--size", texts.quality_size, "Size; 960x540 (256x144 on a CPU). Files keep their own");
    quality->add_option("--pictures", options.pictures, "Folder for PNG pictures");

    CLI::App* frontier = app.add_subcommand("frontier", "Error against time");
    add_common(*frontier, options, texts);
    add_timing(*frontier, options, texts);
    add_quality(*frontier, options, texts);
    frontier->add_option("--size", texts.sizes, "Size of the timed frames; 1920x1080 (256x144 on a CPU)");
    frontier->add_option("--quality-size", texts.quality_size, "Size of the scored frames; 960x540 (256x144 on a CPU)");

    CLI::App* tune = app.add_subcommand("tune", "Searches the parameters with least error within a time");
    add_common(*tune, options, texts);
    add_timing(*tune, options, texts);
    add_quality(*tune, options, texts);
    tune->add_option("--size", texts.sizes, "Size of the timed frames; 1920x1080 (256x144 on a CPU)");
    tune->add_option("--quality-size", texts.quality_size, "Size of the scored frames; 960x540 (256x144 on a CPU)");
    tune->add_option("--budget", texts.budget, "Time, 0.2ms or 200us")->required();
    tune->add_option("--seed", options.seed, "Seed of the search");
    tune->add_option("--evaluations", options.evaluations, "Settings that are tried")->check(CLI::Range(1, 100000));
    tune->add_option("--only", options.only, "Varies these parameters alone")->delimiter(',');
    tune->add_option("--fix", options.fix, "Leaves these parameters as the preset or --set has them")->delimiter(',');

    CLI::App* sort = app.add_subcommand("sort", "GPU time of sorting, prefix sums and compaction, results checked");
    sort->add_option("--device", options.rig.device, "Index or part of the name of the Vulkan device");
    sort->add_option("--json", options.json, "Writes the figures as JSON; - for standard output instead of the table");
    sort->add_option("--count", options.counts,
                     "Elements; powers of two from 2^14 to 2^22 (2^16 on a CPU) if not given")
        ->delimiter(',')
        ->check(CLI::Range(1u, 1u << 24));
    sort->add_option("--bits", options.bits, "Bits of the keys that are sorted by; 16,32 if not given")
        ->delimiter(',')
        ->check(CLI::Range(1, 32));
    sort->add_flag("--indices", options.sorts_indices, "Values are 0, 1, 2 ... and are not read");
    sort->add_flag("--no-passes", texts.no_passes, "Leaves out the second run, which times every pass");
    sort->add_flag("--validation", options.rig.validation, "Runs under the validation layer; times mean nothing then");
    add_timing_of_frames(*sort, options);

    CLI::App* particles = app.add_subcommand("particles", "Particles: error against brute force, time by their number");
    particles->add_option("--device", options.rig.device, "Index or part of the name of the Vulkan device");
    particles->add_option("--json", options.json, "Writes the figures as JSON; - for standard output instead");
    particles->add_flag("--validation", options.rig.validation, "Runs under the validation layer");
    particles->add_option("--part", options.part, "quality, times or all")
        ->check(CLI::IsMember({"quality", "times", "all"}));
    particles
        ->add_option("--count", options.particle_counts,
                     "Numbers of particles; 2^14 to 2^22 (2^16 on a CPU) for times, 40000 (6000) for quality")
        ->delimiter(',')
        ->check(CLI::Range(1, 4194304));
    particles->add_option("--footprint", options.footprint, "Mean size of the particles that are timed, pixels; 16")
        ->check(CLI::Range(1.0, 1000.0));
    particles
        ->add_option("--profile", options.profile, "Profile of the particles that are timed: sphere, noise, texture")
        ->check(CLI::IsMember({"sphere", "noise", "texture"}));
    particles->add_option("--frames", options.frames, "Frames that are timed; 100 (3 on a CPU)")
        ->check(CLI::Range(1, 100000));
    particles->add_option("--size", texts.sizes, "Size; 1920x1080 for times, 480x270 for quality (small on a CPU)");
    particles->add_option(
        "--pictures", options.pictures,
        "Folder for PNG pictures of the modes, the slices and the change of sides, with --part quality");
    particles->add_flag("--no-passes", texts.no_passes, "Leaves out the times of every pass");

    CLI::App* list = app.add_subcommand("list", "Devices, effects, presets and scenes");
    list->add_option("--json", options.json, "Writes the list as JSON; - for standard output");
    app.require_subcommand(1);
}

std::string joined(std::span<const char* const> names) {
    std::string text;
    for (const char* name : names)
        text += std::string(text.empty() ? "" : ", ") + name;
    return text;
}

bool has_role(const std::string& name) {
    return std::ranges::any_of(effects(), [&](const EffectInfo* effect) {
        return std::ranges::any_of(effect->images, [&](const ImageRole& role) { return name == role.name; });
    });
}

Result<void> convert(const Texts& texts, Options& options) {
    for (const std::string& text : texts.sizes) {
        auto size = parse_size(text);
        if (!size)
            return size.error();
        options.sizes.push_back(*size);
    }
    if (!texts.quality_size.empty()) {
        auto size = parse_size(texts.quality_size);
        if (!size)
            return size.error();
        options.quality_size = *size;
    }
    if (!texts.budget.empty()) {
        auto budget = parse_budget(texts.budget);
        if (!budget)
            return budget.error();
        options.budget_ms = *budget;
    }
    if (texts.next_velocity)
        options.opted_in.emplace_back("next_velocity");
    if (options.truth_falloff != "own" && !scene::find_falloff(options.truth_falloff))
        return usage("there is no falloff '" + options.truth_falloff + "'; there are own, " +
                     joined(scene::falloff_names()));
    for (const std::string& name : options.opted_in)
        if (!has_role(name))
            return usage("no effect has an image '" + name + "'");
    options.rotate = !texts.no_rotate;
    options.passes = !texts.no_passes;
    options.ssim = !texts.no_ssim;
    return {};
}

// CLI11's messages may run over several lines.
std::string one_line(std::string text) {
    std::ranges::replace(text, '\n', ' ');
    return text;
}

// A command that is not one, told before CLI11 complains about everything that follows it.
Result<void> check_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2 || argv[1][0] == '-')
        return {};
    std::vector<std::string> names;
    std::string list;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        names.push_back(command->get_name());
        list += (list.empty() ? "" : ", ") + names.back();
    }
    if (std::ranges::find(names, argv[1]) != names.end())
        return {};
    const std::string near = nearest_name(argv[1], names);
    return usage("there is no command '" + std::string(argv[1]) + "'" +
                 (near.empty() ? "; there are " + list : "; did you mean '" + near + "'?"));
}

} // namespace

Result<ParsedOptions> parse_options(int argc, char** argv) {
    ParsedOptions parsed;
    Texts texts;
    // CLI11 reports by exceptions: they end here.
    try {
        CLI::App app("Measures Sfumato's effects on this machine: their time, and their error against ground truth.",
                     "sfumato-bench");
        add_commands(app, parsed.options, texts);
        if (auto known = check_command(app, argc, argv); !known)
            return known.error();
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& success) {
            app.exit(success);
            parsed.is_done = true;
            return parsed;
        }
        parsed.options.command = app.get_subcommands().front()->get_name();
    } catch (const CLI::Error& error) {
        return usage(one_line(error.what()) + "; see sfumato-bench --help");
    }
    if (auto converted = convert(texts, parsed.options); !converted)
        return converted.error();
    return parsed;
}

} // namespace sfumato::bench
