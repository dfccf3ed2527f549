// Adds each particle's optical depth to its layer. Eight threads share a particle and lie along a row, or along two or
// four where a row is short, so that their additions fall into few stretches of memory.

layout(local_size_x = 256) in;

layout(constant_id = 0) const uint light_count = 1u;
// Whether the first light's layers are slices of equal counts in sorted order; else layers are of equal depth.
layout(constant_id = 1) const bool by_rank = false;

layout(set = 0, binding = 0) readonly buffer Sprites { vec4 data[]; } sprites;
layout(set = 0, binding = 1) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 2) readonly buffer Sorted { uint data[]; } sorted; // particles' numbers
layout(set = 0, binding = 3) readonly buffer Count { uint data[]; } count;   // of the sorted
layout(set = 0, binding = 4) buffer Volume { uint data[]; } volume;

#include "particles_light_volume.glsl"

const uint lanes = 8u;
const uint rounds = 4u; // particles that a thread takes part in: four million fit into one row of workgroups

shared float sums[256];

void main() {
    const uint lane = gl_LocalInvocationIndex % lanes;
    const uint group = gl_LocalInvocationIndex / lanes;
    for (uint r = 0u; r < rounds; ++r) {
        const uint rank = (gl_WorkGroupID.x * rounds + r) * (256u / lanes) + group;
        const uint live = by_rank ? count.data[0] : constants.capacity;
        const uint index = rank >= live ? 0u : by_rank ? sorted.data[rank] : rank;
        const vec4 a = sprites.data[3u * index], b = sprites.data[3u * index + 1u], c = sprites.data[3u * index + 2u];
        const bool alive = rank < live && is_alive(a, b, c);
        for (uint light = 0u; light < light_count; ++light) {
            const LightSpace space = space_of(light);
            Footprint f = Footprint(vec2(0), 0.0, 0.0);
            vec3 place = vec3(0);
            bool is_small = false;
            if (alive) {
                place = light_space(light_of(light), a.xyz);
                f = footprint_of(space, place.xy, a.w, 2.0 * a.w * b.w);
                is_small = f.radius < exact_radius;
            }
            sums[gl_LocalInvocationIndex] = is_small ? column_sum(f, int(lane)) : 0.0;
            barrier();
            if (is_small) {
                float chords = 0.0;
                [[unroll]] for (uint i = 0u; i < lanes; ++i)
                    chords += sums[group * lanes + i];
                f.depth *= mass_factor(f, chords);
            }
            barrier();
            if (!alive)
                continue;
            const uint slice = (live + constants.layers - 1u) / constants.layers; // the last slice may hold fewer: none is left out
            const ivec2 first = max(ivec2(floor(f.middle - f.radius - 0.5)) + 1, ivec2(0));
            const ivec2 last = min(ivec2(floor(f.middle + f.radius - 0.5)), ivec2(constants.side) - 1);
            const float units = f.depth / uintBitsToFloat(facts.data[fact_unit]);
            const uint columns = last.x - first.x > 3 ? 8u : last.x - first.x > 1 ? 4u : 2u;
            for (int y = first.y + int(lane / columns); y <= last.y; y += int(lanes / columns)) {
                const float layers = clamp(layers_along(space, uint(y), place.z), 0.0, float(constants.layers) - 1.0);
                const uint layer = by_rank && light == 0u ? rank / max(slice, 1u) : uint(layers);
                const uint start = layer_start(light, layer) + uint(y) * constants.side;
                for (int x = first.x + int(lane % columns); x <= last.x; x += int(columns)) {
                    const uint value = uint(units * footprint_chord(f, vec2(x, y) + 0.5) + 0.5);
                    if (value != 0u)
                        atomicAdd(volume.data[start + uint(x)], value);
                }
            }
        }
    }
}
