// Inputs for ambient occlusion and the device's answers to them.
#pragma once

#include "scene/scene.h"
#include "tests/gpu/gpu_test.h"
#include "tests/reference/ambient_occlusion_reference.h"

namespace sfumato::test {

struct OcclusionInput {
    Frame frame;
    FloatImage depth, normal, velocity, shadow, colour, ambient;
    FloatImage truth, true_bent_normal; // where rays were asked for
    Extent extent() const { return depth.extent; }
};

// One frame of a scene; with `rays` also the true occlusion.
OcclusionInput render_input(const scene::Scene& scene, int frame, Extent extent, int rays = 0,
                            scene::Falloff falloff = scene::Falloff::hard, double radius = 1.5);

// One image of known geometry: a plane n·p = -distance in view space, seen by `frame`'s camera. Where the plane is not,
// there is sky. In the frame's own kind of depth.
OcclusionInput plane_input(const Frame& frame, Extent extent, std::array<double, 3> normal, double distance);

// Cameras: focal length in image heights (perspective), or the height of the view (orthographic). `shift` moves the
// axis off the middle, in shares of the image.
enum class DepthCode { linear, reversed_infinite, reversed, standard };
Frame perspective_frame(Extent extent, double focal, double shift = 0.0, DepthCode code = DepthCode::linear);
Frame orthographic_frame(Extent extent, double view_height, double shift = 0.0, DepthCode code = DepthCode::linear);

// What a projection writes for a view depth.
double device_depth(const Frame& frame, double view_depth);

struct OcclusionOutput {
    FloatImage visibility, soft_shadow, bent_normal, output; // four channels each; only the first without `optional`
    double at(uint32_t x, uint32_t y) const { return double{visibility.at(x, y)[0]}; }
};

// One instance on one stream of frames.
class OcclusionStream {
  public:
    OcclusionStream();
    // `optional`: with shadow, colour, ambient and all outputs. Normals and velocity are given where the input has
    // them.
    OcclusionOutput run(const OcclusionInput& input, const AmbientOcclusionParameters& parameters,
                        bool optional = false);

  private:
    EffectRig rig_;
};

// The first frame of a stream of its own.
OcclusionOutput occlude(const OcclusionInput& input, const AmbientOcclusionParameters& parameters,
                        bool optional = false);

// Parameters for tests, all that presets may change stated: hard falloff, bitmask, 4 slices of 8 steps, no filter,
// full resolution, noise in blocks.
AmbientOcclusionParameters plain_parameters();

struct Deviation {
    double share_beyond = 0.0; // of pixels that differ by more than the tolerance
    double largest = 0.0;
    double mean = 0.0; // of absolute differences
};
template <class A, class B>
Deviation deviation(uint32_t width, uint32_t height, double tolerance, A a, B b) {
    Deviation result;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const double difference = std::abs(a(x, y) - b(x, y));
            // NaN must not pass for equal.
            result.share_beyond += difference <= tolerance ? 0.0 : 1.0;
            result.largest = difference <= result.largest ? result.largest : difference;
            result.mean += difference;
        }
    const double count = static_cast<double>(width) * static_cast<double>(height);
    result.share_beyond /= count;
    result.mean /= count;
    return result;
}
Deviation deviation(const OcclusionOutput& a, const OcclusionOutput& b, double tolerance);
Deviation error_of(const OcclusionOutput& a, const OcclusionInput& truth);

reference::Grid<1> depth_grid(const OcclusionInput& input);
reference::Grid<3> normal_grid(const OcclusionInput& input);
reference::AmbientOcclusionReference reference_of(const OcclusionInput& input,
                                                  const AmbientOcclusionParameters& parameters);

} // namespace sfumato::test
