// Orbiting and flying.
#include "apps/viewer/camera_rig.h"

#include "scene/vec3.h"

#include <algorithm>
#include <cmath>

namespace sfumato::viewer {

using namespace scene; // Vec3 and its arithmetic

namespace {

constexpr double steepest = 89.0; // degrees: straight up has no direction to the right
constexpr double radian = 180.0 / std::numbers::pi;

} // namespace

CameraRig::CameraRig(const View& view, const Bounds& bounds) {
    const Vec3 ahead = normalised(view.forward);
    eye_ = view.eye;
    pitch_ = std::asin(std::clamp(ahead.y, -1.0, 1.0)) * radian;
    yaw_ = std::atan2(-ahead.x, -ahead.z) * radian;
    view_angle_ = view.view_angle;
    least_distance_ = bounds.radius * 1e-3;
    distance_ = std::max(dot(bounds.centre - view.eye, ahead), bounds.radius * 0.1);
    limit();
}

Vec3 CameraRig::forward() const {
    const double yaw = radians(yaw_), pitch = radians(pitch_);
    return {-std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch)};
}

Vec3 CameraRig::right() const {
    const double yaw = radians(yaw_);
    return {std::cos(yaw), 0.0, -std::sin(yaw)};
}

void CameraRig::limit() {
    pitch_ = std::clamp(pitch_, -steepest, steepest);
    yaw_ = std::remainder(yaw_, 360.0);
    distance_ = std::max(distance_, least_distance_);
}

View CameraRig::view() const {
    View view;
    view.eye = eye_;
    view.forward = forward();
    view.view_angle = view_angle_;
    return view;
}

void CameraRig::set_view_angle(double degrees) {
    view_angle_ = std::clamp(degrees, 5.0, 120.0);
}

void CameraRig::orbit(double to_right, double up) {
    const Vec3 pivot = eye_ + forward() * distance_;
    turn(to_right, up);
    eye_ = pivot - forward() * distance_;
}

void CameraRig::turn(double to_right, double up) {
    yaw_ -= to_right;
    pitch_ += up;
    limit();
}

void CameraRig::pan(double to_right, double down) {
    const double height = 2.0 * distance_ * std::tan(radians(view_angle_) / 2.0);
    const Vec3 up = cross(right(), forward());
    eye_ = eye_ - right() * (to_right * height) + up * (down * height);
}

void CameraRig::approach(double factor) {
    const Vec3 pivot = eye_ + forward() * distance_;
    distance_ *= factor;
    limit();
    eye_ = pivot - forward() * distance_;
}

void CameraRig::fly(double to_right, double up, double ahead) {
    eye_ = eye_ + right() * to_right + Vec3{0, up, 0} + forward() * ahead;
}

View between(const View& a, const View& b, double share) {
    const auto mix = [share](Vec3 from, Vec3 to) { return from + (to - from) * share; };
    View view;
    view.eye = mix(a.eye, b.eye);
    view.forward = mix(normalised(a.forward), normalised(b.forward));
    view.up = mix(a.up, b.up);
    view.view_angle = std::clamp(a.view_angle + (b.view_angle - a.view_angle) * share, 1.0, 170.0);
    // Opposite directions have nothing between them.
    if (dot(view.forward, view.forward) < 1e-6)
        view.forward = b.forward;
    return view;
}

CameraPath moving_camera(const View& previous, const View& current, int frame) {
    return [=](double time) {
        // The very views where they are asked for: a camera that stands still must not move by rounding.
        if (time == frame || same_view(previous, current))
            return current;
        return time == frame - 1 ? previous : between(previous, current, time - (frame - 1));
    };
}

bool same_view(const View& a, const View& b) {
    const auto same = [](Vec3 u, Vec3 v) { return u.x == v.x && u.y == v.y && u.z == v.z; };
    return same(a.eye, b.eye) && same(a.forward, b.forward) && same(a.up, b.up) && a.view_angle == b.view_angle;
}

} // namespace sfumato::viewer
