// Constants of all ambient occlusion passes, shared by ambient_occlusion.cpp and ambient_occlusion.comp.
#ifndef SFUMATO_AMBIENT_OCCLUSION_SHARED_H
#define SFUMATO_AMBIENT_OCCLUSION_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
#endif

struct AmbientOcclusionConstants {
    mat4 projection;              // this frame's
    mat4 previous_view_from_view; // this frame's view space to the previous frame's
    mat4 previous_projection;
    mat4 view_from_world; // for normals in world space
    vec4 pixel_to_view;   // view xy = (pixel * xy + zw) times depth where the camera is perspective
    vec4 previous_pixel_to_view;
    vec4 bells_near;   // of the filter, at its first to fourth tap from the middle
    vec4 bells_far;    // fifth to eighth
    vec2 size;         // full resolution, pixels
    vec2 working_size; // of the estimate
    vec2 normal_ratio; // size of an input to the depth's
    vec2 velocity_ratio;
    vec2 shadow_ratio;
    vec2 colour_ratio;
    vec2 ambient_ratio;
    float radius;       // scene units
    float radius_limit; // pixels
    float pixels;       // that one scene unit takes at depth 1 (perspective) or anywhere (orthographic), vertically
    float thickness;    // scene units
    float bias;
    float depth_bias;
    float strength; // factor on the mean over taps
    float power;
    float step_power;
    float mip_scale;   // 2^-rate: taps this many times farther use the next level
    float first_angle; // of the pattern
    float first_tap;   // shares of the radius
    float tap_spacing;
    vec2 turn; // cosine and sine of the angle from tap to tap
    float guard_band;
    float noise_shift;     // moves the noise from frame to frame, pixels
    float block_shift;     // the same for the pattern of 4×4 pixels
    float code_scale;      // of depth in packed signals
    float filter_scale;    // 1 / the tolerated difference of depth
    float filter_gaussian; // 1 / (2 sigma²) in powers of two
    float filter_normal;
    float history_position; // per scene unit
    float history_visibility;
    float history_least;
    float history_length;
    float upsample_scale; // 1 / the tolerated difference of depth
    float padding_1;
    float padding_0;
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
