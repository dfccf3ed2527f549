// Velocity and tile maximum in one pass: a workgroup a tile. Combines the inputs to a half displacement, clamps its
// length, stores it with the depth, and reduces the tile in shared memory.

layout(local_size_x = 256) in;

layout(constant_id = 0) const uint tile_size = 32;
layout(constant_id = 1) const bool is_packed = false;
layout(constant_id = 2) const bool has_depth = true;
layout(constant_id = 3) const bool depth_is_device = false;
layout(constant_id = 4) const bool has_velocity = true;
layout(constant_id = 5) const bool has_next_velocity = false;
layout(constant_id = 6) const bool has_previous_camera = false;
layout(constant_id = 7) const bool has_next_camera = false;
layout(constant_id = 8) const bool repair_edges = false;
layout(constant_id = 9) const uint layer_1 = 0; // 0 absent, then blend + 1: add, replace, larger
layout(constant_id = 10) const bool layer_1_has_mask = false;
layout(constant_id = 11) const uint layer_2 = 0;
layout(constant_id = 12) const bool layer_2_has_mask = false;
layout(constant_id = 13) const bool has_exclusion = false;

layout(set = 0, binding = 0) uniform sampler2D velocity_image;
layout(set = 0, binding = 1) uniform sampler2D next_velocity_image;
layout(set = 0, binding = 2) uniform sampler2D depth_image;
layout(set = 0, binding = 3) uniform sampler2D layer_1_image;
layout(set = 0, binding = 4) uniform sampler2D layer_1_mask;
layout(set = 0, binding = 5) uniform sampler2D layer_2_image;
layout(set = 0, binding = 6) uniform sampler2D layer_2_mask;
layout(set = 0, binding = 7) uniform sampler2D exclusion_image;
layout(set = 0, binding = 8) uniform writeonly uimage2D surface_image;
layout(set = 0, binding = 9) uniform writeonly image2D tile_image; // longest (xy), widest beside it (zw)
layout(set = 0, binding = 10) uniform writeonly image2D spread_image;
layout(set = 0, binding = 11) buffer TileLists { uint words[]; } lists;

// Nearest texel of an image of another size under the middle of the pixel. `ratio` is that image's size to the colour's;
// the product stays below the image's size without a clamp.
vec4 nearest(sampler2D image, vec2 ratio, ivec2 pixel) {
    return texelFetch(image, ivec2((vec2(pixel) + 0.5) * ratio), 0);
}

float depth_at(ivec2 pixel) {
    if (!has_depth)
        return 1.0;
    const float stored = nearest(depth_image, constants.depth_ratio, pixel).x;
    const float z = depth_is_device ? view_depth_of(stored, constants.clip_from_view) : stored;
    return is_sky(z) ? sky_depth : max(z, 0.0);
}

// Pixels per frame, as the image has it or as the camera moved. Pixels without a finite velocity and sky, which
// renderers leave without one, take the camera's motion.
vec2 input_velocity(sampler2D image, bool has_image, vec2 ratio, ivec2 pixel, float z, bool has_camera, mat4 other,
                    float direction) {
    vec2 v = vec2(0);
    bool known = false;
    if (has_image) {
        v = nearest(image, ratio, pixel).xy / ratio;
        known = is_finite(v);
    }
    if (has_camera && (!known || is_sky(z))) {
        v = direction * camera_displacement(constants.clip_from_view, other, z, pixel, constants.size);
        known = true;
    }
    return known ? v : vec2(0);
}

// This and the next interval's velocity, xy and zw.
vec4 velocities_at(ivec2 pixel, float z) {
    vec4 v;
    v.xy = input_velocity(velocity_image, has_velocity, constants.velocity_ratio, pixel, z, has_previous_camera,
                          constants.previous_clip_from_view, -1.0);
    v.zw = v.xy;
    if (has_next_velocity || has_next_camera) {
        const vec2 next = input_velocity(next_velocity_image, has_next_velocity, constants.next_velocity_ratio, pixel,
                                         z, has_next_camera, constants.next_clip_from_view, 1.0);
        // A pixel that the next image does not know, and no camera either, goes on as it came.
        const bool known = has_next_camera || is_finite(nearest(next_velocity_image, constants.next_velocity_ratio, pixel).xy);
        if (known)
            v.zw = next;
    }
    return v;
}

