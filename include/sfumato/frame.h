// Facts of one frame that the host passes with its images.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace sfumato {

// 4×4, column-major (element [column * 4 + row]), transforms column vectors: clip = projection * view * world.
using Matrix4 = std::array<float, 16>;

inline constexpr Matrix4 identity_matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// `world_to_view`: right-handed view space, the camera looks along -Z, +Y up.
// `projection`: view space to Vulkan clip space, +x right, +y DOWN, depth 0…1. Perspective, off-centre, orthographic,
// standard, reversed and infinite projections are all read off this matrix; no near or far plane is asked for.
// Both without TAA jitter, or with the jitter told in `jitter`.
struct Camera {
    Matrix4 world_to_view = identity_matrix;
    Matrix4 projection = identity_matrix;
    // Sub-pixel jitter contained in `projection`, in pixels, +x right, +y down: where a point lands minus where it
    // would land without jitter.
    std::array<float, 2> jitter = {0, 0};
};

enum class DepthKind {
    linear, // view depth: distance along the viewing axis in scene units, > 0; infinity, NaN or >= 1e9 where nothing is
    device, // the depth buffer's 0…1, as `projection` gives it (standard, reversed, infinite, orthographic)
};

// A distant light.
struct Light {
    std::array<float, 3> to_light = {0, 1, 0}; // world space, towards the light; any length above 0
    std::array<float, 3> radiance = {1, 1, 1}; // irradiance of a surface that faces it, linear
    // World space to the clip space of the host's shadow map of this light, as Camera::projection does it: x and y -1…1
    // over the map (+y down), z the map's depth, smaller nearer the light. Only read where an effect is given the map.
    Matrix4 world_to_shadow = identity_matrix;
};

enum class ColliderShape : uint32_t {
    plane,  // through `centre`, solid below: its normal is axes[1]
    sphere, // radius size[0]
    box,    // half extents `size` along the axes
};

// A solid that particles bounce off.
struct Collider {
    ColliderShape shape = ColliderShape::plane;
    std::array<float, 3> centre = {0, 0, 0}; // world space
    std::array<float, 3> size = {1, 1, 1};   // > 0
    // Unit vectors at right angles to each other, world space.
    std::array<std::array<float, 3>, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    std::array<float, 3> velocity = {0, 0, 0}; // of the centre, scene units a second
};

inline constexpr size_t most_lights = 4;
inline constexpr size_t most_colliders = 32;

struct Frame {
    uint64_t index = 0;             // the host's frame number; decorrelates noise, advances histories
    float time_step = 1.0f / 60.0f; // seconds from the previous frame to this one
    std::optional<Camera> camera;   // of this frame
    std::optional<Camera> previous_camera;
    std::optional<Camera> next_camera;
    DepthKind depth_kind = DepthKind::linear;
    bool reset = false;            // camera cut, teleport, first frame: histories are cleared, velocities distrusted
    std::span<const Light> lights; // the host's during the call; at most most_lights
    std::span<const Collider> colliders; // likewise; at most most_colliders
};

} // namespace sfumato
