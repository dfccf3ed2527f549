// The one place where the name on the command line becomes a scene.
#pragma once

#include "scene/scene_source.h"

#include <functional>
#include <memory>
#include <string>

namespace sfumato::viewer {

using SceneOpener = std::function<Result<std::unique_ptr<scene::SceneSource>>(Context& context)>;

// Decides what `name` is without a device; opening it comes later, with one. Error (invalid_argument): there is no such
// scene.
Result<SceneOpener> choose_scene(const std::string& name);

} // namespace sfumato::viewer
