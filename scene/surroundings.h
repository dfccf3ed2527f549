// What the effects are told of an analytic scene besides its images: solids that particles bounce off, and the sun.
#pragma once

#include "scene/scene.h"

namespace sfumato::scene {

// The primitives at a time, in frames: planes, spheres and boxes as they are, cylinders as boxes of the same section;
// discs have no volume. Scene units, velocities a second. The first most_colliders of them.
std::vector<Collider> colliders_of(const Scene& scene, double frame);

// A camera in the place of the sun, for a square map of what the scene's own camera looks at and half as much again on
// each side: orthographic, depth 0…1, smaller nearer the sun.
struct SunCamera {
    View view;
    Lens lens;
};
SunCamera sun_camera(const Vec3& to_sun, const Vec3& centre, double radius);

} // namespace sfumato::scene
