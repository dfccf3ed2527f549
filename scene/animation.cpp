// Where primitives and camera are at a moment.
#include "scene/scene.h"
#include "scene/vec3.h"

namespace sfumato::scene {
namespace {

double wave(double time, double period, double phase) {
    return std::sin(2.0 * std::numbers::pi * (time / period + phase));
}

// Near plane of the projection in metres. Nothing is clipped by it: linear depth is what the scene gives.
constexpr double near_plane = 0.05;

} // namespace

Pose pose_at(const Motion& motion, double time) {
    const Vec3 pivot =
        motion.pivot + motion.velocity * time + motion.swing * wave(time, motion.swing_period, motion.swing_phase);
    const double angle =
        motion.angle + motion.spin * time + motion.rock * wave(time, motion.rock_period, motion.rock_phase);
    const Rotation turn = rotation(motion.axis, angle);
    const Rotation own =
        rotation({0, 0, 1}, motion.tilt.z) * rotation({0, 1, 0}, motion.tilt.y) * rotation({1, 0, 0}, motion.tilt.x);
    const Rotation r = turn * own;
    const Vec3 p = pivot + turn * motion.offset;
    return {r.x.x, r.x.y, r.x.z, p.x, r.y.x, r.y.y, r.y.z, p.y, r.z.x, r.z.y, r.z.z, p.z};
}

Camera camera(const Scene& scene, double frame, Extent extent) {
    const CameraMotion& motion = scene.camera;
    const double time = frame - scene.info.key_frame;
    const Vec3 eye = motion.eye + motion.eye_velocity * time;
    const Vec3 target = motion.target + motion.target_velocity * time;
    const Vec3 forward = rotation({0, 1, 0}, motion.pan * time) * normalised(target - eye);
    const Vec3 right = normalised(cross(forward, {0, 1, 0}));
    const Vec3 up = cross(right, forward);
    const Vec3 back = forward * -1.0;

    Camera result;
    const auto set_row = [&](size_t row, Vec3 axis) {
        result.world_to_view[row] = static_cast<float>(axis.x);
        result.world_to_view[4 + row] = static_cast<float>(axis.y);
        result.world_to_view[8 + row] = static_cast<float>(axis.z);
        result.world_to_view[12 + row] = static_cast<float>(-dot(axis, eye));
    };
    set_row(0, right);
    set_row(1, up);
    set_row(2, back);
    const double focal = 1.0 / std::tan(radians(motion.view_angle) / 2.0);
    const double aspect = static_cast<double>(extent.width) / extent.height;
    result.projection = {};
    result.projection[0] = static_cast<float>(focal / aspect);
    result.projection[5] = static_cast<float>(-focal);
    result.projection[11] = -1.0f;
    result.projection[14] = static_cast<float>(near_plane);
    return result;
}

Frame frame_facts(const Scene& scene, int frame, Extent extent) {
    Frame facts;
    facts.index = static_cast<uint64_t>(frame);
    facts.time_step = static_cast<float>(1.0 / scene.info.frames_per_second);
    facts.camera = camera(scene, frame, extent);
    facts.previous_camera = camera(scene, frame - 1, extent);
    facts.next_camera = camera(scene, frame + 1, extent);
    return facts;
}

} // namespace sfumato::scene
