// A moment of a scene as its shaders see it.
#pragma once

#include "scene/scene.h"
#include "scene/scene_shared.h"

namespace sfumato::scene {

// The scene must fit: see plan_scene.
shared::SceneConstants scene_constants(const Scene& scene, double frame, Extent extent, int samples);

} // namespace sfumato::scene
