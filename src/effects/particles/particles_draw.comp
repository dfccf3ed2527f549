// passes: begin clear measure settle key record
// What precedes the drawing of particles: which are alive and in view, how far they extend, their keys for sorting, and
// after it the lit records that tiles are drawn from. Follows Green, DirectX 10/11 Visual Effects (volumetric particle
// shadowing). scene/particle_truth.cpp says the same slowly.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#include "particles_draw_shared.h"
#include "numbers.glsl"
#include "particles_draw_common.glsl"

#ifdef PASS_begin
#include "particles_draw_begin.glsl"
#endif
#ifdef PASS_clear
#include "particles_draw_clear.glsl"
#endif
#if defined(PASS_measure) || defined(PASS_key) || defined(PASS_record)
#include "particles_draw_project.glsl"
#endif
#ifdef PASS_measure
#include "particles_draw_measure.glsl"
#endif
#ifdef PASS_settle
#include "particles_draw_settle.glsl"
#endif
#ifdef PASS_key
#include "particles_draw_key.glsl"
#endif
#ifdef PASS_record
#include "camera.glsl"
#include "particles_draw_record.glsl"
#endif
