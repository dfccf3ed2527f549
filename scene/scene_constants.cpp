// From a scene in double precision to the constants of its shaders.
#include "scene/scene_constants.h"
#include "scene/vec3.h"

#include <algorithm>

namespace sfumato::scene {
namespace {

using shared::SceneConstants;

static_assert(sizeof(SceneConstants) <= 16384, "Vulkan promises no larger uniform block");

shared::vec4 vec4_of(Vec3 v, double w = 0.0) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), static_cast<float>(w)};
}

void copy_pose(const Pose& pose, shared::vec4 (&rows)[3]) {
    for (size_t row = 0; row < 3; ++row)
        rows[row] = vec4_of({pose[row * 4], pose[row * 4 + 1], pose[row * 4 + 2]}, pose[row * 4 + 3]);
}

shared::mat4 mat4_of(const Matrix4& matrix) {
    shared::mat4 result;
    std::ranges::copy(matrix, result.elements);
    return result;
}

// A little wide, so that rounding never cuts a primitive.
double bounding_radius(const Primitive& primitive) {
    const Vec3 size = primitive.size;
    switch (primitive.shape) {
    case Shape::sphere:
    case Shape::disc:
        return size.x * 1.001;
    case Shape::box:
        return std::sqrt(dot(size, size)) * 1.001;
    case Shape::cylinder:
        return std::sqrt(size.x * size.x + size.y * size.y) * 1.001;
    case Shape::plane:
        break;
    }
    return -1.0;
}

shared::ScenePrimitive primitive_constants(const Primitive& primitive, double time) {
    shared::ScenePrimitive result{};
    result.size = vec4_of(primitive.size, bounding_radius(primitive));
    result.shape = static_cast<uint32_t>(primitive.shape);
    result.material = primitive.material;
    const Pose now = pose_at(primitive.motion, time);
    const Pose previous = pose_at(primitive.motion, time - 1.0);
    const Pose next = pose_at(primitive.motion, time + 1.0);
    copy_pose(now, result.now);
    copy_pose(previous, result.previous);
    copy_pose(next, result.next);
    result.flags = (now == previous ? PRIMITIVE_STILL_PREVIOUS : 0u) | (now == next ? PRIMITIVE_STILL_NEXT : 0u) |
                   (primitive.casts_shadow ? PRIMITIVE_CASTS_SHADOW : 0u);
    return result;
}

// The rotation of a rigid matrix is its first three columns.
bool same_rotation(const Camera& a, const Camera& b) {
    return std::equal(a.world_to_view.begin(), a.world_to_view.begin() + 12, b.world_to_view.begin());
}

void set_camera(SceneConstants& constants, const Scene& scene, double frame, Extent extent) {
    const Camera now = camera(scene, frame, extent);
    const Camera previous = camera(scene, frame - 1.0, extent);
    const Camera next = camera(scene, frame + 1.0, extent);
    constants.view = mat4_of(now.world_to_view);
    constants.previous_view = mat4_of(previous.world_to_view);
    constants.next_view = mat4_of(next.world_to_view);
    constants.eye = vec4_of(view_at(scene, frame).eye);
    constants.lens = {1.0f / now.projection[0], -1.0f / now.projection[5], static_cast<float>(extent.width),
                      static_cast<float>(extent.height)};
    const Lens& lens = scene.camera.lens;
    const bool orthographic = now.projection[15] != 0.0f;
    const bool infinite = !orthographic && lens.range == DepthRange::reversed_infinite;
    constants.frustum = {2.0f * static_cast<float>(lens.shift_x), -2.0f * static_cast<float>(lens.shift_y),
                         infinite ? SCENE_SKY_DEPTH : static_cast<float>(lens.far_plane),
                         static_cast<float>(scene.units_per_metre)};
    constants.depth_range = {now.projection[10], now.projection[14], lens.range == DepthRange::standard ? 1.0f : 0.0f,
                             0.0f};
    constants.flags = (orthographic ? SCENE_ORTHOGRAPHIC : 0u) |
                      (lens.depth_kind == DepthKind::device ? SCENE_DEVICE_DEPTH : 0u) |
                      (now.world_to_view == previous.world_to_view ? SCENE_CAMERA_STILL_PREVIOUS : 0u) |
                      (now.world_to_view == next.world_to_view ? SCENE_CAMERA_STILL_NEXT : 0u) |
                      // All rays of an orthographic camera meet the sky in one place.
                      (orthographic || same_rotation(now, previous) ? SCENE_SKY_STILL_PREVIOUS : 0u) |
                      (orthographic || same_rotation(now, next) ? SCENE_SKY_STILL_NEXT : 0u);
}

} // namespace

SceneConstants scene_constants(const Scene& scene, double frame, Extent extent, int samples) {
    SceneConstants constants{};
    set_camera(constants, scene, frame, extent);
    const Light& light = scene.light;
    constants.sun = vec4_of(normalised(light.to_sun));
    constants.sun_colour = vec4_of(light.sun, light.clouds);
    constants.sky_zenith = vec4_of(light.zenith);
    constants.sky_horizon = vec4_of(light.horizon);
    constants.ambient_up = vec4_of(light.ambient_up);
    constants.ambient_down = vec4_of(light.ambient_down);
    constants.primitive_count = static_cast<uint32_t>(scene.primitives.size());
    constants.samples = static_cast<uint32_t>(samples);
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& material = scene.materials[i];
        shared::SceneMaterial& target = constants.materials[i];
        target.colour_a = vec4_of(material.colour_a, material.detail);
        target.colour_b = vec4_of(material.colour_b, material.emission);
        target.pattern = static_cast<uint32_t>(material.pattern);
        target.scale = static_cast<float>(material.scale);
    }
    for (size_t i = 0; i < scene.primitives.size(); ++i)
        constants.primitives[i] = primitive_constants(scene.primitives[i], frame - scene.info.key_frame);
    return constants;
}

} // namespace sfumato::scene
