// sfumato inspect: what files hold and what their channels mean.
#include "apps/cli/command.h"
#include "apps/cli/frame_list.h"
#include "apps/cli/inspect_report.h"
#include "media/sequence.h"

#include <memory>

namespace sfumato::cli {

namespace {

struct InspectOptions {
    std::vector<std::string> files;
    std::string frames;
    std::string camera;
    ConventionOptions conventions;
};

Result<std::vector<std::filesystem::path>> all_files(const InspectOptions& options) {
    std::vector<std::filesystem::path> paths;
    for (const std::string& file : options.files) {
        const auto pattern = media::FramePattern::parse(file);
        if (!pattern)
            return pattern.error();
        if (!pattern->is_sequence()) {
            paths.emplace_back(file);
            continue;
        }
        const auto found = media::find_frames(*pattern, options.frames);
        if (!found)
            return found.error();
        for (const auto& frame : *found)
            paths.push_back(frame.path);
    }
    return paths;
}

Outcome run(const InspectOptions& options, const Invocation& invocation, Console& console) {
    if (auto checked = check_convention_words(options.conventions); !checked)
        return checked.error();
    const auto paths = all_files(options);
    if (!paths)
        return paths.error();
    const auto cameras = CameraSource::open(options.camera);
    if (!cameras)
        return cameras.error();
    auto list = nlohmann::ordered_json::array();
    ExitCode code = exit_done;
    for (const std::filesystem::path& path : *paths) {
        const auto report = inspect_file(path, options.conventions, *cameras, coding_threads());
        // One broken file does not hide the others.
        if (!report) {
            console.error(report.error());
            code = exit_code_of(report.error().code);
            continue;
        }
        if (invocation.verbosity.json)
            list.push_back(report_json(*report));
        else
            console.result(report_text(*report));
    }
    if (invocation.verbosity.json)
        console.result(list.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return code;
}

} // namespace

Command make_inspect(CLI::App& app) {
    auto options = std::make_shared<InspectOptions>();
    app.add_option("FILE", options->files, "EXR files or a pattern")->required();
    add_text(app, "--frames", options->frames, "Frames of the pattern (default: all)");
    add_text(app, "--layer", options->conventions.layer, "Layer to take colour, depth, normals and motion from");
    add_text(app, "--motion-convention", options->conventions.motion, "Check this reading of the motion channels");
    add_text(app, "--depth-convention", options->conventions.depth, "Use this reading of the depth channel");
    add_text(app, "--normal-space", options->conventions.normals, "Check this space of normals: view, world");
    add_text(app, "--camera", options->camera, "Cameras of the frames, TOML (default: the files' attributes)");
    app.footer("Where the frames before and after stand beside a file, the motion channels are checked by warping.\n"
               "Example: sfumato inspect shot.0006.exr --motion-convention blender,flip-y");
    return [options](const Invocation& invocation, Console& console) { return run(*options, invocation, console); };
}

} // namespace sfumato::cli
