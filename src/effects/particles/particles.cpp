// Which passes the particle effect has, in which order: simulation, then drawing (particles_draw.cpp).
#include "shaders/particles.h"

#include "core/matrix.h"
#include "effects/particles/particles_draw_setup.h"
#include "effects/particles/particles_plan.h"
#include "effects/particles/particles_shared.h"
#include "effects/plan_parts.h"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato {

namespace {

namespace shader = shaders::particles;
static_assert(sizeof(gpu::ParticleSprite) == sizeof(ParticleSprite));
static_assert(sizeof(gpu::ParticleStatistics) == sizeof(ParticleStatistics));

// Long steps are stable, but particles in eddies and at surfaces want short ones.
constexpr double longest_step = 1.0 / 24.0;
constexpr uint32_t most_steps = 2048;    // of a frame; what lasts longer has longer steps
constexpr uint32_t steps_in_a_pass = 64; // devices stop passes that take seconds

double radians(double degrees) {
    return degrees * std::numbers::pi / 180.0;
}

// Fixed point, 32 + 32 bits.
uint64_t fixed(double value) {
    return static_cast<uint64_t>(std::llround(value * 4294967296.0));
}

gpu::vec4 vector(const std::array<float, 3>& v, float w) {
    return {v[0], v[1], v[2], w};
}

struct Simulation {
    gpu::ParticleSimulateConstants constants{};
    uint32_t steps = 0;
};

// Below 0: endless. A little wide, so that rounding never cuts a solid.
float bounding_radius(const Collider& collider) {
    const auto& size = collider.size;
    switch (collider.shape) {
    case ColliderShape::sphere:
        return 1.001f * size[0];
    case ColliderShape::box:
        return 1.001f * std::sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]);
    default:
        return -1.0f;
    }
}

void set_colliders(gpu::ParticleSimulateConstants& c, std::span<const Collider> colliders) {
    c.collider_count = static_cast<uint32_t>(colliders.size());
    gpu::vec4* target = c.colliders;
    for (const Collider& collider : colliders) {
        *target++ = vector(collider.centre, static_cast<float>(collider.shape));
        *target++ = vector(collider.size, bounding_radius(collider));
        for (size_t i = 0; i < 3; ++i)
            *target++ = vector(collider.axes[i], collider.velocity[i]);
    }
}

void set_air(gpu::ParticleSimulateConstants& c, const ParticleVolumeParameters& p) {
    c.air = {p.wind_x, p.wind_y, p.wind_z, p.drag};
    c.attractor = {p.attractor_x, p.attractor_y, p.attractor_z, p.attractor_strength};
    c.gravity = p.gravity;
    double squares = 0.0;
    for (int octave = 0; octave < p.curl_octaves; ++octave)
        squares += std::pow(0.49, octave); // as the shader's strengths, 0.7 of the one before
    c.curl_strength = static_cast<float>(p.curl_strength / std::sqrt(squares));
    c.curl_frequency = 1.0f / p.curl_scale;
    c.curl_speed = p.curl_speed;
}

void set_births(gpu::ParticleSimulateConstants& c, const ParticleVolumeParameters& p) {
    const double azimuth = radians(p.direction_azimuth), elevation = radians(p.direction_elevation);
    c.emitter = {p.position_x, p.position_y, p.position_z, p.emitter_size};
    c.direction = {static_cast<float>(std::cos(elevation) * std::sin(azimuth)), static_cast<float>(std::sin(elevation)),
                   static_cast<float>(std::cos(elevation) * std::cos(azimuth)),
                   static_cast<float>(std::cos(radians(p.spread)))};
    c.speed = p.speed;
    c.lifetime = p.lifetime;
    c.lifetime_variation = p.lifetime_variation;
    c.burst = static_cast<uint32_t>(p.burst);
    c.seed = static_cast<uint32_t>(p.seed);
    c.count = static_cast<uint32_t>(p.count);
}

void set_look(gpu::ParticleSimulateConstants& c, const ParticleVolumeParameters& p) {
    c.albedo = {p.albedo_r, p.albedo_g, p.albedo_b, p.emission};
    c.radius_start = p.radius_start;
    c.radius_end = p.radius_end;
    c.extinction = p.extinction;
    c.dilution = 3.0f * p.dilution; // a sphere's mass goes with the cube of its radius
    c.fade_in = p.fade_in;
    c.fade_out = p.fade_out;
    c.emission_time = p.emission_time;
}

