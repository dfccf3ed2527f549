// sfumato view: the interactive viewer.
#include "apps/cli/command.h"
#include "apps/cli/frame_list.h"
#include "apps/cli/viewpoint.h"
#include "apps/viewer/viewer.h"

#include <fmt/format.h>
#include <memory>

namespace sfumato::cli {

namespace {

struct ViewCommandOptions {
    viewer::ViewerOptions viewer;
    std::string size = "1280x720";
};

Outcome run(ViewCommandOptions options, Console& console) {
    viewer::ViewerOptions& viewer = options.viewer;
    const auto size = parse_size(options.size);
    if (!size)
        return size.error();
    viewer.size = *size;
    if (viewer.headless && viewer.output.empty())
        return usage_error("--headless makes a picture; say where to, with -o picture.png");
    if (!viewer.output.empty()) {
        auto format = output_format(viewer.output);
        if (!format)
            return format.error();
        if (*format != "png")
            return usage_error(fmt::format("-o {}: the viewer's picture is a .png", viewer.output));
    }
    const auto note = [&](const std::string& text) { viewer.headless ? console.line(text) : console.note(text); };
    if (auto done = viewer::run_viewer(viewer, note); !done)
        return done.error();
    return exit_done;
}

} // namespace

Command make_view(CLI::App& app) {
    auto options = std::make_shared<ViewCommandOptions>();
    viewer::ViewerOptions& viewer = options->viewer;
    app.add_option("SCENE", viewer.scene, "A built-in scene (list scenes), or a .gltf or .glb file")->required();
    add_text(app, "--animation", viewer.animation, "Of a model: name or number, none for its pose at rest");
    app.add_flag("--no-ground", viewer.no_ground, "A model without the ground below it");
    add_text(app, "--effects", viewer.chain.effects,
             "Effects that are on at the start, left to right (default: those that the scene is made for)");
    add_chain_options(app, viewer.chain, viewer.save_config);
    add_text(app, "--size", options->size, "WIDTHxHEIGHT of the window (default: 1280x720)");
    app.add_option("--scale", viewer.scale, "Pixels of the picture for one of the window's (default: 1)")
        ->check(CLI::Range(0.1, 1.0))
        ->type_name("");
    app.add_option("--frame", viewer.frame, "Frame to begin at (default: the key frame)")->type_name("N");
    add_text(app, "--viewpoint", viewer.viewpoint, viewpoint_doc);
    app.add_option("--samples", viewer.samples, "Samples a side of each pixel")
        ->check(CLI::Range(1, 8))
        ->type_name("N");
    app.add_option("--preroll", viewer.preroll, "Frames before a picture of a paused scene, for effects with history")
        ->check(CLI::Range(0, 1000))
        ->type_name("N");
    add_text(app, "--left", viewer.left, "Left of the divider: before, result, truth, depth, EFFECT.OUTPUT, …");
    add_text(app, "--right", viewer.right, "Right of it, or alone: result, difference, …");
    app.add_option("--split", viewer.split, "Where the divider is, 0 to 1; -1: no divider (default: 0.5; headless: -1)")
        ->check(CLI::Range(-1.0, 1.0))
        ->type_name("");
    add_text(app, "--truth", viewer.truth, "Compare with ground truth: motion-blur or ambient-occlusion");
    app.add_flag("--play", viewer.play, "Begin playing");
    add_text(app, "--device", viewer.device, "Vulkan device: index or part of the name (list devices)");
    app.add_flag("--headless", viewer.headless, "No window: write what it would show to -o and end");
    app.add_option("--frames", viewer.turns, "Headless: how often to render before writing")
        ->check(CLI::Range(1, 100000))
        ->type_name("N");
    app.add_flag("--ui", viewer.panels, "Headless: with the panels");
    add_text(app, "-o,--output", viewer.output, "The picture: written by --headless, offered for saving otherwise");
    // For tests.
    app.add_flag("--validate", viewer.validate)->group("");
    app.add_option("--widget-log", viewer.widget_log)->group("");
    app.footer("Example: sfumato view fairground --effects motion-blur,ambient-occlusion --scale 0.5");
    const CLI::Option* split = app.get_option("--split");
    return [options, split](const Invocation&, Console& console) {
        if (options->viewer.headless && split->count() == 0)
            options->viewer.split = -1.0;
        return run(*options, console);
    };
}

} // namespace sfumato::cli
