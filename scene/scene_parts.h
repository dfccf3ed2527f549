// What the built-in scenes are made of: materials and the commonest ways to place and to move a primitive.
#pragma once

#include "scene/scene.h"

#include <numbers>

namespace sfumato::scene {

inline constexpr double degrees_a_radian = 57.29577951308232;

// Materials that several scenes use.
inline constexpr Material paving = {Pattern::tiles, {0.52, 0.50, 0.46}, {0.36, 0.35, 0.35}, 1.1, 0.5};
inline constexpr Material grass = {Pattern::noise, {0.16, 0.30, 0.09}, {0.30, 0.36, 0.14}, 2.5, 0.7};
inline constexpr Material brick = {Pattern::bricks, {0.50, 0.24, 0.17}, {0.62, 0.58, 0.52}, 1.6, 0.5};
inline constexpr Material sandstone = {Pattern::bricks, {0.66, 0.56, 0.42}, {0.42, 0.36, 0.29}, 1.2, 0.6};
inline constexpr Material marble = {Pattern::noise, {0.74, 0.72, 0.68}, {0.50, 0.49, 0.50}, 3.0, 0.25};
inline constexpr Material wood = {Pattern::stripes, {0.52, 0.34, 0.19}, {0.42, 0.26, 0.14}, 7.0, 0.5};
inline constexpr Material steel = {Pattern::solid, {0.40, 0.42, 0.45}, {}, 1.0, 0.25};
inline constexpr Material red_white = {Pattern::rings, {0.78, 0.10, 0.08}, {0.86, 0.83, 0.76}, 3.2, 0.2};
inline constexpr Material red_cream = {Pattern::sectors, {0.80, 0.13, 0.08}, {0.88, 0.82, 0.68}, 5.0, 0.25};
inline constexpr Material blue_white = {Pattern::checker, {0.11, 0.25, 0.66}, {0.84, 0.86, 0.88}, 3.0, 0.25};
inline constexpr Material yellow_black = {Pattern::stripes, {0.86, 0.63, 0.09}, {0.07, 0.07, 0.07}, 5.0, 0.2};
inline constexpr Material teal = {Pattern::checker, {0.08, 0.42, 0.40}, {0.70, 0.76, 0.62}, 4.0, 0.3};

// A primitive that stands still.
inline Primitive still(Shape shape, Vec3 size, uint32_t material, Vec3 place, Vec3 tilt = {}) {
    return {shape, size, material, {.pivot = place, .tilt = tilt}, true};
}

inline Primitive moving(Shape shape, Vec3 size, uint32_t material, const Motion& motion) {
    return {shape, size, material, motion, true};
}

// Adds an oscillation to a motion that passes its middle with `velocity` at the key frame: as fast as a flight there,
// but never out of sight.
inline Motion swinging(Vec3 velocity, double period, Motion motion) {
    const double reach = period / (2.0 * std::numbers::pi);
    motion.swing = {velocity.x * reach, velocity.y * reach, velocity.z * reach};
    motion.swing_period = period;
    return motion;
}

inline Primitive ground(uint32_t material) {
    return {Shape::plane, {1, 1, 1}, material, {}, false};
}

// A ball that rolls without slipping along +x (speed > 0) or -x.
inline Primitive rolling(double radius, uint32_t material, Vec3 place, double speed) {
    return {Shape::sphere,
            {radius, radius, radius},
            material,
            {.pivot = place,
             .velocity = {speed, 0, 0},
             .axis = {0, 0, -1},
             .spin = speed / radius * degrees_a_radian,
             .tilt = {70, 0, 20}},
            true};
}

// Scenes that show what goes wrong with screen-space ambient occlusion.
std::vector<Scene> occlusion_scenes();

Scene smoke_columns();

} // namespace sfumato::scene