// The depth of the tile and of one pixel around it, for the repair of edges.
const uint apron = repair_edges ? tile_size + 2u : 1u;
shared float depths[apron * apron];

void load_depths(ivec2 origin) {
    [[unroll]] for (uint i = gl_LocalInvocationIndex; i < apron * apron; i += 256u) {
        const ivec2 pixel = origin + ivec2(i % apron, i / apron) - 1;
        depths[i] = depth_at(clamp(pixel, ivec2(0), ivec2(constants.size) - 1));
    }
    barrier();
}

bool is_like(float a, float b) { return abs(a - b) <= 0.02 * min(a, b); }

// Renderers filter vectors like colours: at a silhouette a vector is a mixture of both surfaces'. Where a pixel has
// neighbours of unlike depth, it takes of its 3×3 neighbours of like depth the vector farthest from the unlike ones'
// mean.
vec4 repaired_velocities_at(ivec2 pixel, ivec2 in_tile, float z) {
    const ivec2 last = ivec2(constants.size) - 1;
    const uint first = uint(in_tile.y) * apron + uint(in_tile.x); // of the 3×3 pixels around
    uint like = 0u;
    [[unroll]] for (uint i = 0u; i < 9u; ++i)
        like |= is_like(depths[first + i / 3u * apron + i % 3u], z) ? 1u << i : 0u;
    const bool is_edge = like != 0x1ffu;
    vec4 unlike = vec4(0);
    vec4 result = vec4(0);
    vec2 farthest = vec2(-1);
    // Twice round the nine: for the mean of the unlike, then for the farthest of the like. Away from edges only the
    // pixel itself is looked at, which is number 4 of the second round.
    for (uint k = is_edge ? 0u : 13u; k < (is_edge ? 18u : 14u); ++k) {
        const uint i = k % 9u;
        const bool is_like_one = (like >> i & 1u) != 0u;
        if (is_like_one != (k >= 9u))
            continue;
        const vec4 v = velocities_at(clamp(pixel + ivec2(i % 3u, i / 3u) - 1, ivec2(0), last),
                                     depths[first + i / 3u * apron + i % 3u]);
        if (k < 9u) {
            unlike += v / float(9 - bitCount(like));
            continue;
        }
        const vec4 d = v - unlike;
        const vec2 away = vec2(dot(d.xy, d.xy), dot(d.zw, d.zw));
        if (away.x > farthest.x) {
            farthest.x = away.x;
            result.xy = v.xy;
        }
        if (away.y > farthest.y) {
            farthest.y = away.y;
            result.zw = v.zw;
        }
    }
    return result;
}

float mask_value(float mask) { return mask > 0.0 ? min(mask, 1.0) : 0.0; } // NaN is 0

vec2 apply_layer(vec2 v, uint blend, sampler2D image, vec4 scale, bool has_mask, sampler2D mask_image, vec2 mask_ratio,
                 ivec2 pixel) {
    vec2 added = nearest(image, scale.xy, pixel).xy * scale.zw;
    if (!is_finite(added))
        added = vec2(0);
    const float mask = has_mask ? mask_value(nearest(mask_image, mask_ratio, pixel).x) : 1.0;
    if (blend == 1)
        return v + mask * added;
    if (blend == 2)
        return v + mask * (added - v);
    return mask * mask * dot(added, added) > dot(v, v) ? mask * added : v;
}

