// Which particles are to be sorted, and the extent of all that are alive: along the axis of sorting, and across and
// along each light.

layout(local_size_x = 256) in;

layout(constant_id = 0) const uint light_count = 1u;
layout(constant_id = 1) const bool needs_view = true; // only what is drawn is sorted

layout(set = 0, binding = 0) readonly buffer Sprites { vec4 data[]; } sprites;
layout(set = 0, binding = 1) buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 2) writeonly buffer Flags { uint data[]; } flags;

const uint per_thread = 8u;

shared uint extremes[28];
shared uint optical, clamped, living, drawn;

void main() {
    const uint thread = gl_LocalInvocationIndex;
    if (thread < 28u)
        extremes[thread] = thread == fact_key_high || (thread >= fact_light && (thread - fact_light) % 6u >= 3u)
                               ? 0u : 0xffffffffu;
    if (thread == 0u)
        optical = clamped = living = drawn = 0u;
    barrier();
    float key_low = 3e38, key_high = -3e38;
    vec3 low[4], high[4];
    [[unroll]] for (uint l = 0u; l < 4u; ++l) {
        low[l] = vec3(3e38);
        high[l] = vec3(-3e38);
    }
    uint sum = 0u, cut = 0u, alive_count = 0u, drawn_count = 0u;
    bool any_sorted = false;
    for (uint i = 0u; i < per_thread; ++i) {
        const uint index = (gl_WorkGroupID.x * per_thread + i) * 256u + thread;
        if (index >= constants.capacity)
            break;
        const vec4 a = sprites.data[3u * index], b = sprites.data[3u * index + 1u], c = sprites.data[3u * index + 2u];
        const bool alive = is_alive(a, b, c);
        const Disc disc = project(a.xyz, a.w);
        const bool in_view = alive && disc.in_view;
        const bool is_drawn = in_view && stand_in(index, disc.radius, 2.0 * a.w * b.w).depth > 0.0;
        const bool is_sorted = alive && (is_drawn || !needs_view);
        flags.data[index] = is_sorted ? 1u : 0u;
        if (is_sorted) {
            const float key = sort_depth(a.xyz);
            key_low = min(key_low, key);
            key_high = max(key_high, key);
            any_sorted = true;
        }
        if (!alive)
            continue;
        ++alive_count;
        drawn_count += in_view ? 1u : 0u;
        cut += 2.0 * a.w * b.w > deepest ? 1u : 0u;
        sum += uint(min(2.0 * a.w * b.w, deepest) * 65536.0) + 1u;
        [[unroll]] for (uint l = 0u; l < light_count; ++l) {
            const vec3 place = light_space(light_of(l), a.xyz);
            low[l] = min(low[l], place - vec3(a.w, a.w, 0));
            high[l] = max(high[l], place + vec3(a.w, a.w, 0));
        }
    }
    if (any_sorted) {
        atomicMin(extremes[fact_key_low], ordered(key_low));
        atomicMax(extremes[fact_key_high], ordered(key_high));
    }
    if (alive_count != 0u) {
        atomicAdd(optical, sum >> 8); // 2048 particles of 16 fit
        atomicAdd(living, alive_count);
        atomicAdd(drawn, drawn_count);
        atomicAdd(clamped, cut);
        for (uint l = 0u; l < light_count; ++l)
            [[unroll]] for (uint k = 0u; k < 3u; ++k) {
                atomicMin(extremes[fact_light + 6u * l + k], ordered(low[l][k]));
                atomicMax(extremes[fact_light + 6u * l + 3u + k], ordered(high[l][k]));
            }
    }
    barrier();
    if (thread == fact_optical)
        atomicAdd(facts.data[fact_optical], (optical >> 4) + 17u); // rounded up
    else if (thread == fact_clamped)
        atomicAdd(facts.data[fact_clamped], clamped);
    else if (thread == fact_alive)
        atomicAdd(facts.data[fact_alive], living);
    else if (thread == fact_drawn)
        atomicAdd(facts.data[fact_drawn], drawn);
    else if (thread == fact_key_low || (thread >= fact_light && thread < fact_light + 6u * light_count &&
                                        (thread - fact_light) % 6u < 3u))
        atomicMin(facts.data[thread], extremes[thread]);
    else if (thread == fact_key_high || (thread >= fact_light && thread < fact_light + 6u * light_count))
        atomicMax(facts.data[thread], extremes[thread]);
}
