// What all kinds of scenes share, and a camera path for any of them.
#include "scene/scene_source.h"
#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene {

Frame SceneSource::frame_facts(double frame, Extent extent) const {
    Frame facts;
    facts.index = static_cast<uint64_t>(std::max(frame, 0.0));
    facts.time_step = static_cast<float>(1.0 / info().frames_per_second);
    facts.camera = camera(frame, extent);
    facts.previous_camera = camera(frame - 1.0, extent);
    facts.next_camera = camera(frame + 1.0, extent);
    facts.depth_kind = lens().depth_kind;
    return facts;
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
