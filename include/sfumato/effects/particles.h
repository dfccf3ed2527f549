// Particles with volumetric shadows: smoke, steam, explosions of up to four million particles, simulated, lit and drawn
// on the device.
//
// Source: Simon Green, Volumetric Particle Shadowing (DirectX 10/11 Visual Effects; half-angle slices after Kniss et
// al., Interactive Translucent Volume Rendering and Procedural Modeling, IEEE Visualization 2002), and what goes beyond
// it: layers of optical depth along the light. docs/effects/particles.md has the simulation, the modes and their error.
#pragma once

#include "sfumato/effect.h"

namespace sfumato {

enum class ParticleEmitter { point, sphere, box, disc };
enum class ParticleCollision { none, depth, analytic, both };
enum class ParticleMode { light_volume, half_angle };
enum class ParticleResolution { full, half, quarter };
enum class ParticleProfile { sphere, noise, texture };
enum class ParticleSortBits { bits_16, bits_24, bits_32 };
enum class ParticleView { none, order, slices, shadow, layers, tiles, overflow };

inline constexpr uint32_t most_particles = 4194304;

// One particle as it is drawn: what the simulation makes, and what a host puts into the buffer `sprites`. A particle
// whose radius is not above 0, or of which any number is not finite, is dead: it is neither drawn nor casts a shadow.
// It should keep its place in the buffer from frame to frame: its pattern follows from it (`profile`), and whether
// others stand for it (`simplification`).
struct ParticleSprite {
    std::array<float, 3> position; // world space, scene units
    float radius;                  // of the sphere, scene units
    std::array<float, 3> velocity; // world space, scene units a second; for the velocity layer
    float extinction;              // inside the sphere, 1 / scene unit
    std::array<float, 3> albedo;   // share of the extinction that is scattered, 0…1
    float emission;                // radiance of its glow where it is opaque; the colour follows from the strength
};
static_assert(sizeof(ParticleSprite) == 48);

// What the effect reports of a frame in the buffer `statistics`.
struct ParticleStatistics {
    uint32_t alive;        // particles that are not dead
    uint32_t drawn;        // of these, those that lie in the image
    uint32_t pairs;        // of particle and tile that were drawn
    uint32_t pairs_wanted; // more than `pairs` where the room was too small
    uint32_t overflow;     // bit 0: pairs were left out; bit 1: optical depth was clamped
    uint32_t reserved_0, reserved_1, reserved_2;
};
static_assert(sizeof(ParticleStatistics) == 32);

struct ParticleVolumeParameters {
    int count = 65536;
    int seed = 0;
    ParticleEmitter emitter = ParticleEmitter::disc;
    float position_x = 0.0f;
    float position_y = 0.0f;
    float position_z = 0.0f;
    float emitter_size = 0.3f;
    float direction_azimuth = 0.0f;
    float direction_elevation = 90.0f;
    float spread = 15.0f;
    float speed = 1.5f;
    float rate = 10000.0f;
    int burst = 0;
    float lifetime = 5.0f;
    float lifetime_variation = 0.3f;
    float warm_up = 3.0f;
    float time_scale = 1.0f;

    float gravity = -0.4f;
    float drag = 1.0f;
    float wind_x = 0.0f;
    float wind_y = 0.0f;
    float wind_z = 0.0f;
    float curl_strength = 0.6f;
    float curl_scale = 0.8f;
    float curl_speed = 0.3f;
    int curl_octaves = 2;
    float attractor_x = 0.0f;
    float attractor_y = 0.0f;
    float attractor_z = 0.0f;
    float attractor_strength = 0.0f;
    ParticleCollision collision = ParticleCollision::both;
    float collision_thickness = 0.3f;
    float bounce = 0.2f;
    float friction = 0.1f;

    float radius_start = 0.04f;
    float radius_end = 0.25f;
    float extinction = 1.0f;
    float dilution = 1.0f;
    float fade_in = 0.05f;
    float fade_out = 0.4f;
    ParticleProfile profile = ParticleProfile::sphere;
    float profile_strength = 0.8f;
    float profile_scale = 1.75f;
    float albedo_r = 0.8f;
    float albedo_g = 0.8f;
    float albedo_b = 0.8f;
    float emission = 0.0f;
    float emission_time = 0.5f;

    float phase = 0.2f;
    float shadow_colour_r = 1.0f;
    float shadow_colour_g = 1.0f;
    float shadow_colour_b = 1.0f;
    float light_azimuth = 40.0f;
    float light_elevation = 50.0f;
    float light_strength = 3.0f;
    float ambient = 0.3f;

    ParticleMode mode = ParticleMode::light_volume;
    int slices = 64;
    int layers = 32;
    int shadow_resolution = 256;
    float scattering_blur = 0.0f;
    int scattering_octaves = 1;
    ParticleResolution resolution = ParticleResolution::full;
    float simplification = 0.5f;
    ParticleSortBits sort_bits = ParticleSortBits::bits_24;
    float soft_distance = 0.2f;
    float near_fade = 0.3f;
    float scene_shadow = 1.0f;
    int pairs_per_particle = 16;

    ParticleView debug_view = ParticleView::none;

    static const ParameterTable& table();
};

// Colour and depth in, colour with the particles out; the frame's camera is needed, its lights and colliders are used
// where there are any. Inputs may differ from the colour in size; all outputs have the colour's size.
struct ParticleVolumeImages {
    Image colour;
    Image depth;
    Image shadow_map;
    Image direct;
    Image velocity;
    Image profile;
    Image output;
    Image velocity_output;
    Image transmittance;
    Buffer sprites;
    Buffer statistics;

    static const EffectInfo& effect();
};

using ParticleVolume = Effect<ParticleVolumeParameters, ParticleVolumeImages>;

} // namespace sfumato
