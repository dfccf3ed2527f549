// passes: simulate advance
// The simulation of particles: one invocation a particle. tests/reference/particles_reference.cpp says the same slowly.
#version 450
#extension GL_GOOGLE_include_directive : require

#include "particles_shared.h"
#include "numbers.glsl"
#include "hash.glsl"
#include "camera.glsl"

layout(set = 1, binding = 0) uniform Constants { ParticleSimulateConstants constants; };

#include "particles_simulate_clock.glsl"
#ifdef PASS_simulate
#include "particles_simulate_air.glsl"
#include "particles_simulate_collide.glsl"
#include "particles_simulate.glsl"
#endif
