// Ambient occlusion: how much of the sky each visible point sees, from the depth buffer.
//
// Sources: Bukowski, Hennessy, McGuire, Osman, Scalable High Quality Motion Blur and Ambient Occlusion, SIGGRAPH 2012
// course; Frictional Games, SSAO and Temporal Blur, 2014; Bavoil, Sainz, Dimitrov, Image-Space Horizon-Based Ambient
// Occlusion, SIGGRAPH 2008. docs/effects/ambient-occlusion.md has the stages, the estimators, the presets and their
// error against ray tracing.
#pragma once

#include "sfumato/effect.h"

namespace sfumato {

enum class OcclusionEstimator { obscurance, horizon };
enum class HorizonMeasure { hbao, cosine, bitmask };
enum class OcclusionFalloff { hard, linear, quadratic, sao, contact, wide };
enum class TapPattern { mirrored_spiral, spiral, growing_circle };
enum class OcclusionNormalisation { calibrated, vicarious_visions, plain };
enum class OcclusionNoise { none, gradient_noise, hash, blocks };
enum class OcclusionResolution { full, half };
enum class HalfDepthChoice { checkerboard, nearest, farthest };
enum class DepthMips { none, rotated, farthest, centre };
enum class DepthStorage { full, half };
enum class NormalSource { given, derived };
enum class NormalSpace { view, world };
enum class DepthWeight { gaussian, limit, tent };
enum class DepthDifference { relative, radius };
enum class OcclusionUpsample { nearest, bilinear, soma, relative };
enum class OcclusionApplication { none, ambient, everything };
enum class OcclusionView { none, depth, normal, mip, radius, estimate, filtered, history_weight };

struct AmbientOcclusionParameters {
    float radius = 1.5f;
    float intensity = 1.0f;
    float power = 1.0f;
    OcclusionFalloff falloff = OcclusionFalloff::hard;

    OcclusionEstimator estimator = OcclusionEstimator::horizon;
    HorizonMeasure measure = HorizonMeasure::bitmask;
    int slices = 2;
    int steps = 8;
    float step_power = 1.0f;
    float thickness = 0.5f;
    TapPattern pattern = TapPattern::spiral;
    int taps = 9;
    float bias = 0.02f;
    float depth_bias = 0.00005f;
    OcclusionNormalisation normalisation = OcclusionNormalisation::calibrated;
    float radius_limit = 2.0f;
    OcclusionNoise noise = OcclusionNoise::blocks;
    bool animate_noise = false;
    int iterations = 1;

    OcclusionResolution resolution = OcclusionResolution::full;
    HalfDepthChoice half_depth = HalfDepthChoice::nearest;
    DepthMips depth_mips = DepthMips::centre;
    float mip_rate = 3.0f;
    DepthStorage depth_storage = DepthStorage::full;
    NormalSource normals = NormalSource::given;
    NormalSpace normal_space = NormalSpace::view;
    int guard_band = 0;

    int filter_radius = 4;
    int filter_step = 1;
    float filter_sigma = 2.5f;
    DepthWeight filter_weight = DepthWeight::tent;
    DepthDifference filter_comparison = DepthDifference::relative;
    float filter_depth = 0.03f;
    bool filter_slope = true;
    float filter_normal = 0.0f;
    bool full_resolution_filter = false;

    bool temporal = false;
    bool second_filter = true;
    float history_position = 9.0f;
    float history_visibility = 5.0f;
    float history_time = 1.0f;
    int history_length = 0;
    bool history_occluders = false;

    OcclusionUpsample upsample = OcclusionUpsample::relative;
    float upsample_depth = 0.02f;

    OcclusionApplication application = OcclusionApplication::everything;
    OcclusionView debug_view = OcclusionView::none;

    static const ParameterTable& table();
};

// Depth in, visibility out (1 open, 0 blocked); the frame's camera is needed. Without normals they are derived from
// depth. The temporal filter takes the previous camera, and velocity where things move: pixels per frame, current minus
// previous, +x right, +y down. Inputs may differ from the depth in size; all outputs have the depth's size.
struct AmbientOcclusionImages {
    Image depth;
    Image normal;
    Image velocity;
    Image shadow;
    Image colour;
    Image ambient;
    Image visibility;
    Image soft_shadow;
    Image bent_normal;
    Image output;

    static const EffectInfo& effect();
};

using AmbientOcclusion = Effect<AmbientOcclusionParameters, AmbientOcclusionImages>;

} // namespace sfumato
