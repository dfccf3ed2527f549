// sfumato render: built-in scenes and glTF models with their passes, effects and ground truth.
#include "apps/cli/command.h"
#include "apps/cli/frame_list.h"
#include "apps/cli/frame_writer.h"
#include "apps/cli/pipeline.h"
#include "apps/cli/render_frames.h"
#include "apps/cli/render_particles.h"
#include "apps/cli/viewpoint.h"
#include "media/png_file.h"
#include "media/sequence.h"

#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

namespace sfumato::cli {

namespace {

struct RenderCommandOptions {
    SceneOptions scene;
    std::string output, frames, save_config;
    std::string size = "960x540";
    ChainOptions chain;
    std::string particles; // preset of the particles that come before the other effects
    std::string particle_texture;
    std::string truth;
    std::optional<double> truth_radius; // else the effect's, else 1.5
    std::string truth_falloff;          // else the effect's, else hard
    int truth_rays = 256;
    RenderRequest request; // what `size` and `truth` say
    std::string outputs;
    int preroll = 0;
    bool has_preroll = false;
    bool full_float = false;
    bool no_clobber = false;
    bool dry_run = false;
};

// A number of sub-frames asks for motion blur, as its name does; occlusion is asked for by name.
Result<TruthRequest> parse_truth(const RenderCommandOptions& options) {
    TruthRequest request;
    std::istringstream words(options.truth);
    for (std::string word; std::getline(words, word, ',');) {
        const char* end = word.data() + word.size();
        int count = 64;
        const auto [last, failed] = std::from_chars(word.data(), end, count);
        const bool is_count = failed == std::errc() && last == end;
        if (word == "ambient-occlusion")
            request.occlusion = true;
        else if ((is_count && count >= 1 && count <= 256) || word == "motion-blur")
            request.sub_frames = count;
        else
            return usage_error(fmt::format("--truth {}: '{}' is neither a number of sub-frames from 1 to 256, nor "
                                           "motion-blur, nor ambient-occlusion",
                                           options.truth, word));
    }
    request.rays.rays = options.truth_rays;
    return request;
}

// The truth reaches as far as the occlusion in the chain does, and falls off like it, unless told otherwise.
Result<void> complete_truth(TruthRequest& request, const RenderCommandOptions& options, const EffectChain& chain) {
    std::string falloff = options.truth_falloff;
    for (const ChainLink& link : chain) {
        const ParameterInfo* radius = link.effect->parameters->find("radius");
        const ParameterInfo* own = link.effect->parameters->find("falloff");
        if (!radius || !own)
            continue;
        request.rays.radius = radius->get(link.parameters.data());
        falloff = falloff.empty() ? parameter_text(*own, link.parameters.data()) : falloff;
    }
    const auto found = scene::find_falloff(falloff.empty() ? "hard" : falloff);
    if (!found)
        return usage_error(
            fmt::format("--truth-falloff {}: there are {}", falloff, fmt::join(scene::falloff_names(), ", ")));
    request.rays.falloff = *found;
    request.rays.radius = options.truth_radius.value_or(request.rays.radius);
    return {};
}

// Without --frames: the key frame for one file, all frames for a pattern.
Result<std::vector<media::SequenceFrame>> choose_frames(const RenderCommandOptions& options, const SceneChoice& scene) {
    auto pattern = media::FramePattern::parse(options.output);
    if (!pattern)
        return pattern.error();
    std::vector<int> frames = {scene.info.key_frame};
    if (!options.frames.empty()) {
        auto parsed = media::parse_frame_range(options.frames);
        if (!parsed)
            return parsed.error();
        frames = std::move(*parsed);
    } else if (pattern->is_sequence()) {
        frames.clear();
        for (int frame = 1; frame <= scene.info.frames; ++frame)
            frames.push_back(frame);
    }
    return media::output_frames(*pattern, frames);
}

Result<void> write_png(const RenderedFrame& frame, const std::filesystem::path& path, const EffectChain& chain,
                       const RenderCommandOptions& options) {
    // A picture holds one thing: the truth, if it was asked for and nothing else stands in its place.
    std::string shown = options.request.truths.occlusion        ? "true_visibility"
                        : options.request.truths.sub_frames > 0 ? "truth"
                                                                : "colour";
    // An effect that leaves the picture alone has made something else to look at.
    if (!chain.empty() && !writes_colour(chain))
        for (const auto& [name, pass] : frame.passes)
            if (pass.channels.size() == 1)
                shown = name;
    const RenderedPass& pass = frame.passes.at(shown);
    std::vector<std::vector<float>> planes(3, std::vector<float>(pass.values.size() / pass.components));
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < planes[c].size(); ++i)
            planes[c][i] = pass.values[i * pass.components + std::min<size_t>(c, pass.components - 1)];
    const auto picture =
        media::make_picture(static_cast<int>(frame.extent.width), static_cast<int>(frame.extent.height),
                            planes[0].data(), planes[1].data(), planes[2].data());
    return media::write_png(path, picture, {options.no_clobber, true});
}

Result<void> write_rendered(const RenderedFrame& frame, const std::filesystem::path& path, const EffectChain& chain,
                            const RenderCommandOptions& options, const Invocation& invocation) {
    if (auto made = make_parent_folder(path); !made)
        return made;
    if (options.output.ends_with(".png"))
        return write_png(frame, path, chain, options);
    media::ExrImage image = rendered_image(frame, options.full_float);
    add_provenance(image.parts.front(), chain, invocation.command_line);
    image.parts.front().set_string_attribute("sfumato/scene", options.scene.scene);
    media::ExrWriteOptions write_options;
    write_options.no_clobber = options.no_clobber;
    write_options.threads = coding_threads();
    return media::write_exr(path, image, write_options);
}

// One frame after the frames that it needs before it.
Result<void> render_one(const std::vector<media::SequenceFrame>& frames, size_t i, SceneFrames& source,
                        const EffectChain& chain, const RenderCommandOptions& options, const Invocation& invocation) {
    const int number = frames[i].frame;
    const bool restarts = i > 0 && number != frames[i - 1].frame + 1;
    const int start = i == 0 || restarts ? std::max(number - options.preroll, 0) : number;
    for (int before = start; before < number; ++before)
        if (auto rendered = source.render(before, restarts && before == start); !rendered)
            return rendered.error();
    auto frame = source.render(number, restarts && start == number);
    if (!frame)
        return frame.error();
    return write_rendered(*frame, frames[i].path, chain, options, invocation);
}

Outcome render_all(const std::vector<media::SequenceFrame>& frames, SceneFrames& source, const EffectChain& chain,
                   const RenderCommandOptions& options, const Invocation& invocation, Console& console) {
    if (auto opened = source.open(); !opened)
        return opened.error();
    console.note("device: " + source.device_name());
    console.start_progress(frames.size());
    nlohmann::ordered_json json = {{"scene", options.scene.scene}, {"device", source.device_name()}};
    ShortfallLog shortfalls;
    Result<void> done;
    for (size_t i = 0; i < frames.size() && !interrupted; ++i) {
        done = render_one(frames, i, source, chain, options, invocation);
        if (!done)
            break;
        shortfalls.add(frames[i].frame, source.shortfalls());
        json["outputs"].push_back(frames[i].path.string());
        console.advance(
            fmt::format("{} frame {} -> {}", options.scene.scene, frames[i].frame, frames[i].path.string()));
    }
    console.end_progress();
    for (const std::string& line : shortfalls.lines())
        console.warn(line);
    if (!done)
        return done.error();
    if (interrupted) {
        console.error({ErrorCode::internal, "interrupted; what was finished is written"});
        return exit_interrupted;
    }
    if (invocation.verbosity.json)
        console.result(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return exit_done;
}

Outcome run(RenderCommandOptions options, const Invocation& invocation, Console& console) {
    auto scene = choose_scene(options.scene);
    if (!scene)
        return scene.error();
    const auto extent = parse_size(options.size);
    if (!extent)
        return extent.error();
    options.request.extent = *extent;
    auto format = output_format(options.output);
    if (!format)
        return format.error();
    const auto truths = parse_truth(options);
    if (!truths)
        return truths.error();
    options.request.truths = *truths;
    add_particles(options.chain, options.particles);
    const bool has_effects = !options.chain.effects.empty();
    if (!has_effects &&
        (!options.chain.preset.empty() || !options.chain.settings.empty() || !options.chain.config.empty()))
        return usage_error("--preset, --set and --config are for effects; name them with --effects");
    if (*format == "png" && truths->occlusion + (truths->sub_frames > 0) + has_effects > 1)
        return usage_error("a PNG holds one picture: write .exr, or render effects and truths apart");
    if (!has_effects && !options.outputs.empty())
        return usage_error("--outputs is for effects; name them with --effects");
    auto chain = has_effects ? make_chain(options.chain) : Result<EffectChain>(EffectChain{});
    if (!chain)
        return chain.error();
    if (auto chosen = has_effects ? choose_outputs(*chain, options.outputs) : Result<void>{}; !chosen)
        return chosen.error();
    if (*format == "png" && has_effects && !writes_colour(*chain) && !writes_plane(*chain))
        return usage_error("a PNG holds colour or visibility, and --outputs names neither; write .exr");
    auto texture = particle_texture(options.particle_texture, *chain);
    if (!texture)
        return texture.error();
    options.request.particle_texture = std::move(*texture);
    if (!options.particles.empty() && !options.has_preroll)
        options.preroll = particles_preroll(*chain);
    const SceneFit fit = fit_of(*scene);
    if (adapt_chain(*chain, options.chain, fit))
        console.note(fmt::format("ambient-occlusion.radius={:.4g}, half of the model's", occlusion_radius(fit)));
    options.request.truths.rays.radius = occlusion_radius(fit);
    if (auto completed = complete_truth(options.request.truths, options, *chain); !completed)
        return completed.error();
    auto frames = choose_frames(options, *scene);
    if (!frames)
        return frames.error();
    for (const auto& [frame, path] : *frames)
        if (std::error_code failed; options.no_clobber && std::filesystem::exists(path, failed))
            return input_error(
                fmt::format("{}: exists already, and --no-clobber forbids to overwrite it", path.string()));
    if (options.dry_run) {
        for (const auto& [frame, path] : *frames)
            console.line(fmt::format("would render {} frame {} -> {}", options.scene.scene, frame, path.string()));
        return exit_done;
    }
    if (!options.save_config.empty())
        if (auto saved = save_config(*chain, options.save_config, options.no_clobber); !saved)
            return saved.error();
    for (const std::string& warning : scene->warnings)
        console.warn(fmt::format("{}: {}", options.scene.scene, warning));
    catch_interrupts();
    SceneFrames source(options.request, *chain, *scene);
    return render_all(*frames, source, *chain, options, invocation, console);
}

} // namespace

Command make_render(CLI::App& app) {
    auto options = std::make_shared<RenderCommandOptions>();
    app.add_option("SCENE", options->scene.scene, "A built-in scene (list scenes), or a .gltf or .glb file")
        ->required();
    add_text(app, "--animation", options->scene.animation, "Of a model, by name or number; none: at rest (default: 0)");
    add_text(app, "--camera-name", options->scene.camera_name,
             "Of a model (default: its first camera; without one, a view of the whole)");
    app.add_flag("--no-ground", options->scene.no_ground,
                 "No floor below a model (there is one unless its own camera looks)");
    app.add_flag("--turntable", options->scene.turntable, "A camera that circles the scene");
    app.add_option("--turntable-frames", options->scene.turntable_frames, "Frames of a full turn")
        ->check(CLI::Range(1, 100000))
        ->type_name("N")
        ->capture_default_str();
    add_text(app, "-o,--output", options->output, "File or pattern: .exr with all channels, or .png")->required();
    add_text(app, "--frames", options->frames, "Frames (default: the key frame, or all for a pattern)");
    add_text(app, "--size", options->size, "WIDTHxHEIGHT (default: 960x540)");
    add_text(app, "--viewpoint", options->scene.viewpoint, viewpoint_doc);
    add_text(app, "--effects,--apply", options->chain.effects, "Effects, left to right: motion-blur[,…]");
    add_text(app, "--particles", options->particles,
             "Particles before the other effects, with this preset (list presets particles)");
    add_text(app, "--particle-texture", options->particle_texture,
             "EXR of how a particle's depth is spread over its disc, for particles.profile=texture");
    add_chain_options(app, options->chain, options->save_config);
    add_text(
        app, "--truth", options->truth,
        "Add ground truth: N, for motion blur as the mean of N sub-frames; ambient-occlusion; or N,ambient-occlusion");
    app.add_option("--truth-radius", options->truth_radius,
                   "Length of the rays of true occlusion, metres (default: the effect's, or 1.5)")
        ->check(CLI::Range(1e-3, 1e6));
    app.add_option("--truth-falloff", options->truth_falloff,
                   "What a hit takes away by its distance: hard, linear, quadratic, sao, contact, wide (default: the "
                   "effect's, or hard)");
    app.add_option("--truth-rays", options->truth_rays, "Rays a pixel of true occlusion")
        ->check(CLI::Range(1, 65536))
        ->type_name("N")
        ->capture_default_str();
    app.add_option("--samples", options->request.samples, "Samples a side of each pixel")
        ->check(CLI::Range(1, 8))
        ->type_name("N");
    add_text(app, "--outputs", options->outputs,
             "What effects add: colour, visibility, bent_normal, soft_shadow (default: what they are for)");
    const CLI::Option* preroll =
        app.add_option("--preroll", options->preroll, "Frames to run before the first, for effects with history")
            ->check(CLI::Range(0, 1000))
            ->type_name("N");
    app.add_flag("--passes", options->request.all_passes,
                 "Add direct and ambient light, shadow, and the colour before effects");
    add_text(app, "--device", options->request.device, "Vulkan device: index or part of the name (list devices)");
    app.add_flag("--no-clobber", options->no_clobber, "Refuse to overwrite files");
    app.add_flag("-n,--dry-run", options->dry_run, "Only tell what would be done");
    app.add_flag("--float", options->full_float, "Write colour as 32-bit floats in place of half");
    app.footer("Example: sfumato render fairground -o fair.####.exr --effects motion-blur --preset high --truth 64");
    return [options, preroll](const Invocation& invocation, Console& console) {
        options->has_preroll = preroll->count() > 0;
        return run(*options, invocation, console);
    };
}

} // namespace sfumato::cli
