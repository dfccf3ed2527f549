// passes: table weigh
// The table that particles' profiles are read from, of noise or of the host's texture, its halvings, and what its parts
// hold. See particles_profile.glsl.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#include "particles_draw_shared.h"
#include "numbers.glsl"
#include "particles_draw_common.glsl"
#include "particles_profile.glsl"

#ifdef PASS_table
#include "particles_profile_table.glsl"
#endif
#ifdef PASS_weigh
#include "particles_profile_weigh.glsl"
#endif
