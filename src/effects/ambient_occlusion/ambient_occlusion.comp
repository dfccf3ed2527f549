// passes: prepare estimate filter upsample bend
// Ambient occlusion from depth. Follows Bukowski et al. (SIGGRAPH 2012 course), Frictional Games, SSAO and Temporal Blur
// (2014), and Bavoil et al., HBAO (SIGGRAPH 2008). tests/reference/ambient_occlusion_reference.cpp says the same slowly.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#include "ambient_occlusion_shared.h"
#include "numbers.glsl"
#include "camera.glsl"
#include "depth_pyramid.glsl"

layout(set = 1, binding = 0) uniform Constants { AmbientOcclusionConstants constants; };

#include "ambient_occlusion_common.glsl"

#ifdef PASS_prepare
#include "ambient_occlusion_prepare.glsl"
#endif
#ifdef PASS_estimate
#include "ambient_occlusion_estimate.glsl"
#endif
#ifdef PASS_filter
#include "bilateral.glsl"
#include "temporal.glsl"
#include "ambient_occlusion_finish.glsl"
#include "ambient_occlusion_filter.glsl"
#endif
#ifdef PASS_upsample
#include "upsample.glsl"
#include "ambient_occlusion_finish.glsl"
#include "ambient_occlusion_upsample.glsl"
#endif
#ifdef PASS_bend
#include "ambient_occlusion_bend.glsl"
#endif
