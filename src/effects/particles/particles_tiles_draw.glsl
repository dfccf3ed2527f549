// One tile: its particles in order, 256 at a time through shared memory. Each block of 8×4 pixels walks along a bit mask
// of those that touch it, so that threads that run together skip the rest.

layout(local_size_x = 256) in;

layout(constant_id = 0) const bool backward = false;  // blends over, from far to near; else under, from near to far
layout(constant_id = 1) const bool snapshots = false; // also what lies before the nearest depth of the pixel's block
layout(constant_id = 2) const bool has_velocity = false;
layout(constant_id = 3) const bool perspective = true;
layout(constant_id = 4) const uint profile = 0u; // ParticleProfile

layout(set = 0, binding = 0) readonly buffer Ranges { uvec2 data[]; } ranges;
layout(set = 0, binding = 1) readonly buffer Ranks { uint data[]; } ranks;
layout(set = 0, binding = 2) readonly buffer Records { uvec4 data[]; } records;
layout(set = 0, binding = 3) readonly buffer Extras { uint data[]; } extras; // velocity, pattern: where there are any
layout(set = 0, binding = 4) uniform sampler2D depth_image; // nearest and farthest of the block
layout(set = 0, binding = 5) uniform writeonly image2D far_image;
layout(set = 0, binding = 6) uniform writeonly image2D near_image;
layout(set = 0, binding = 7) uniform writeonly image2D velocity_image;
layout(set = 0, binding = 8) uniform sampler2D profile_table;

#include "particles_profile.glsl"

const float opaque = 1.0 / 1024.0; // transmittance below which nothing more is seen
const uint blocks = 8u;
const uint words = 8u; // of 32 particles

shared vec4 shape[256];   // middle, 1 / radius, optical depth of half the sphere in powers of two
shared uvec4 look[256];   // view depth, radius in scene units, colour as halves
shared uvec2 light[256];  // how it varies over the disc, as halves
shared uint moved[256];
const uint patterns = profile != 0u ? 256u : 1u;
shared uvec4 pattern[patterns]; // turn, middle in the table, shares of chord and profile, level
shared uint hits[blocks * words];
shared uint unfinished;

// Bit i: the disc reaches the tile's block i.
uint blocks_hit(vec2 middle, float radius) {
    uint mask = 0u;
    [[unroll]] for (uint i = 0u; i < blocks; ++i) {
        const vec2 low = vec2(i & 1u, i >> 1) * vec2(8, 4) + 0.5; // the middles of its corner pixels
        const vec2 nearest = clamp(middle, low, low + vec2(7, 3)) - middle;
        mask |= dot(nearest, nearest) < radius * radius ? 1u << i : 0u;
    }
    return mask;
}

// What a disc of that radius, in pixels, needs of its pattern. Discs too small to show it are spheres; those twice as
// large show all of it.
uvec4 unpack_pattern(uint word, float radius) {
    const uint bits = word >> 16;
    const float share = constants.profile_strength * clamp(radius / constants.profile_least - 1.0, 0.0, 1.0);
    const vec2 middle = profile == profile_noise ? place_middle(place_of(bits), constants.profile_reach) : vec2(0.5);
    const float texels = constants.profile_reach * profile_side / radius; // a pixel
    return uvec4(packSnorm2x16(turn_of(bits)), packUnorm2x16(middle),
                 packHalf2x16(vec2(1.0 - share, share * unpackHalf2x16(word).x)),
                 floatBitsToUint(clamp(log2(texels), 0.0, float(profile_levels) - 1.0)));
}

// Optical depth over that through a sphere's middle, at `d` radii from it, where the sphere's chord is `root`.
float profile_at(uint i, vec2 d, float root) {
    const uvec4 p = pattern[i];
    const vec2 turn = unpackSnorm2x16(p.x), shares = unpackHalf2x16(p.z);
    const vec2 turned = vec2(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y);
    const vec2 at = unpackUnorm2x16(p.y) + constants.profile_reach * turned;
    const float value = textureLod(profile_table, at, uintBitsToFloat(p.w)).x;
    return shares.x * root + shares.y * value * (profile == profile_noise ? root : 1.0);
}

void stage(uint pair, vec2 origin) {
    const uint thread = gl_LocalInvocationIndex;
    const uint rank = ranks.data[pair];
    const uvec4 packed = records.data[2u * rank + 1u];
    const vec4 disc = uintBitsToFloat(records.data[2u * rank]);
    const vec2 middle = disc.xy - origin;
    const float radius = disc.z, depth = disc.w;
    // Of the sphere as it is drawn, in scene units.
    const float metres = radius * (perspective ? depth : 1.0) / constants.pixels;
    shape[thread] = vec4(middle, 1.0 / radius, 1.442695 * unpackHalf2x16(packed.x).x);
    look[thread] = uvec4(floatBitsToUint(vec2(depth, metres)), packed.xy);
    light[thread] = packed.zw;
    const uint extra = uint(has_velocity) + uint(profile != 0u);
    if (has_velocity)
        moved[thread] = extras.data[extra * rank];
    if (profile != 0u)
        pattern[thread] = unpack_pattern(extras.data[extra * rank + extra - 1u], radius);
    const uint mask = blocks_hit(middle, radius);
    [[unroll]] for (uint i = 0u; i < blocks; ++i)
        if ((mask >> i & 1u) != 0u)
            atomicOr(hits[i * words + thread / 32u], 1u << (thread % 32u));
}