Surface surface_at(ivec2 pixel, ivec2 in_tile) {
    Surface s;
    s.z = repair_edges ? depths[uint(in_tile.y + 1) * apron + uint(in_tile.x + 1)] : depth_at(pixel);
    const vec4 known = repair_edges ? repaired_velocities_at(pixel, in_tile, s.z) : velocities_at(pixel, s.z);
    // The path through the three known points is a parabola, p(t) = t (next + previous) / 2 + t² (next - previous) / 2.
    // The shutter is open from (c - 1) E/2 to (c + 1) E/2; the half displacement is half the chord between the two.
    const vec2 mean = 0.5 * (known.xy + known.zw);
    const vec2 bend = 0.5 * (known.zw - known.xy);
    vec2 u = mean + constants.centre * constants.shutter * bend;
    if (layer_1 != 0)
        u = apply_layer(u, layer_1, layer_1_image, constants.layer_1_scale, layer_1_has_mask, layer_1_mask,
                        constants.layer_1_mask_ratio, pixel);
    if (layer_2 != 0)
        u = apply_layer(u, layer_2, layer_2_image, constants.layer_2_scale, layer_2_has_mask, layer_2_mask,
                        constants.layer_2_mask_ratio, pixel);
    s.v = 0.5 * constants.shutter * u;
    if (has_exclusion)
        s.v *= 1.0 - mask_value(nearest(exclusion_image, constants.exclusion_ratio, pixel).x);
    const float l = length(s.v);
    if (!is_finite(l))
        s.v = vec2(0);
    else if (l > constants.radius)
        s.v *= constants.radius / l;
    return s;
}

shared vec2 longest_of[256];
shared vec3 widest_of[256]; // vector, spread

void main() {
    const uint thread = gl_LocalInvocationIndex;
    const ivec2 origin = ivec2(gl_WorkGroupID.xy * tile_size);
    const ivec2 size = ivec2(constants.size);
    // The lists are empty until the next pass fills them; no other workgroup touches these words here.
    if (gl_WorkGroupID.xy == uvec2(0) && thread < 12u)
        lists.words[thread] = 0u;
    if (repair_edges)
        load_depths(origin);
    // Every thread keeps its pixels for the second reduction: tiles of at most 48×48 are 9 each.
    const uint kept = (tile_size * tile_size + 255u) / 256u;
    vec2 mine[9];
    vec2 longest = vec2(0);
    [[unroll]] for (uint k = 0; k < kept; ++k) {
        const uint i = thread + k * 256u;
        const ivec2 pixel = origin + ivec2(i % tile_size, i / tile_size);
        mine[k] = vec2(0);
        if (i >= tile_size * tile_size || any(greaterThanEqual(pixel, size)))
            continue;
        Surface s = surface_at(pixel, pixel - origin);
        // What is compared later is what is stored.
        if (is_packed) {
            const uint code = pack_8_bit(s, constants.radius);
            imageStore(surface_image, pixel, uvec4(code));
            s = unpack_8_bit(code, constants.radius);
        } else {
            const uvec2 code = pack_half(s);
            imageStore(surface_image, pixel, uvec4(code, 0, 0));
            s = unpack_half(code);
        }
        mine[k] = s.v;
        if (longer(s.v, longest))
            longest = s.v;
    }
    longest_of[thread] = longest;
    barrier();
    for (uint half_count = 128u; half_count > 0u; half_count /= 2u) {
        if (thread < half_count && longer(longest_of[thread + half_count], longest_of[thread]))
            longest_of[thread] = longest_of[thread + half_count];
        barrier();
    }
    longest = longest_of[0];
    vec3 widest = vec3(0);
    [[unroll]] for (uint k = 0; k < kept; ++k) {
        const uint i = thread + k * 256u;
        const ivec2 pixel = origin + ivec2(i % tile_size, i / tile_size);
        if (i >= tile_size * tile_size || any(greaterThanEqual(pixel, size)))
            continue;
        const vec2 v = mine[k];
        widest.z = max(widest.z, length(v - longest));
        if (wider(v, widest.xy, longest))
            widest.xy = v;
    }
    widest_of[thread] = widest;
    barrier();
    for (uint half_count = 128u; half_count > 0u; half_count /= 2u) {
        if (thread < half_count) {
            const vec3 other = widest_of[thread + half_count];
            widest.z = max(widest.z, other.z);
            if (wider(other.xy, widest.xy, longest))
                widest.xy = other.xy;
            widest_of[thread] = widest;
        }
        barrier();
    }
    if (thread == 0u) {
        imageStore(tile_image, ivec2(gl_WorkGroupID.xy), vec4(longest, widest.xy));
        imageStore(spread_image, ivec2(gl_WorkGroupID.xy), vec4(widest.z));
    }
}
