// sfumato render: built-in scenes with their passes, effects and ground truth.
#include "apps/cli/command.h"
#include "apps/cli/effect_runner.h"
#include "apps/cli/frame_list.h"
#include "apps/cli/frame_writer.h"
#include "apps/cli/pipeline.h"
#include "apps/cli/render_file.h"
#include "apps/cli/render_particles.h"
#include "media/png_file.h"
#include "media/sequence.h"
#include "scene/scene_source.h"

#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

namespace sfumato::cli {

namespace {

// The ground truths that are wanted.
struct TruthRequest {
    int sub_frames = 0; // of motion blur; 0: not wanted
    bool occlusion = false;
    scene::OcclusionTruth rays;
};

struct RenderCommandOptions {
    std::string scene, output, frames, device, save_config;
    std::string size = "960x540";
    ChainOptions chain;
    std::string particles; // preset of the particles that come before the other effects
    std::string truth;
    std::optional<double> truth_radius; // else the effect's, else 1.5
    std::string truth_falloff;          // else the effect's, else hard
    int truth_rays = 256;
    TruthRequest truths; // what `truth` says
    std::string outputs;
    int samples = 2;
    int preroll = 0;
    bool has_preroll = false;
    bool all_passes = false;
    bool full_float = false;
    bool no_clobber = false;
    bool dry_run = false;
};

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

Result<const scene::Scene*> choose_scene(const std::string& name) {
    if (const scene::Scene* found = scene::find_scene(name))
        return found;
    std::vector<std::string> names;
    for (const scene::Scene& one : scene::scenes())
        names.push_back(one.info.name);
    const std::string hint = did_you_mean(name, names);
    return usage_error(fmt::format("no scene is called '{}'{}", name,
                                   hint.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : hint));
}

// Without --frames: the key frame for one file, all frames for a pattern.
Result<std::vector<media::SequenceFrame>> choose_frames(const RenderCommandOptions& options,
                                                        const scene::Scene& scene) {
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

// The truth opens its shutter as the blur in the chain does.
scene::Shutter shutter_of(const EffectChain& chain, int sub_frames) {
    scene::Shutter shutter;
    shutter.sub_frames = sub_frames;
    for (const ChainLink& link : chain) {
        const ParameterInfo* open = link.effect->parameters->find("shutter");
        const ParameterInfo* position = link.effect->parameters->find("shutter_position");
        if (!open || !position)
            continue;
        shutter.open = open->get(link.parameters.data());
        shutter.position = static_cast<scene::ShutterPosition>(static_cast<int>(position->get(link.parameters.data())));
    }
    return shutter;
}

constexpr uint32_t sun_map_side = 1024;

class SceneFrames {
  public:
    SceneFrames(const RenderCommandOptions& options, const EffectChain& chain, const scene::Scene& scene, Extent extent)
        : options_(options), chain_(chain), scene_(scene), extent_(extent) {}

    ~SceneFrames() {
        if (device_)
            static_cast<void>(static_cast<bool>(device_->wait_idle()));
    }

    Result<void> open() {
        apps::DeviceOptions device_options;
        device_options.device = options_.device;
        auto device = apps::Device::create(device_options);
        if (!device)
            return as_device(device.error());
        device_ = std::move(*device);
        auto runner = EffectRunner::create(*device_, chain_, 2);
        if (!runner)
            return runner.error();
        runner_ = std::move(*runner);
        if (auto prepared = runner_->prepare(extent_); !prepared)
            return prepared;
        auto source = scene::make_source(runner_->context(), scene_);
        if (!source)
            return as_device(source.error());
        source_ = std::move(*source);
        return make_images();
    }

    Result<RenderedFrame> render(int number, bool restarts) {
        if (restarts)
            if (auto restarted = runner_->restart(); !restarted)
                return restarted.error();
        auto commands = device_->begin();
        if (!commands)
            return as_device(commands.error());
        scene::RenderOptions render_options;
        render_options.samples = options_.samples;
        render_options.shutter = shutter_of(chain_, std::max(1, options_.truths.sub_frames));
        render_options.occlusion = options_.truths.rays;
        if (auto recorded = source_->record(*commands, number, render_options, scene_images(), count_); !recorded)
            return as_device(recorded.error());
        if (sun_map_.extent())
            if (auto recorded = source_->record_sun_map(*commands, number, sun_map_.image(), count_); !recorded)
                return as_device(recorded.error());
        ++count_;
        if (auto recorded = runner_->record(*commands, source_->frame_facts(number, extent_), role_images()); !recorded)
            return as_device(recorded.error());
        if (auto done = device_->submit_and_wait(); !done)
            return as_device(done.error());
        return read_back(number);
    }

    const std::string& device_name() const { return device_->name(); }

  private:
    Result<void> make_images() {
        std::vector<std::pair<const char*, uint32_t>> wanted = {
            {"colour", 4}, {"depth", 1}, {"normal", 4}, {"velocity", 2}, {"next_velocity", 2}};
        if (options_.all_passes || chain_uses(chain_, "direct"))
            wanted.emplace_back("direct", 4);
        if (options_.all_passes || chain_uses(chain_, "ambient"))
            wanted.emplace_back("ambient", 4);
        if (options_.all_passes || chain_uses(chain_, "shadow"))
            wanted.emplace_back("shadow", 1);
        if (options_.truths.sub_frames > 0)
            wanted.emplace_back("truth", 4);
        if (options_.truths.occlusion)
            wanted.insert(wanted.end(), {{"true_visibility", 1}, {"true_bent_normal", 4}});
        for (const auto& [name, components] : wanted) {
            auto image = device_->create_image(float_format(components), extent_);
            if (!image)
                return as_device(image.error());
            images_[name] = std::move(*image);
        }
        if (chain_uses(chain_, "shadow_map") && source_->has_sun_map()) {
            auto map = device_->create_image(float_format(1), {sun_map_side, sun_map_side});
            if (!map)
                return as_device(map.error());
            sun_map_ = std::move(*map);
        }
        return {};
    }

    Image image(const char* name) const {
        const auto found = images_.find(name);
        return found == images_.end() ? Image{} : found->second.image();
    }

    scene::SceneImages scene_images() const {
        return {image("colour"), image("direct"),          image("ambient"),         image("depth"),
                image("normal"), image("velocity"),        image("next_velocity"),   image("shadow"),
                image("truth"),  image("true_visibility"), image("true_bent_normal")};
    }

    RoleImages role_images() const {
        RoleImages roles;
        for (const auto& [name, image] : images_)
            roles[name] = image.image();
        roles["normals"] = image("normal");
        roles["shadow_map"] = sun_map_.image();
        return roles;
    }

    Result<void> read_pass(RenderedFrame& frame, const std::string& name, const apps::HostImage& image) {
        auto values = device_->readback(image);
        if (!values)
            return as_device(values.error());
        const auto components = static_cast<uint32_t>(values->size() / (size_t{extent_.width} * extent_.height));
        frame.passes[name] = {components, std::move(*values)};
        return {};
    }

    Result<RenderedFrame> read_back(int number) {
        RenderedFrame frame{extent_, number, scene_.info.frames_per_second, scene::camera(scene_, number, extent_), {}};
        const apps::HostImage* result = runner_->colour();
        for (const auto& [name, image] : images_) {
            if (name == "colour" && result && !options_.all_passes)
                continue;
            if (auto read = read_pass(frame, name == "colour" && result ? "sharp" : name, image); !read)
                return read.error();
        }
        if (result)
            if (auto read = read_pass(frame, "colour", *result); !read)
                return read.error();
        for (const auto& [name, extra] : runner_->extras()) {
            if (auto read = read_pass(frame, name, *extra.image); !read)
                return read.error();
            RenderedPass& pass = frame.passes[name];
            for (uint32_t c = 0; c < extra.role->components; ++c)
                pass.channels.push_back(extra_channel(name, *extra.role, c));
        }
        return frame;
    }

    const RenderCommandOptions& options_;
    const EffectChain& chain_;
    const scene::Scene& scene_;
    Extent extent_;
    uint64_t count_ = 0;
    std::unique_ptr<apps::Device> device_;
    std::unique_ptr<EffectRunner> runner_;
    std::unique_ptr<scene::SceneSource> source_;
    std::map<std::string, apps::HostImage> images_;
    apps::HostImage sun_map_;
};

Result<void> write_png(const RenderedFrame& frame, const std::filesystem::path& path, const EffectChain& chain,
                       const RenderCommandOptions& options) {
    // A picture holds one thing: the truth, if it was asked for and nothing else stands in its place.
    std::string shown = options.truths.occlusion        ? "true_visibility"
                        : options.truths.sub_frames > 0 ? "truth"
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
    image.parts.front().set_string_attribute("sfumato/scene", options.scene);
    media::ExrWriteOptions write_options;
    write_options.no_clobber = options.no_clobber;
    write_options.threads = coding_threads();
    return media::write_exr(path, image, write_options);
}

Outcome render_all(const std::vector<media::SequenceFrame>& frames, SceneFrames& source, const EffectChain& chain,
                   const RenderCommandOptions& options, const Invocation& invocation, Console& console) {
    if (auto opened = source.open(); !opened)
        return opened.error();
    console.note("device: " + source.device_name());
    console.start_progress(frames.size());
    nlohmann::ordered_json json = {{"scene", options.scene}, {"device", source.device_name()}};
    for (size_t i = 0; i < frames.size() && !interrupted; ++i) {
        const bool restarts = i > 0 && frames[i].frame != frames[i - 1].frame + 1;
        const int start = i == 0 || restarts ? std::max(frames[i].frame - options.preroll, 0) : frames[i].frame;
        for (int before = start; before < frames[i].frame; ++before)
            if (auto rendered = source.render(before, restarts && before == start); !rendered)
                return rendered.error();
        auto frame = source.render(frames[i].frame, restarts && start == frames[i].frame);
        if (!frame)
            return frame.error();
        if (auto written = write_rendered(*frame, frames[i].path, chain, options, invocation); !written)
            return written.error();
        json["outputs"].push_back(frames[i].path.string());
        console.advance(fmt::format("{} frame {} -> {}", options.scene, frames[i].frame, frames[i].path.string()));
    }
    console.end_progress();
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
    auto format = output_format(options.output);
    if (!format)
        return format.error();
    const auto truths = parse_truth(options);
    if (!truths)
        return truths.error();
    options.truths = *truths;
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
    if (!options.particles.empty() && !options.has_preroll)
        options.preroll = particles_preroll(*chain);
    if (auto completed = complete_truth(options.truths, options, *chain); !completed)
        return completed.error();
    auto frames = choose_frames(options, **scene);
    if (!frames)
        return frames.error();
    for (const auto& [frame, path] : *frames)
        if (std::error_code failed; options.no_clobber && std::filesystem::exists(path, failed))
            return input_error(
                fmt::format("{}: exists already, and --no-clobber forbids to overwrite it", path.string()));
    if (options.dry_run) {
        for (const auto& [frame, path] : *frames)
            console.line(fmt::format("would render {} frame {} -> {}", options.scene, frame, path.string()));
        return exit_done;
    }
    if (!options.save_config.empty())
        if (auto saved = save_config(*chain, options.save_config, options.no_clobber); !saved)
            return saved.error();
    catch_interrupts();
    SceneFrames source(options, *chain, **scene, *extent);
    return render_all(*frames, source, *chain, options, invocation, console);
}

} // namespace

Command make_render(CLI::App& app) {
    auto options = std::make_shared<RenderCommandOptions>();
    app.add_option("SCENE", options->scene, "A built-in scene (list scenes)")->required();
    add_text(app, "-o,--output", options->output, "File or pattern: .exr with all channels, or .png")->required();
    add_text(app, "--frames", options->frames, "Frames (default: the key frame, or all for a pattern)");
    add_text(app, "--size", options->size, "WIDTHxHEIGHT (default: 960x540)");
    add_text(app, "--effects", options->chain.effects, "Effects, left to right: motion-blur[,…]");
    add_text(app, "--particles", options->particles,
             "Particles before the other effects, with this preset (list presets particles)");
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
    app.add_option("--samples", options->samples, "Samples a side of each pixel")
        ->check(CLI::Range(1, 8))
        ->type_name("N");
    add_text(app, "--outputs", options->outputs,
             "What effects add: colour, visibility, bent_normal, soft_shadow (default: what they are for)");
    const CLI::Option* preroll =
        app.add_option("--preroll", options->preroll, "Frames to run before the first, for effects with history")
            ->check(CLI::Range(0, 1000))
            ->type_name("N");
    app.add_flag("--passes", options->all_passes,
                 "Add direct and ambient light, shadow, and the colour before effects");
    add_text(app, "--device", options->device, "Vulkan device: index or part of the name (list devices)");
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
