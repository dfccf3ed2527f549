// passes: emit range draw
// Particles drawn by tiles of 16×16 pixels: pairs of tile and particle in the particles' order, sorted by tile alone
// with a stable sort, then one workgroup a tile that keeps colour and transmittance in registers.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#include "particles_draw_shared.h"
#include "numbers.glsl"
#include "particles_draw_common.glsl"
#include "particles_tiles_disc.glsl"

#ifdef PASS_emit
#include "particles_tiles_emit.glsl"
#endif
#ifdef PASS_range
#include "particles_tiles_range.glsl"
#endif
#ifdef PASS_draw
#include "particles_tiles_draw.glsl"
#endif
