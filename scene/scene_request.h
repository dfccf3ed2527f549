// What a frame is asked for, whatever kind of scene gives it: checks, and the moments of an open shutter.
#pragma once

#include "scene/scene.h"

#include <vector>

namespace sfumato::scene {

// Errors (invalid_argument): images that differ in extent, none present.
Result<Extent> common_extent(const SceneImages& images);

// Errors (invalid_argument), beginning with the scene's name: options, lens or time out of range.
Result<void> check_request(const SceneInfo& info, const Lens& lens, double frame, const RenderOptions& options);

// The sub-frames of a running mean, in order.
struct Moment {
    double frame = 0.0; // its time
    float share = 1.0f; // weight of this moment over the weights so far, this one included; 1: the mean starts anew
};
std::vector<Moment> shutter_moments(const Shutter& shutter, double frame);

} // namespace sfumato::scene
