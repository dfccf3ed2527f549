// Motion blur: what moves smears along its path while the shutter is open.
//
// Source: Bukowski, Hennessy, McGuire, Osman, Scalable High Quality Motion Blur and Ambient Occlusion, SIGGRAPH 2012
// course; McGuire, Hennessy, Bukowski, Osman, A Reconstruction Filter for Plausible Motion Blur, I3D 2012.
// docs/effects/motion-blur.md has the stages, the weightings, the presets and their error against ground truth.
#pragma once

#include "sfumato/effect.h"

namespace sfumato {

enum class ShutterPosition { start, centre, end };
enum class ShutterCurve { box, triangle, smooth };
enum class FrameRateMode { native, reference, fixed };
enum class VelocityStorage { half, packed };
enum class Dilation { box, selective, line };
enum class BlurWeighting { talk, guertin, jimenez, coverage };
enum class TapJitter { none, checkerboard, ordered, gradient_noise };
enum class DepthComparison { relative, absolute };
enum class LayerBlend { add, replace, larger };
enum class MotionBlurView {
    none,
    velocity,
    depth,
    tile_maximum,
    neighbour_maximum,
    tile_class,
    taps,
    share,
};

struct MotionBlurParameters {
    float shutter = 0.5f;
    ShutterPosition shutter_position = ShutterPosition::centre;
    ShutterCurve shutter_curve = ShutterCurve::box;
    FrameRateMode frame_rate_mode = FrameRateMode::native;
    float reference_frame_rate = 30.0f;
    int generated_frames = 1;

    float radius = 0.06f;
    int taps = 10;
    float taps_per_pixel = 1.0f;
    int least_taps = 6;
    int search_taps = 8;
    bool second_direction = true;
    bool filter_taps = true;
    BlurWeighting weighting = BlurWeighting::coverage;
    bool alternate = false;
    TapJitter jitter = TapJitter::gradient_noise;
    float jitter_amount = 0.5f;
    bool animate_jitter = false;
    bool tile_jitter = false;
    int iterations = 1;
    bool hdr_weighting = false;

    DepthComparison depth_comparison = DepthComparison::relative;
    float soft_extent = 0.02f;
    float weight_background = 1.0f;
    float weight_foreground = 0.25f;
    float weight_mutual = 1.0f;
    float weight_centre = 0.5f;

    VelocityStorage storage = VelocityStorage::half;
    bool repair_edges = false;
    LayerBlend layer_1_blend = LayerBlend::add;
    float layer_1_strength = 1.0f;
    LayerBlend layer_2_blend = LayerBlend::add;
    float layer_2_strength = 1.0f;

    int tile = 32;
    Dilation dilation = Dilation::line;
    bool test_edge_neighbours = true;
    bool tile_classes = true;
    float uniform_tolerance = 0.05f;
    float uniform_pixels = 1.0f;

    MotionBlurView debug_view = MotionBlurView::none;

    static const ParameterTable& table();
};

// Colour in, colour out; the rest is optional: without velocity the camera's motion is taken from depth and matrices,
// without depth everything is one layer. Velocity is in pixels of its own image a frame, current minus previous, +x
// right, +y down. Inputs may differ from the colour in size.
struct MotionBlurImages {
    Image colour;
    Image depth;
    Image velocity;
    Image next_velocity;
    Image layer_1;
    Image layer_1_mask;
    Image layer_2;
    Image layer_2_mask;
    Image exclusion_mask;
    Image output;

    static const EffectInfo& effect();
};

using MotionBlur = Effect<MotionBlurParameters, MotionBlurImages>;

} // namespace sfumato
