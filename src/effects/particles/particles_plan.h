// What the parts of the particle effect know of each other: simulation (particles.cpp) and drawing
// (particles_draw.cpp).
#pragma once

#include "sfumato/effects/particles.h"
#include "sfumato/plan.h"

namespace sfumato {

// Numbers of the host's images and buffers in the plan.
enum class ParticleImage : uint32_t {
    colour,
    depth,
    shadow_map,
    direct,
    velocity,
    profile,
    output,
    velocity_output,
    transmittance,
};
enum class ParticleBuffer : uint32_t { sprites, statistics };

// Everything that drawing takes. Absent images and buffers are no_resource. Drawing writes `output`, and, where they
// are present, `velocity_output`, `transmittance` and the whole of `statistics`.
struct ParticleDrawInputs {
    const Frame& frame;
    const ParticleVolumeParameters& parameters;
    const ParticleVolumeImages& images;
    ResourceId colour = no_resource;
    ResourceId depth = no_resource;
    ResourceId shadow_map = no_resource;
    ResourceId direct = no_resource;
    ResourceId velocity = no_resource;
    ResourceId profile = no_resource;
    ResourceId output = no_resource;
    ResourceId velocity_output = no_resource;
    ResourceId transmittance = no_resource;
    ResourceId statistics = no_resource;
    ResourceId sprites = no_resource; // `capacity` ParticleSprites, dead ones among them; elements = capacity
    uint32_t capacity = 0;            // at least 1
    Extent extent;                    // of the colour
};

// Room for pairs of particle and tile: as many as one row of workgroups takes, a thousand each.
inline constexpr uint64_t most_pairs = uint64_t{65535} * 1024;

// What a frame of simulated particles lacks.
std::vector<Shortfall> particle_shortfalls(const ParticleStatistics& statistics,
                                           const ParticleVolumeParameters& parameters);

// The first thing that is missing, or "".
std::string check_particles(const ParticleVolumeParameters& parameters, const ParticleVolumeImages& images);

void plan_particle_draw(Planner& planner, const ParticleDrawInputs& inputs);

Plan plan_particles(const Frame& frame, const ParticleVolumeParameters& parameters, const ParticleVolumeImages& images);

} // namespace sfumato
