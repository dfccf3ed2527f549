// What all kinds of scenes share, and a camera path for any of them.
#include "scene/scene_source.h"
#include "scene/surroundings.h"
#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene {
namespace {

Matrix4 product(const Matrix4& a, const Matrix4& b) {
    Matrix4 result{};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row)
            for (size_t i = 0; i < 4; ++i)
                result[column * 4 + row] += a[i * 4 + row] * b[column * 4 + i];
    return result;
}

} // namespace

Frame SceneSource::frame_facts(double frame, Extent extent) const {
    Frame facts;
    facts.index = static_cast<uint64_t>(std::max(frame, 0.0));
    facts.time_step = static_cast<float>(1.0 / info().frames_per_second);
    facts.camera = camera(frame, extent);
    facts.previous_camera = camera(frame - 1.0, extent);
    facts.next_camera = camera(frame + 1.0, extent);
    facts.depth_kind = lens().depth_kind;
    const auto single = [](Vec3 v) {
        return std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
    };
    lights_[0].to_light = single(to_sun());
    lights_[0].radiance = single(sun());
    const SunCamera map = sun_camera(to_sun(), bounds().centre, bounds().radius);
    const Camera seen = camera_of(map.view, map.lens, {1, 1});
    lights_[0].world_to_shadow = product(seen.projection, seen.world_to_view);
    colliders_ = colliders(frame);
    facts.lights = lights_;
    facts.colliders = colliders_;
    return facts;
}

Result<void> SceneSource::record_sun_map(VkCommandBuffer, double, const Image&, uint64_t) {
    return Error{ErrorCode::unsupported, info().name + " has no map of what the sun sees"};
}

CameraPath turntable(const Bounds& bounds, double view_angle, double frames, double elevation) {
    const double distance = bounds.radius / std::sin(radians(view_angle) / 2.0);
    return [=](double frame) {
        const double turn = 2.0 * std::numbers::pi * frame / frames, height = radians(elevation);
        const Vec3 out = {std::sin(turn) * std::cos(height), std::sin(height), std::cos(turn) * std::cos(height)};
        View view;
        view.eye = bounds.centre + out * distance;
        view.forward = out * -1.0;
        view.view_angle = view_angle;
        return view;
    };
}

} // namespace sfumato::scene