struct Layer {
    vec3 colour;
    float through; // transmittance
};

// Of half a sphere's chord, the part in front of a surface: 0 behind it, 2 in front of it. The sphere itself is cut,
// so the edge is as soft as the particle is deep, and never sharper than asked for.
float part_before(float surface, float depth, float half_chord) {
    return clamp((surface - depth) / max(half_chord, 0.5 * constants.soft_distance) + 1.0, 0.0, 2.0);
}

float blend(inout Layer layer, vec3 colour, float optical_depth) {
    const float kept = exp2(-optical_depth);
    const float share = backward ? 1.0 - kept : layer.through - layer.through * kept;
    layer.colour = backward ? layer.colour * kept + share * colour : layer.colour + share * colour;
    layer.through *= kept;
    return share;
}

void main() {
    const uint thread = gl_LocalInvocationIndex;
    const uint block = thread / 32u;
    const uvec2 within = uvec2((block & 1u) * 8u + thread % 8u, (block >> 1) * 4u + thread % 32u / 8u);
    const ivec2 pixel = ivec2(gl_WorkGroupID.xy * 16u + within);
    const vec2 origin = vec2(gl_WorkGroupID.xy * 16u);
    const vec2 at = vec2(within) + 0.5;
    const bool is_inside = all(lessThan(vec2(pixel), constants.working_size));
    const vec2 depths = is_inside ? texelFetch(depth_image, pixel, 0).xy : vec2(0);
    const bool has_edge = snapshots && depths.x < depths.y;
    const uvec2 range = ranges.data[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x];
    Layer all_of_it = Layer(vec3(0), 1.0), before = Layer(vec3(0), 1.0);
    vec2 velocity = vec2(0);
    for (uint first = range.x; first < range.y; first += 256u) {
        barrier();
        if (thread < blocks * words)
            hits[thread] = 0u;
        if (thread == 0u)
            unfinished = 0u;
        barrier();
        if (first + thread < range.y)
            stage(first + thread, origin);
        barrier();
        bool is_done = !is_inside || (!backward && all_of_it.through < opaque);
        for (uint word = 0u; word < words && !is_done; ++word) {
            uint bits = hits[block * words + word];
            while (bits != 0u && !is_done) {
                const uint i = word * 32u + uint(findLSB(bits));
                bits &= bits - 1u;
                const vec4 s = shape[i];
                const vec2 d = (at - s.xy) * s.z;
                const float q = 1.0 - dot(d, d);
                if (q <= 0.0)
                    continue;
                const uvec4 l = look[i];
                const vec2 reach = uintBitsToFloat(l.xy);
                const float root = sqrt(q);
                float spread = root;
                if (profile != 0u)
                    spread = profile_at(i, d, root);
                const float optical_depth = s.w * spread;
                const vec2 slopes = unpackHalf2x16(light[i].x), curves = unpackHalf2x16(light[i].y);
                const float lit = max(1.0 + dot(slopes, d) + dot(curves, d * d - 0.2), 0.0);
                const vec3 colour = vec3(unpackHalf2x16(l.z).y, unpackHalf2x16(l.w)) * lit;
                const float seen = part_before(depths.y, reach.x, reach.y * root);
                const float share = blend(all_of_it, colour, optical_depth * seen);
                if (has_edge)
                    blend(before, colour, optical_depth * part_before(depths.x, reach.x, reach.y * root));
                if (has_velocity)
                    velocity = (backward ? velocity * (1.0 - share) : velocity) + share * unpackHalf2x16(moved[i]);
                is_done = !backward && all_of_it.through < opaque;
            }
        }
        if (!backward) {
            if (!is_done)
                unfinished = 1u;
            barrier();
            if (unfinished == 0u)
                break;
        }
    }
    if (!is_inside)
        return;
    imageStore(far_image, pixel, vec4(min(all_of_it.colour, vec3(65000.0)), all_of_it.through));
    if (snapshots) {
        if (!has_edge)
            before = all_of_it;
        imageStore(near_image, pixel, vec4(min(before.colour, vec3(65000.0)), before.through));
    }
    if (has_velocity)
        imageStore(velocity_image, pixel, vec4(velocity, 0, 0));
}
