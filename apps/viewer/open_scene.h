// The one place where the name on the command line becomes a scene.
#pragma once

#include "apps/common/device.h"
#include "scene/scene_source.h"

#include <functional>
#include <memory>
#include <string>

namespace sfumato::viewer {

using SceneOpener =
    std::function<Result<std::unique_ptr<scene::SceneSource>>(const apps::Device& device, Context& context)>;

// Decides what `name` is without a device: a built-in scene, or a glTF file; opening it comes later, with one, and
// once. Errors: there is no such scene or file, or the file is broken.
Result<SceneOpener> choose_scene(const std::string& name);

} // namespace sfumato::viewer
