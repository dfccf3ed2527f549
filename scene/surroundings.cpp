#include "scene/surroundings.h"

#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene {
namespace {

std::array<float, 3> array_of(Vec3 v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// The solid that stands for a primitive, or none.
std::optional<ColliderShape> solid_of(Shape shape) {
    switch (shape) {
    case Shape::sphere:
        return ColliderShape::sphere;
    case Shape::box:
    case Shape::cylinder:
        return ColliderShape::box;
    case Shape::plane:
        return ColliderShape::plane;
    case Shape::disc:
        break;
    }
    return std::nullopt;
}

Vec3 half_extents(const Primitive& primitive) {
    if (primitive.shape != Shape::cylinder)
        return primitive.size;
    const double side = 0.5 * std::sqrt(std::numbers::pi) * primitive.size.x;
    return {side, primitive.size.y, side};
}

Vec3 place_of(const Pose& pose) {
    return {pose[3], pose[7], pose[11]};
}

} // namespace

std::vector<Collider> colliders_of(const Scene& scene, double frame) {
    std::vector<Collider> colliders;
    for (const Primitive& primitive : scene.primitives) {
        const auto shape = solid_of(primitive.shape);
        if (!shape || colliders.size() == most_colliders)
            continue;
        const double time = frame - scene.info.key_frame;
        const Pose now = pose_at(primitive.motion, time), before = pose_at(primitive.motion, time - 1.0);
        Collider& collider = colliders.emplace_back();
        collider.shape = *shape;
        collider.centre = array_of(place_of(now));
        if (*shape != ColliderShape::plane)
            collider.size = *shape == ColliderShape::sphere
                                ? array_of({primitive.size.x, primitive.size.x, primitive.size.x})
                                : array_of(half_extents(primitive));
        for (size_t axis = 0; axis < 3; ++axis)
            collider.axes[axis] = array_of({now[axis], now[4 + axis], now[8 + axis]});
        collider.velocity = array_of((place_of(now) - place_of(before)) * scene.info.frames_per_second);
    }
    return colliders;
}

SunCamera sun_camera(const Vec3& to_sun, const Vec3& centre, double radius) {
    const Vec3 out = normalised(to_sun);
    const double reach = 3.0 * radius, distance = 4.0 * reach;
    SunCamera camera;
    camera.view.eye = centre + out * distance;
    camera.view.forward = out * -1.0;
    // Any direction across will do, but not one along the light.
    camera.view.up = std::abs(out.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
    camera.lens.orthographic_height = 2.0 * reach;
    camera.lens.range = DepthRange::standard;
    camera.lens.near_plane = 0.01 * distance;
    camera.lens.far_plane = 2.0 * distance;
    camera.lens.depth_kind = DepthKind::device;
    return camera;
}

} // namespace sfumato::scene
