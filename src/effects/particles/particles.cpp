// Which passes the particle effect has, in which order: simulation, then drawing (particles_draw.cpp).
#include "shaders/particles.h"
#include "effects/particles/particles_plan.h"
#include "effects/particles/particles_shared.h"
#include "effects/plan_parts.h"

namespace sfumato {

namespace {

namespace shader = shaders::particles;
static_assert(sizeof(gpu::ParticleSprite) == sizeof(ParticleSprite));
static_assert(sizeof(gpu::ParticleStatistics) == sizeof(ParticleStatistics));

ResourceId plan_simulation(Planner& planner, const ParticleVolumeParameters& p) {
    const auto count = static_cast<uint32_t>(p.count);
    const ResourceId sprites = planner.buffer("sprites", uint64_t{count} * sizeof(ParticleSprite), count);
    Pass& pass = planner.pass("simulate", shader::simulate);
    pass.accesses = {{sprites, AccessKind::buffer_write}};
    pass.dispatch = {DispatchKind::texels, sprites};
    return sprites;
}

} // namespace

Plan plan_particles(const Frame& frame, const ParticleVolumeParameters& parameters,
                    const ParticleVolumeImages& images) {
    Planner planner("particles");
    ParticleDrawInputs inputs{frame, parameters, images};
    const auto host = [&](const char* name, ParticleImage index, const Image& image) {
        return planner.host(name, static_cast<uint32_t>(index), image);
    };
    inputs.colour = host("colour", ParticleImage::colour, images.colour);
    inputs.depth = host("depth", ParticleImage::depth, images.depth);
    inputs.shadow_map = host("shadow map", ParticleImage::shadow_map, images.shadow_map);
    inputs.direct = host("direct", ParticleImage::direct, images.direct);
    inputs.velocity = host("velocity", ParticleImage::velocity, images.velocity);
    inputs.output = host("output", ParticleImage::output, images.output);
    inputs.velocity_output = host("velocity output", ParticleImage::velocity_output, images.velocity_output);
    inputs.transmittance = host("transmittance", ParticleImage::transmittance, images.transmittance);
    inputs.statistics =
        planner.host_buffer("statistics", static_cast<uint32_t>(ParticleBuffer::statistics), images.statistics, 1);
    inputs.extent = images.colour.extent;
    if (images.sprites) {
        inputs.capacity = static_cast<uint32_t>(images.sprites.bytes / sizeof(ParticleSprite));
        inputs.sprites = planner.host_buffer("sprites", static_cast<uint32_t>(ParticleBuffer::sprites), images.sprites,
                                             inputs.capacity);
    } else {
        inputs.capacity = static_cast<uint32_t>(parameters.count);
        inputs.sprites = plan_simulation(planner, parameters);
    }
    plan_particle_draw(planner, inputs);
    return std::move(planner).finish();
}

} // namespace sfumato
