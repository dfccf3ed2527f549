// passes: depth composite report
// Around the tiles: the depths that they are drawn against, and the host's picture with the particles and their shadow.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#include "particles_draw_shared.h"
#include "numbers.glsl"
#include "camera.glsl"
#include "particles_draw_common.glsl"

#ifdef PASS_depth
#include "particles_composite_depth.glsl"
#endif
#ifdef PASS_composite
#include "particles_composite_picture.glsl"
#endif
#ifdef PASS_report
#include "particles_composite_report.glsl"
#endif
