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

// Of the simulation passes of one frame, which take `steps` equal steps in all.
struct ParticleSimulateConstants {
    mat4 world_to_view;
    mat4 view_to_world;
    mat4 projection;
    vec4 emitter;   // xyz: middle, w: size
    vec4 direction; // xyz: unit, w: cosine of the spread
    vec4 air;       // xyz: wind, w: drag
    vec4 attractor; // xyz: place, w: strength
    vec4 albedo;    // rgb, w: emission
    float speed;
    float gravity;
    float lifetime;
    float lifetime_variation;
    float curl_strength; // over the root of the sum of the octaves' squares
    float curl_frequency;
    float curl_speed;
    float thickness;
    float bounce;
    float friction;
    float radius_start;
    float radius_end;
    float extinction;
    float dilution; // exponent of the radii's ratio
    float fade_in;
    float fade_out;
    float emission_time;
    float time_step; // of one step
    uint births_low; // particles born in a step, as a fixed-point number of 32 + 32 bits
    uint births_high;
    uint time_low; // seconds of all steps together, likewise
    uint time_high;
    uint burst;
    uint seed;
    uint count;
    uint first_step; // of this pass
    uint step_count; // of this pass
    uint steps;
    uint collider_count;
    uint unused_0;
    uint unused_1;
    uint unused_2;
    // Five of a collider: centre and shape; size and bounding radius; the axes, with a component of the velocity behind
    // each.
    vec4 colliders[160];
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
