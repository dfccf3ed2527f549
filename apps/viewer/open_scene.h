// The one place where the name on the command line becomes a scene.
#pragma once

#include "apps/cli/render_scene.h"
#include "scene/scene_source.h"

#include <functional>
#include <memory>
#include <string>

namespace sfumato::viewer {

using SceneOpener =
    std::function<Result<std::unique_ptr<scene::SceneSource>>(const apps::Device& device, Context& context)>;

struct ChosenScene {
    SceneOpener open;
    cli::SceneFit fit;
};

// Decides what is asked for without a device: a built-in scene, or a glTF file; opening it comes later, with one, and
// once. Errors: there is no such scene, file or animation, or the file is broken.
Result<ChosenScene> choose_scene(const cli::SceneOptions& options);

} // namespace sfumato::viewer
