// Constants of all motion blur passes, shared by motion_blur.cpp and motion_blur.comp.
#ifndef SFUMATO_MOTION_BLUR_SHARED_H
#define SFUMATO_MOTION_BLUR_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
#endif

struct MotionBlurConstants {
    mat4 clip_from_view;          // this frame's projection
    mat4 previous_clip_from_view; // this frame's view space to the previous frame's clip space
    mat4 next_clip_from_view;
    vec2 size;           // of the colour image, pixels
    vec2 velocity_ratio; // size of an input to the colour's
    vec2 next_velocity_ratio;
    vec2 depth_ratio;
    vec2 layer_1_mask_ratio;
    vec2 layer_2_mask_ratio;
    vec2 exclusion_ratio;
    vec4 layer_1_scale; // ratio (xy), the layer's strength over the ratio (zw)
    vec4 layer_2_scale;
    float shutter;           // open fraction of the frame interval
    float centre;            // of the shutter: 0 centred, 1 opens at the frame's time, -1 closes then
    float radius;            // longest half displacement, pixels
    float uniform_tolerance; // of the longest vector
    float uniform_pixels;
    float soft_extent;
    float weight_background;
    float weight_foreground;
    float weight_mutual;
    float weight_centre;
    float taps_per_pixel;
    float noise_shift;   // moves the noise from iteration to iteration, pixels
    float ordered_shift; // the same for the patterns of few values
    float iteration;     // number of the iteration, from 0
    float parity;        // of the frame's noise index, for the checkerboard
    float jitter_amount; // of the spacing of taps
    float debug_scale;
    float padding_0;
    vec2 inverse_size; // one over `size`
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