Simulation make_simulation(const Frame& frame, const ParticleVolumeParameters& p) {
    Simulation result;
    gpu::ParticleSimulateConstants& c = result.constants;
    c.world_to_view.columns = frame.camera->world_to_view;
    c.view_to_world.columns = inverse(frame.camera->world_to_view);
    c.projection.columns = frame.camera->projection;
    // A pause of minutes is not caught up with.
    const double passed = std::min(static_cast<double>(frame.time_step) * p.time_scale, 60.0);
    const double seconds = passed + (frame.reset ? p.warm_up : 0.0);
    result.steps = static_cast<uint32_t>(std::min<double>(std::ceil(seconds / longest_step - 1e-3), most_steps));
    if (seconds > 0.0)
        result.steps = std::max(result.steps, 1u);
    const double step = result.steps > 0 ? seconds / result.steps : 0.0;
    const uint64_t births = fixed(p.rate * step), time = fixed(seconds);
    c.births_low = static_cast<uint32_t>(births);
    c.births_high = static_cast<uint32_t>(births >> 32);
    c.time_low = static_cast<uint32_t>(time);
    c.time_high = static_cast<uint32_t>(time >> 32);
    c.time_step = static_cast<float>(step);
    c.steps = result.steps;
    c.thickness = p.collision_thickness;
    c.bounce = p.bounce;
    c.friction = p.friction;
    set_births(c, p);
    set_air(c, p);
    set_look(c, p);
    set_colliders(c, frame.colliders);
    return result;
}

struct SimulationResources {
    ResourceId clock = no_resource;
    ResourceId sprites = no_resource;
    uint32_t steps = 0;
    std::vector<std::byte> constants;
};

SimulationResources plan_simulation(Planner& planner, const Frame& frame, const ParticleVolumeParameters& p,
                                    ResourceId depth) {
    Simulation simulation = make_simulation(frame, p);
    const auto count = static_cast<uint32_t>(p.count);
    const ResourceId clock = planner.state("clock", 32, 1);
    const ResourceId states = planner.state("particles", uint64_t{32} * count, count);
    const ResourceId sprites = planner.buffer("sprites", uint64_t{count} * sizeof(ParticleSprite), count);
    const bool with_depth = p.collision == ParticleCollision::depth || p.collision == ParticleCollision::both;
    const bool with_shapes = p.collision == ParticleCollision::analytic || p.collision == ParticleCollision::both;
    uint32_t first = 0;
    do {
        simulation.constants.first_step = first;
        simulation.constants.step_count = std::min(steps_in_a_pass, simulation.steps - first);
        first += simulation.constants.step_count;
        Pass& pass = planner.pass("simulate", shader::simulate);
        pass.specialization = {with_depth,
                               with_shapes,
                               frame.depth_kind == DepthKind::device,
                               static_cast<uint32_t>(p.emitter),
                               static_cast<uint32_t>(p.curl_octaves),
                               first == simulation.steps};
        pass.accesses = {read(depth),
                         {clock, AccessKind::buffer_read},
                         {states, AccessKind::buffer_write},
                         {sprites, AccessKind::buffer_write}};
        pass.constants = constants_of(simulation.constants);
        pass.dispatch = {DispatchKind::texels, states};
    } while (first < simulation.steps);
    return {clock, sprites, simulation.steps, constants_of(simulation.constants)};
}

// Last in the plan: all particles have read the clock by then, behind barriers that others needed.
void plan_clock(Planner& planner, const SimulationResources& simulation) {
    if (simulation.steps == 0)
        return;
    Pass& pass = planner.pass("advance", shader::advance);
    pass.accesses = {{simulation.clock, AccessKind::buffer_write}};
    pass.constants = simulation.constants;
    pass.dispatch = {DispatchKind::texels, simulation.clock};
}

} // namespace

std::string check_particles(const ParticleVolumeParameters& parameters, const ParticleVolumeImages& images) {
    if (drawn_profile(parameters) == ParticleProfile::texture && !images.profile)
        return "profile is texture, but image 'profile' is missing";
    return "";
}

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
    inputs.profile = host("profile", ParticleImage::profile, images.profile);
    inputs.output = host("output", ParticleImage::output, images.output);
    inputs.velocity_output = host("velocity output", ParticleImage::velocity_output, images.velocity_output);
    inputs.transmittance = host("transmittance", ParticleImage::transmittance, images.transmittance);
    inputs.statistics =
        planner.host_buffer("statistics", static_cast<uint32_t>(ParticleBuffer::statistics), images.statistics, 1);
    inputs.extent = images.colour.extent;
    SimulationResources simulation;
    if (images.sprites) {
        inputs.capacity = static_cast<uint32_t>(images.sprites.bytes / sizeof(ParticleSprite));
        inputs.sprites = planner.host_buffer("sprites", static_cast<uint32_t>(ParticleBuffer::sprites), images.sprites,
                                             inputs.capacity);
    } else {
        inputs.capacity = static_cast<uint32_t>(parameters.count);
        simulation = plan_simulation(planner, frame, parameters, inputs.depth);
        inputs.sprites = simulation.sprites;
    }
    plan_particle_draw(planner, inputs);
    plan_clock(planner, simulation);
    return std::move(planner).finish();
}

} // namespace sfumato
