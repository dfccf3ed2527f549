// The camera that mouse and keys move: it circles a pivot, or flies. Up stays y.
#pragma once

#include "scene/scene_source.h"

namespace sfumato::viewer {

class CameraRig {
  public:
    CameraRig() = default;

    // Begins where `view` stands; the pivot is the point on its axis nearest to the middle of `bounds`.
    CameraRig(const scene::View& view, const scene::Bounds& bounds);

    scene::View view() const;
    double view_angle() const { return view_angle_; }
    void set_view_angle(double degrees); // 5…120

    // Degrees about the vertical through the pivot and up over it: what is seen turns with the mouse.
    void orbit(double right, double up);
    // Degrees of the look about the eye.
    void turn(double right, double up);
    // Shares of the image height: what is seen at the pivot's distance follows the mouse.
    void pan(double right, double down);
    // Factor on the distance to the pivot.
    void approach(double factor);
    // Scene units along the camera's own axes; the pivot comes along.
    void fly(double right, double up, double forward);

    double distance() const { return distance_; }

  private:
    scene::Vec3 forward() const;
    scene::Vec3 right() const;
    void limit();

    scene::Vec3 eye_ = {0, 0, 5};
    double yaw_ = 0.0;   // degrees; 0 looks along -z, positive to the left
    double pitch_ = 0.0; // degrees, positive up
    double distance_ = 5.0;
    double least_distance_ = 0.01;
    double view_angle_ = 40.0;
};

// Between two views, for moments of time between two frames, and beyond them.
scene::View between(const scene::View& a, const scene::View& b, double share);

// A camera that was at `previous` a frame before `frame`, is at `current` at `frame` and goes on as it does.
scene::CameraPath moving_camera(const scene::View& previous, const scene::View& current, int frame);

bool same_view(const scene::View& a, const scene::View& b);

} // namespace sfumato::viewer
