// passes: velocity velocity_subgroups neighbours neighbours_subgroups gather debug
// Motion blur on tiles. Follows Bukowski, Hennessy, McGuire, Osman, Scalable High Quality Motion Blur and Ambient
// Occlusion (SIGGRAPH 2012 course), and McGuire et al., A Reconstruction Filter for Plausible Motion Blur (I3D 2012);
// the weightings `guertin` (HPG 2014) and `jimenez` (SIGGRAPH 2014 course) are those of their authors, `coverage` is our
// own. tests/reference/motion_blur_reference.cpp says the same slowly.
//
// A half displacement v is what the content moves in half the shutter: while the shutter is open, what is seen at Y
// passes through Y + s v, s from c - 1 to c + 1. So a tap with parameter s lies at X - s v.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#ifdef PASS_velocity_subgroups
#define PASS_velocity
#define SUBGROUPS
#endif
#ifdef PASS_neighbours_subgroups
#define PASS_neighbours
#define SUBGROUPS
#endif
#ifdef SUBGROUPS
#extension GL_KHR_shader_subgroup_arithmetic : require
#endif

#include "motion_blur_shared.h"
#include "numbers.glsl"
#include "camera.glsl"
#include "motion_blur_surface.glsl"

layout(set = 1, binding = 0) uniform Constants { MotionBlurConstants constants; };

#ifdef PASS_velocity
#include "motion_blur_velocity.glsl"
#endif
#ifdef PASS_neighbours
#include "motion_blur_neighbours.glsl"
#endif
#ifdef PASS_gather
#include "motion_blur_gather.glsl"
#endif
#ifdef PASS_debug
#include "motion_blur_debug.glsl"
#endif
