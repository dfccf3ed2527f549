// What every kind of scene can do, so that programs need not know which they have: frames with all their passes and
// ground truth at any moment, seen by the scene's own camera or by one that the caller moves.
#pragma once

#include "scene/scene.h"

#include <memory>
#include <vector>

namespace sfumato::scene {

// A sphere about what is worth looking at, in scene units.
struct Bounds {
    Vec3 centre = {};
    double radius = 1.0;
};

// Externally synchronised, for one queue. The context must outlive it.
class SceneSource {
  public:
    virtual ~SceneSource() = default;

    virtual const SceneInfo& info() const = 0;
    virtual Bounds bounds() const = 0;
    virtual const Lens& lens() const = 0;
    virtual Vec3 to_sun() const = 0;               // towards the light that casts shadows; unit
    virtual Vec3 sun() const { return {1, 1, 1}; } // irradiance of what faces it
    // Solids that particles bounce off, at most most_colliders; in scene units and seconds.
    virtual std::vector<Collider> colliders(double) const { return {}; }

    // By the camera in use. Times are in frames.
    virtual View view(double frame) const = 0;
    // An empty path brings the scene's own camera back.
    virtual void set_camera(CameraPath path) = 0;

    // Records the images that are present. `index` counts the recorded frames, see Executor::execute. Errors:
    // options out of range, images that differ in extent, what the scene cannot make (named).
    virtual Result<void> record(VkCommandBuffer commands, double frame, const RenderOptions& options,
                                const SceneImages& images, uint64_t index) = 0;
    virtual std::vector<PassTime> times() = 0;

    // Depth 0…1 of the scene seen from the sun, in a square map: what frame_facts().lights[0].world_to_shadow leads to.
    // Counts as a plan of the frame `index`. Errors: unsupported, where has_sun_map() is false.
    virtual bool has_sun_map() const { return false; }
    virtual Result<void> record_sun_map(VkCommandBuffer commands, double frame, const Image& map, uint64_t index);

    Camera camera(double frame, Extent extent) const { return camera_of(view(frame), lens(), extent); }
    // Kind of depth, previous, current and next camera; the sun as light 0, and the colliders. Lights and colliders
    // stand until the next call.
    Frame frame_facts(double frame, Extent extent) const;

  private:
    mutable std::array<sfumato::Light, 1> lights_;
    mutable std::vector<Collider> colliders_;
};

// An analytic scene; a copy is kept.
Result<std::unique_ptr<SceneSource>> make_source(Context& context, const Scene& scene);

// Circles the middle of `bounds` once in `frames` frames, from `elevation` degrees above the horizon, so far away that
// the bounds fill the image's height.
CameraPath turntable(const Bounds& bounds, double view_angle, double frames, double elevation = 10.0);

} // namespace sfumato::scene
