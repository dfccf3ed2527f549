// passes: simulate
// The simulation of particles: one invocation a particle.
#version 450
#extension GL_GOOGLE_include_directive : require

#include "particles_shared.h"

layout(local_size_x = 256) in;
layout(std430, set = 0, binding = 0) buffer Sprites { ParticleSprite sprites[]; };

void main() {
    const uint index = gl_GlobalInvocationID.x;
    if (index >= uint(sprites.length()))
        return;
    sprites[index] = ParticleSprite(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
}
