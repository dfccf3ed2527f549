// passes: splat sum scatter
// The shadow buffer of each light, in layers: every particle adds its optical depth to the texels that it covers in its
// layer, then the layers are summed from the light on. All layers at once: the picture never feeds the shadow buffer,
// so the alternation of slices in Green, DirectX 10/11 Visual Effects, gives the same numbers.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#include "particles_draw_shared.h"
#include "numbers.glsl"
#include "particles_draw_common.glsl"

#ifdef PASS_splat
#include "particles_light_splat.glsl"
#endif
#ifdef PASS_sum
#include "particles_light_sum.glsl"
#endif
#ifdef PASS_scatter
#include "particles_light_scatter.glsl"
#endif
