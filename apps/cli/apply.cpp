// sfumato apply: effects on images and sequences.
#include "apps/cli/command.h"
#include "apps/cli/pipeline.h"
#include "media/sequence.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace sfumato::cli {

namespace {

struct ApplyOptions {
    ChainOptions chain;
    FrameListOptions frames;
    LoaderOptions loader;
    std::string outputs;
    std::string save_config;
    std::string device;
    bool skip_bad_frames = false;
    bool dry_run = false;
    bool full_float = false;
};

// The first frame that can be read; jobs before it are dropped and counted as skipped.
Result<std::optional<LoadedFrame>> load_first(std::vector<FrameJob>& jobs, FrameLoader& loader, bool skip_bad_frames,
                                              Console& console, size_t& skipped) {
    while (!jobs.empty()) {
        auto first = loader.load(jobs.front());
        if (first)
            return std::optional<LoadedFrame>(std::move(*first));
        if (!skip_bad_frames || first.error().code != ErrorCode::input)
            return first.error();
        console.warn("skipped: " + first.error().message);
        ++skipped;
        jobs.erase(jobs.begin());
        if (!jobs.empty())
            jobs.front().restarts = true;
    }
    return std::optional<LoadedFrame>();
}

// A result replaces what bears its name in the file: nobody should lose a pass without knowing.
void warn_of_replaced(const EffectChain& chain, const LoadedFrame& first, Console& console) {
    const media::ExrPart& part = first.image.parts[first.colour.part];
    for (const ChainLink& link : chain)
        for (const ImageRole& role : link.effect->images) {
            const bool is_written = std::ranges::find(link.written, role.name) != link.written.end();
            const std::string name = channel_name(*link.effect, role);
            if (is_written && part.find_channel(name) != nullptr)
                console.warn(
                    fmt::format("{}: its channel {} is replaced by the effect's", first.job.input.string(), name));
        }
}

std::string picture_list(const LoadedFrame& frame) {
    std::string text;
    for (const auto& [role, picture] : frame.roles)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", role, extent_text(picture.extent));
    const Frame& facts = frame.facts;
    text += facts.camera ? ", camera" : "";
    text += facts.previous_camera ? ", previous camera" : "";
    text += facts.next_camera ? ", next camera" : "";
    return text + fmt::format(", {:.4g} s a frame", facts.time_step);
}

void tell_plan(const EffectChain& chain, const LoadedFrame& first, Console& console) {
    console.note(fmt::format("{}: {}", first.job.input.string(), picture_list(first)));
    for (const ChainLink& link : chain)
        console.note(fmt::format("{}{}: {}", link.effect->name, link.preset.empty() ? "" : ", preset " + link.preset,
                                 parameters_text(link)));
}

void tell_dry_run(const EffectChain& chain, const std::vector<FrameJob>& jobs, const LoadedFrame& first,
                  Console& console) {
    console.line(fmt::format("{}: {}", first.job.input.string(), picture_list(first)));
    for (const ChainLink& link : chain)
        console.line(fmt::format("{}: {}", link.effect->name, parameters_text(link)));
    for (const FrameJob& job : jobs)
        console.line(fmt::format("would make {} -> {}", job.input.string(),
                                 job.output.empty() ? "(pre-roll, not written)" : job.output.string()));
}

nlohmann::ordered_json chain_json(const EffectChain& chain) {
    auto list = nlohmann::ordered_json::array();
    for (const ChainLink& link : chain) {
        nlohmann::ordered_json parameters;
        for (const ParameterInfo& info : link.effect->parameters->parameters)
            parameters[info.name] = parameter_text(info, link.parameters.data());
        list.push_back({{"effect", link.effect->name}, {"preset", link.preset}, {"parameters", parameters}});
    }
    return list;
}

void tell_json(const EffectChain& chain, const PipelineReport& report, const FrameLoader& loader,
               const std::string& device, double seconds, Console& console) {
    nlohmann::ordered_json json = {{"written", report.written},
                                   {"skipped", report.skipped},
                                   {"seconds", seconds},
                                   {"device", device},
                                   {"effects", chain_json(chain)}};
    json["motion_convention"] = loader.motion() ? nlohmann::ordered_json(loader.motion()->text()) : nullptr;
    json["depth_convention"] = loader.depth() ? nlohmann::ordered_json(loader.depth()->text()) : nullptr;
    json["normal_convention"] = loader.normals() ? nlohmann::ordered_json(loader.normals()->text()) : nullptr;
    for (const auto& output : report.outputs)
        json["outputs"].push_back(output.string());
    console.result(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

Result<void> make_folders(const std::vector<FrameJob>& jobs) {
    for (const FrameJob& job : jobs)
        if (auto made = make_parent_folder(job.output); !made)
            return made;
    return {};
}

Outcome finish(const PipelineReport& report, size_t total, double seconds, Console& console) {
    if (report.interrupted && report.written + report.skipped < total) {
        console.error(
            {ErrorCode::internal, fmt::format("interrupted; {} of {} frames are written", report.written, total)});
        return exit_interrupted;
    }
    console.note(fmt::format("{} frames in {:.2f} s", report.written, seconds));
    if (report.skipped == 0)
        return exit_done;
    return input_error(fmt::format("{} of {} frames were skipped, {} written", report.skipped, total, report.written));
}

// Effects take normals in the space that the file has them in.
void take_normal_space(EffectChain& chain, const FrameLoader& loader) {
    for (ChainLink& link : chain)
        if (const ParameterInfo* space = link.effect->parameters->find("normal_space"); space && loader.normals())
            space->set(link.parameters.data(), loader.normals()->is_world ? 1.0 : 0.0);
}

Outcome process(ApplyOptions& options, EffectChain& chain, std::vector<FrameJob>& jobs, const Invocation& invocation,
                Console& console) {
    auto loader = FrameLoader::create(chain, options.loader, console);
    if (!loader)
        return loader.error();
    const auto total = static_cast<size_t>(
        std::count_if(jobs.begin(), jobs.end(), [](const FrameJob& job) { return !job.output.empty(); }));
    size_t skipped = 0;
    auto first = load_first(jobs, *loader, options.skip_bad_frames, console, skipped);
    if (!first)
        return first.error();
    if (!*first)
        return input_error(fmt::format("none of {} frames could be read", total));
    take_normal_space(chain, *loader);
    if (options.dry_run) {
        tell_dry_run(chain, jobs, **first, console);
        return exit_done;
    }
    tell_plan(chain, **first, console);
    if (!options.frames.output.ends_with(".png"))
        warn_of_replaced(chain, **first, console);
    auto device = DeviceStage::create(options.device, chain);
    if (!device)
        return device.error();
    console.note("device: " + (*device)->device_name());
    if (auto made = make_folders(jobs); !made)
        return made.error();
    const auto start = std::chrono::steady_clock::now();
    PipelineOptions pipeline;
    pipeline.skip_bad_frames = options.skip_bad_frames;
    pipeline.writer = {options.frames.output.ends_with(".png"), options.full_float, options.frames.no_clobber,
                       invocation.command_line, options.loader.threads};
    auto report = run_pipeline(jobs, std::move(*first), *loader, **device, chain, pipeline, console);
    if (!report)
        return report.error();
    report->skipped += skipped;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (invocation.verbosity.json)
        tell_json(chain, *report, *loader, (*device)->device_name(), seconds, console);
    return finish(*report, total, seconds, console);
}

// A PNG holds the picture, or in its absence one plane that can be shown as one.
Result<void> check_picture(const EffectChain& chain, const std::string& output) {
    auto format = output_format(output);
    if (!format)
        return format.error();
    if (*format == "png" && !writes_colour(chain) && !writes_plane(chain))
        return usage_error("a PNG holds colour or visibility, and --outputs names neither; write .exr");
    return {};
}

// The parameter says it too: what is set there by hand is not guessed again.
std::string normal_space_set_by_hand(const EffectChain& chain) {
    for (const ChainLink& link : chain)
        for (const std::string& name : link.set_by_hand)
            if (name == "normal_space")
                return parameter_text(*link.effect->parameters->find(name), link.parameters.data());
    return "";
}

Outcome run(ApplyOptions& options, const Invocation& invocation, Console& console) {
    auto chain = make_chain(options.chain);
    if (!chain)
        return chain.error();
    if (auto chosen = choose_outputs(*chain, options.outputs); !chosen)
        return chosen.error();
    if (auto checked = check_picture(*chain, options.frames.output); !checked)
        return checked.error();
    if (options.loader.conventions.normals.empty())
        options.loader.conventions.normals = normal_space_set_by_hand(*chain);
    if (auto checked = check_convention_words(options.loader.conventions); !checked)
        return checked.error();
    options.frames.allow_missing = options.skip_bad_frames;
    auto jobs = list_frames(options.frames);
    if (!jobs)
        return jobs.error();
    if (!options.save_config.empty() && !options.dry_run)
        if (auto saved = save_config(*chain, options.save_config, options.frames.no_clobber); !saved)
            return saved.error();
    options.loader.threads = coding_threads();
    catch_interrupts();
    return process(options, *chain, *jobs, invocation, console);
}

} // namespace

Command make_apply(CLI::App& app) {
    auto options = std::make_shared<ApplyOptions>();
    app.add_option("EFFECTS", options->chain.effects, "Effects, left to right: motion-blur[,…]")->required();
    app.add_option("INPUT", options->frames.inputs, "EXR files or a pattern: shot.####.exr, shot.%04d.exr")->required();
    add_text(app, "-o,--output", options->frames.output, "File or pattern, .exr or .png")->required();
    add_text(app, "--frames", options->frames.frames, "Frames of the pattern: 1-100,200-300x2 (default: all)");
    add_chain_options(app, options->chain, options->save_config);
    add_text(app, "--camera", options->loader.camera, "Cameras of the frames, TOML (default: the files' attributes)");
    add_text(app, "--device", options->device, "Vulkan device: index or part of the name (list devices)");
    add_text(app, "--layer", options->loader.conventions.layer, "Layer to take colour, depth, normals and motion from");
    add_text(app, "--motion-convention", options->loader.conventions.motion,
             "What motion channels mean: blender, ndc,flip-y, …");
    add_text(app, "--depth-convention", options->loader.conventions.depth,
             "What depth means: planar, distance, normalised,near=1,far=9, …");
    add_text(app, "--normal-space", options->loader.conventions.normals,
             "Space of normals: auto, view, world (,unsigned ,flipped ,z-forward)");
    add_text(app, "--outputs", options->outputs,
             "What is written: colour, visibility, bent_normal, soft_shadow (default: what the effects are for)");
    app.add_flag("--no-clobber", options->frames.no_clobber, "Refuse to overwrite files");
    app.add_flag("--skip-bad-frames", options->skip_bad_frames,
                 "Report broken frames and go on; the exit code is 3 then");
    app.add_option("--preroll", options->frames.preroll, "Frames to run before the first, for effects with history")
        ->check(CLI::Range(0, 1000))
        ->type_name("N");
    app.add_flag("-n,--dry-run", options->dry_run, "Only tell what would be done");
    app.add_flag("--float", options->full_float, "Write colour as 32-bit floats in place of half");
    app.footer("Example: sfumato apply motion-blur shot.####.exr -o blur.####.exr --frames 1-100 --preset high\n"
               "Exit codes: 0 done, 2 usage, 3 input, 4 device, 5 internal.");
    return [options](const Invocation& invocation, Console& console) { return run(*options, invocation, console); };
}

} // namespace sfumato::cli
