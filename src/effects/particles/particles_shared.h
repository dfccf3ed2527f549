// What simulation and drawing of particles share, in C++ and GLSL alike.
#ifndef SFUMATO_PARTICLES_SHARED_H
#define SFUMATO_PARTICLES_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
using uint = uint32_t;
#endif

// See sfumato::ParticleSprite: 48 bytes. Dead where the radius is not above 0 or any number is not finite.
struct ParticleSprite {
    float position_x, position_y, position_z; // world space, scene units
    float radius;
    float velocity_x, velocity_y, velocity_z; // scene units a second
    float extinction;                         // 1 / scene unit
    float albedo_r, albedo_g, albedo_b;
    float emission;
};

// See sfumato::ParticleStatistics.
struct ParticleStatistics {
    uint alive;
    uint drawn;
    uint pairs;
    uint pairs_wanted;
    uint overflow;
    uint reserved_0;
    uint reserved_1;
    uint reserved_2;
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
