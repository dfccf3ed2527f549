// One particle through the steps of this pass: birth, forces, collisions, death; then its sprite.
//
// A state is two vectors: position and age, velocity and the number of its birth (0: dead). Births go round the slots, so
// that a slot keeps its particle for life and equal sort keys keep their order.

layout(local_size_x = 256) in;
layout(constant_id = 3) const uint emitter_shape = 0; // point, sphere, box, disc
layout(constant_id = 5) const bool writes_sprites = true; // the last pass of a frame

layout(std430, set = 0, binding = 1) readonly buffer ClockBuffer { Clock clock; };
layout(std430, set = 0, binding = 2) buffer States { uvec4 states[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Sprites { vec4 sprites[]; }; // ParticleSprite, by vectors

float random(inout uint state) {
    state = state * 747796405u + 2891336453u;
    return float(mix_bits(state) >> 8) / 16777216.0;
}

vec3 on_sphere(float u, float v) {
    const float z = 1.0 - 2.0 * u, r = sqrt(max(0.0, 1.0 - z * z));
    return vec3(r * cos(6.2831853 * v), r * sin(6.2831853 * v), z);
}

vec3 in_emitter(inout uint state) {
    const float a = random(state), b = random(state), c = random(state);
    if (emitter_shape == 1u)
        return on_sphere(a, b) * pow(c, 1.0 / 3.0);
    if (emitter_shape == 2u)
        return vec3(a, b, c) * 2.0 - 1.0;
    if (emitter_shape == 3u)
        return sqrt(a) * vec3(cos(6.2831853 * b), 0.0, sin(6.2831853 * b));
    return vec3(0);
}

// Evenly over the cap of directions about constants.direction.
vec3 start_direction(inout uint state) {
    const float a = random(state), b = random(state);
    const vec3 axis = constants.direction.xyz;
    const float along = 1.0 - a * (1.0 - constants.direction.w), across = sqrt(max(0.0, 1.0 - along * along));
    const vec3 side = normalize(cross(abs(axis.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0), axis));
    return along * axis + across * (cos(6.2831853 * b) * side + sin(6.2831853 * b) * cross(axis, side));
}

uint random_of(uint id) { return mix_bits(id ^ mix_bits(constants.seed + 0x9e3779b9u)); }

float lifetime_of(uint id) {
    uint state = random_of(id) ^ 0x5bd1e995u;
    return max(1e-3, constants.lifetime * (1.0 + constants.lifetime_variation * (2.0 * random(state) - 1.0)));
}

Mover born(uint id) {
    uint state = random_of(id);
    const vec3 place = in_emitter(state);
    return Mover(constants.emitter.xyz + constants.emitter.w * place, constants.speed * start_direction(state));
}

// Exact for a drag towards air of this velocity and an acceleration that stays: any step is stable.
Mover driven(Mover m, float step, vec2 time) {
    const float drag = constants.air.w, x = drag * step;
    vec3 push = vec3(0, -constants.gravity, 0);
    if (constants.attractor.w != 0.0) {
        const vec3 to = constants.attractor.xyz - m.position;
        push += constants.attractor.w * to / (dot(to, to) + 1.0);
    }
    if (drag > 0.0)
        push += drag * air_velocity(m.position, time);
    const float stays = exp(-x);
    const float one = x > 1e-2 ? (1.0 - stays) / x : 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0));
    const float two = x > 1e-2 ? (1.0 - one) / x : 0.5 - x * (1.0 / 6.0 - x / 24.0);
    return Mover(m.position + step * (one * m.velocity + step * two * push), stays * m.velocity + step * one * push);
}

bool is_sound(Mover m) {
    const float reach = max(max(abs(m.position.x), abs(m.position.y)), abs(m.position.z));
    const float speed = max(max(abs(m.velocity.x), abs(m.velocity.y)), abs(m.velocity.z));
    // The sum is NaN or infinite where any component is, which a maximum may hide.
    return is_finite(dot(m.position, vec3(1)) + dot(m.velocity, vec3(1))) && reach < 1e7 && speed < 1e7;
}

void write_sprite(uint slot, Mover m, float age, uint id) {
    if (id == 0u) {
        for (uint i = 0u; i < 3u; ++i)
            sprites[3u * slot + i] = vec4(0);
        return;
    }
    const float share = clamp(age / lifetime_of(id), 0.0, 1.0);
    // Grows fast at first, as what mixes with air does.
    const float radius = mix(constants.radius_start, constants.radius_end, share * (2.0 - share));
    const float appears = constants.fade_in > 0.0 ? min(1.0, share / constants.fade_in) : 1.0;
    const float stays = constants.fade_out > 0.0 ? min(1.0, (1.0 - share) / constants.fade_out) : 1.0;
    const float thins = pow(constants.radius_start / radius, constants.dilution);
    const vec4 albedo = constants.albedo;
    sprites[3u * slot] = vec4(m.position, radius);
    sprites[3u * slot + 1u] = vec4(m.velocity, constants.extinction * thins * appears * stays);
    sprites[3u * slot + 2u] = vec4(albedo.rgb, albedo.a * exp(-age / constants.emission_time));
}

void main() {
    const uint slot = gl_GlobalInvocationID.x;
    if (slot >= constants.count)
        return;
    const Clock before = clock_of_slots(clock);
    const uvec4 a = states[2u * slot], b = states[2u * slot + 1u];
    Mover m = Mover(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz));
    float age = uintBitsToFloat(a.w);
    uint id = b.w;
    const uint burst = burst_of(before);
    // Which of the births to come is this slot's: every one that is `turn` modulo the count.
    const uint turn = slot >= before.slot ? slot - before.slot : slot + (constants.count - before.slot);
    for (uint i = constants.first_step; i < constants.first_step + constants.step_count; ++i) {
        const uint rated_before = rated_births(before, i), rated = rated_births(before, i + 1u) - rated_before;
        const uint first = rated_before + (i > 0u ? burst : 0u);
        const uint end = rated_before + rated + burst;
        float step = constants.time_step;
        if (end > turn) {
            const uint birth = end - 1u - (end - 1u - turn) % constants.count;
            if (birth >= first) {
                id = max(1u, before.births + birth + 1u);
                m = born(id);
                age = 0.0;
                // Spread over the step, in order; a burst is there when it starts.
                if (birth >= burst)
                    step *= 1.0 - (float(birth - burst - rated_before) + 0.5) / float(rated);
            }
        }
        if (id == 0u)
            continue;
        const vec2 time =
            vec2(float(before.time_high), fixed_fraction(before.time_low) + float(i) * constants.time_step);
        Mover after = driven(m, step, time);
        // Before a surface can round it back to where particles are.
        if (!is_sound(after)) {
            id = 0u;
            continue;
        }
        if (collides_with_shapes && constants.collider_count > 0u)
            after = collide_with_shapes(m, after, step);
        if (collides_with_depth)
            after = collide_with_depth(m, after);
        m = after;
        age += step;
        if (age >= lifetime_of(id) || !is_sound(m))
            id = 0u;
    }
    if (id == 0u)
        m = Mover(vec3(0), vec3(0));
    if (constants.step_count > 0u) {
        states[2u * slot] = uvec4(floatBitsToUint(m.position), floatBitsToUint(id == 0u ? 0.0 : age));
        states[2u * slot + 1u] = uvec4(floatBitsToUint(m.velocity), id);
    }
    if (writes_sprites)
        write_sprite(slot, m, age, id);
}
