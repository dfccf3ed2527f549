// Where primitives and camera are at a moment.
#include "scene/scene.h"
#include "scene/vec3.h"

#include <utility>

namespace sfumato::scene {
namespace {

double wave(double time, double period, double phase) {
    return std::sin(2.0 * std::numbers::pi * (time / period + phase));
}

// Elements 10 and 14 of a projection: view depth t becomes [14] - [10] t, divided by t if perspective.
std::pair<double, double> depth_elements(const Lens& lens, bool orthographic) {
    const double n = lens.near_plane, f = lens.far_plane, length = f - n;
    if (lens.range == DepthRange::standard)
        return orthographic ? std::pair{-1.0 / length, -n / length} : std::pair{-f / length, -n * f / length};
    if (orthographic)
        return {1.0 / length, f / length};
    if (lens.range == DepthRange::reversed)
        return {n / length, n * f / length};
    return {0.0, n};
}

Matrix4 projection(double view_angle, const Lens& lens, Extent extent) {
    const bool orthographic = lens.orthographic_height > 0.0;
    const double focal = orthographic ? 2.0 / lens.orthographic_height : 1.0 / std::tan(radians(view_angle) / 2.0);
    const double aspect = static_cast<double>(extent.width) / extent.height;
    const auto [scale, offset] = depth_elements(lens, orthographic);
    // Perspective divides by -z, so that the third column shifts; orthographic shifts by the fourth.
    const size_t shift = orthographic ? 12 : 8;
    const double sign = orthographic ? -2.0 : 2.0;
    Matrix4 result = {};
    result[0] = static_cast<float>(focal / aspect);
    result[5] = static_cast<float>(-focal);
    result[shift] = static_cast<float>(sign * lens.shift_x);
    result[shift + 1] = static_cast<float>(-sign * lens.shift_y);
    result[10] = static_cast<float>(scale);
    result[14] = static_cast<float>(offset);
    result[orthographic ? 15 : 11] = orthographic ? 1.0f : -1.0f;
    return result;
}

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

View view_at(const Scene& scene, double frame) {
    if (scene.camera_path)
        return scene.camera_path(frame);
    const CameraMotion& motion = scene.camera;
    const double time = frame - scene.info.key_frame;
    View view;
    view.eye = motion.eye + motion.eye_velocity * time;
    const Vec3 ahead = motion.target + motion.target_velocity * time - view.eye;
    view.forward = rotation({0, 1, 0}, motion.pan * time) * normalised(ahead);
    view.view_angle = motion.view_angle;
    return view;
}

Camera camera_of(const View& view, const Lens& lens, Extent extent) {
    const Vec3 forward = normalised(view.forward);
    const Vec3 right = normalised(cross(forward, view.up));
    const Vec3 up = cross(right, forward);
    const Vec3 back = forward * -1.0;

    Camera result;
    const auto set_row = [&](size_t row, Vec3 axis) {
        result.world_to_view[row] = static_cast<float>(axis.x);
        result.world_to_view[4 + row] = static_cast<float>(axis.y);
        result.world_to_view[8 + row] = static_cast<float>(axis.z);
        result.world_to_view[12 + row] = static_cast<float>(-dot(axis, view.eye));
    };
    set_row(0, right);
    set_row(1, up);
    set_row(2, back);
    result.projection = projection(view.view_angle, lens, extent);
    return result;
}

Camera camera(const Scene& scene, double frame, Extent extent) {
    return camera_of(view_at(scene, frame), scene.camera.lens, extent);
}

Frame frame_facts(const Scene& scene, int frame, Extent extent) {
    Frame facts;
    facts.index = static_cast<uint64_t>(frame);
    facts.time_step = static_cast<float>(1.0 / scene.info.frames_per_second);
    facts.camera = camera(scene, frame, extent);
    facts.previous_camera = camera(scene, frame - 1, extent);
    facts.next_camera = camera(scene, frame + 1, extent);
    facts.depth_kind = scene.camera.lens.depth_kind;
    return facts;
}

Scene in_units(Scene scene, double units_per_metre) {
    const double factor = units_per_metre / scene.units_per_metre;
    const auto scale = [&](auto&... lengths) { ((lengths = lengths * factor), ...); };
    CameraMotion& view = scene.camera;
    scale(view.eye, view.eye_velocity, view.target, view.target_velocity, view.lens.orthographic_height,
          view.lens.near_plane, view.lens.far_plane);
    for (Primitive& primitive : scene.primitives) {
        Motion& motion = primitive.motion;
        scale(primitive.size, motion.pivot, motion.velocity, motion.swing, motion.offset);
    }
    scene.units_per_metre = units_per_metre;
    return scene;
}

} // namespace sfumato::scene
