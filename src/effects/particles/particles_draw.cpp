// Drawing of particles. Nothing is drawn yet: the colour is handed through.
#include "shaders/particles_draw.h"
#include "effects/particles/particles_plan.h"
#include "effects/plan_parts.h"

namespace sfumato {

namespace {
namespace shader = shaders::particles_draw;

Access write(ResourceId resource) {
    return {resource, AccessKind::write, 0, false};
}
} // namespace

void plan_particle_draw(Planner& planner, const ParticleDrawInputs& inputs) {
    Pass& copy = planner.pass("copy", shader::copy);
    copy.accesses = {read(inputs.colour), read(inputs.depth),   read(inputs.shadow_map),
                     read(inputs.direct), write(inputs.output), {inputs.sprites, AccessKind::buffer_read}};
    copy.dispatch = {DispatchKind::texels, inputs.output};
    if (inputs.velocity_output != no_resource) {
        Pass& velocity = planner.pass("copy velocity", shader::copy_velocity);
        velocity.accesses = {read(inputs.velocity), write(inputs.velocity_output)};
        velocity.dispatch = {DispatchKind::texels, inputs.velocity_output};
    }
    if (inputs.transmittance != no_resource) {
        Pass& transmittance = planner.pass("transmittance", shader::transmittance);
        transmittance.accesses = {write(inputs.transmittance)};
        transmittance.dispatch = {DispatchKind::texels, inputs.transmittance};
    }
    if (inputs.statistics != no_resource) {
        Pass& statistics = planner.pass("statistics", shader::statistics);
        statistics.accesses = {{inputs.statistics, AccessKind::buffer_write}};
        statistics.dispatch = {DispatchKind::texels, inputs.statistics};
    }
}

} // namespace sfumato
