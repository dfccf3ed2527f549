// Velocity and tile maximum in one pass: a workgroup a tile. Combines the inputs to a half displacement, clamps its
// length, stores it with the depth, and reduces the tile in shared memory.

layout(local_size_x_id = 15) in; // a quarter of the tile's pixels

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
layout(constant_id = 14) const bool same_size = true; // all inputs have the colour's size

const uint threads = gl_WorkGroupSize.x;

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
    return texelFetch(image, same_size ? pixel : ivec2((vec2(pixel) + 0.5) * ratio), 0);
}

float depth_at(ivec2 pixel) {
    if (!has_depth)
        return 1.0;
    const float stored = nearest(depth_image, constants.depth_ratio, pixel).x;
    const float z = depth_is_device ? view_depth_of(stored, constants.clip_from_view) : stored;
    return is_sky(z) ? sky_depth : max(z, 0.0);
}

// Pixels without a finite velocity, and sky, which renderers leave without one, take the camera's motion. A next velocity
// that neither the image nor a camera knows goes on as the pixel came.
vec4 completed(vec4 v, ivec2 pixel, float z) {
    const bool is_known = has_velocity && is_finite(v.xy);
    if (has_previous_camera && (!is_known || is_sky(z)))
        v.xy = -camera_displacement(constants.clip_from_view, constants.previous_clip_from_view, z, pixel,
                                    constants.size);
    else if (!is_known)
        v.xy = vec2(0);
    const bool is_next_known = has_next_velocity && is_finite(v.zw);
    if (has_next_camera && (!is_next_known || is_sky(z)))
        v.zw = camera_displacement(constants.clip_from_view, constants.next_clip_from_view, z, pixel, constants.size);
    else if (!is_next_known)
        v.zw = v.xy;
    return v;
}

// What the velocity images hold at a pixel, this and the next interval's, in pixels of the colour image.
vec4 stored_velocities_at(ivec2 pixel) {
    vec4 v = vec4(0);
    if (has_velocity)
        v.xy = nearest(velocity_image, constants.velocity_ratio, pixel).xy;
    v.zw = has_next_velocity ? nearest(next_velocity_image, constants.next_velocity_ratio, pixel).xy : v.xy;
    if (!same_size && has_velocity)
        v /= vec4(constants.velocity_ratio, has_next_velocity ? constants.next_velocity_ratio : constants.velocity_ratio);
    return v;
}

// ---- repair of edges ----
// Renderers filter vectors like colours: at a silhouette a vector is a mixture of both surfaces'. Where a pixel has
// neighbours of unlike depth, it takes of its 3×3 neighbours of like depth the vector farthest from the unlike ones'
// mean. Vectors that are not finite neither count nor are taken.

// Depth of the tile and of one pixel around it.
const uint apron = repair_edges ? tile_size + 2u : 1u;
shared float depths[apron * apron];

void load_depths(ivec2 origin) {
    const ivec2 last = ivec2(constants.size) - 1;
    for (uint first = gl_LocalInvocationIndex; first < apron * apron; first += 4u * threads) {
        float loaded[4]; // all under way at once
        [[unroll]] for (uint k = 0u; k < 4u; ++k) {
            const uint i = min(first + threads * k, apron * apron - 1u);
            loaded[k] = depth_at(clamp(origin + ivec2(i % apron, i / apron) - 1, ivec2(0), last));
        }
        [[unroll]] for (uint k = 0u; k < 4u; ++k)
            depths[min(first + threads * k, apron * apron - 1u)] = loaded[k];
    }
    barrier();
}

const float like_ratio = 1.02;
bool is_like(float a, float b) { return max(a, b) <= like_ratio * min(a, b); }

// Least and greatest depth of three pixels in a row of the apron.
vec2 range_of_row(uint at) {
    const float a = depths[at], b = depths[at + 1u], c = depths[at + 2u];
    return vec2(min(min(a, b), c), max(max(a, b), c));
}

// `first` is the upper left of the 3×3 pixels in the apron.
vec4 repaired_velocities_at(ivec2 pixel, uint first) {
    const ivec2 last = ivec2(constants.size) - 1;
    const float z = depths[first + apron + 1u];
    vec4 around[9];
    [[unroll]] for (int i = 0; i < 9; ++i)
        around[i] = stored_velocities_at(clamp(pixel + ivec2(i % 3, i / 3) - 1, ivec2(0), last));
    vec4 unlike = vec4(0);
    vec2 count = vec2(0);
    uint like = 0u;
    [[unroll]] for (uint i = 0u; i < 9u; ++i) {
        const bool is_like_one = is_like(depths[first + i / 3u * apron + i % 3u], z);
        like |= is_like_one ? 1u << i : 0u;
        if (!is_like_one && is_finite(around[i].xy)) {
            unlike.xy += around[i].xy;
            count.x += 1.0;
        }
        if (!is_like_one && is_finite(around[i].zw)) {
            unlike.zw += around[i].zw;
            count.y += 1.0;
        }
    }
    unlike /= max(count.xxyy, vec4(1));
    vec4 result = around[4];
    vec2 farthest = vec2(-1);
    [[unroll]] for (uint i = 0u; i < 9u; ++i) {
        const vec4 d = around[i] - unlike;
        const vec2 away = vec2(dot(d.xy, d.xy), dot(d.zw, d.zw)); // not finite where the vector is not
        const bool is_like_one = (like >> i & 1u) != 0u;
        if (is_like_one && count.x > 0.0 && is_finite(away.x) && away.x > farthest.x) {
            farthest.x = away.x;
            result.xy = around[i].xy;
        }
        if (is_like_one && count.y > 0.0 && is_finite(away.y) && away.y > farthest.y) {
            farthest.y = away.y;
            result.zw = around[i].zw;
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

// The half displacement from this and the next interval's velocity, xy and zw.
vec2 half_displacement(ivec2 pixel, vec4 known) {
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
    vec2 v = 0.5 * constants.shutter * u;
    if (has_exclusion)
        v *= 1.0 - mask_value(nearest(exclusion_image, constants.exclusion_ratio, pixel).x);
    const float l = length(v);
    if (!is_finite(l) || l < no_length)
        return vec2(0);
    return l > constants.radius ? v * (constants.radius / l) : v;
}

// The tile's vectors as they are stored: what is compared is what the gather will read.
shared uint stored_of[tile_size * tile_size];

void store_pixel(ivec2 pixel, uint in_tile, Surface s) {
    if (is_packed) {
        const uint code = pack_8_bit(s, constants.radius);
        imageStore(surface_image, pixel, uvec4(code));
        stored_of[in_tile] = code;
    } else {
        const uvec2 code = pack_half(s);
        imageStore(surface_image, pixel, uvec4(code, 0, 0));
        stored_of[in_tile] = code.x;
    }
}

vec2 stored_vector(uint in_tile) {
    return is_packed ? unpack_vector_8_bit(stored_of[in_tile], constants.radius) : unpackHalf2x16(stored_of[in_tile]);
}

// ---- reductions of a workgroup, by subgroups where the device has them ----

#ifdef SUBGROUPS
const uint partials = 64u; // subgroups of a workgroup of 256, at least 4 wide
#else
const uint partials = 256u;
#endif
shared vec2 longest_of[partials];
shared vec3 widest_of[partials]; // vector, squared spread

#ifdef SUBGROUPS
// Floats as unsigned integers of the same order: their maximum is one instruction where that of floats is many.
uint ordered(float x) {
    const uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float from_ordered(uint key) {
    return uintBitsToFloat((key & 0x80000000u) != 0u ? key & 0x7fffffffu : ~key);
}

// The greatest of the subgroup by `key`, then x, then y.
vec2 subgroup_greatest(float key, vec2 v) {
    const uint k = floatBitsToUint(key); // not negative
    const bool is_first = k == subgroupMax(k);
    const uint x = subgroupMax(is_first ? ordered(v.x) : 0u);
    const uint y = subgroupMax(is_first && ordered(v.x) == x ? ordered(v.y) : 0u);
    return vec2(from_ordered(x), from_ordered(y));
}

vec2 reduce_longest(vec2 mine) {
    const vec2 best = subgroup_greatest(dot(mine, mine), mine);
    if (subgroupElect())
        longest_of[gl_SubgroupID] = best;
    barrier();
    vec2 result = longest_of[0];
    for (uint i = 1u; i < gl_NumSubgroups; ++i)
        if (longer(longest_of[i], result))
            result = longest_of[i];
    return result;
}

vec3 reduce_widest(vec3 mine, vec2 longest) {
    const vec2 best = subgroup_greatest(abs(cross_product(mine.xy, longest)), mine.xy);
    const float spread = uintBitsToFloat(subgroupMax(floatBitsToUint(mine.z)));
    if (subgroupElect())
        widest_of[gl_SubgroupID] = vec3(best, spread);
    barrier();
    vec3 result = widest_of[0];
    for (uint i = 1u; i < gl_NumSubgroups; ++i) {
        result.z = max(result.z, widest_of[i].z);
        if (wider(widest_of[i].xy, result.xy, longest))
            result.xy = widest_of[i].xy;
    }
    return result;
}
#else
vec2 reduce_longest(vec2 mine) {
    const uint thread = gl_LocalInvocationIndex;
    longest_of[thread] = mine;
    barrier();
    for (uint left = threads; left > 1u; left = (left + 1u) / 2u) {
        const uint other = thread + (left + 1u) / 2u;
        if (other < left && longer(longest_of[other], longest_of[thread]))
            longest_of[thread] = longest_of[other];
        barrier();
    }
    return longest_of[0];
}

vec3 reduce_widest(vec3 mine, vec2 longest) {
    const uint thread = gl_LocalInvocationIndex;
    widest_of[thread] = mine;
    barrier();
    for (uint left = threads; left > 1u; left = (left + 1u) / 2u) {
        const uint there = thread + (left + 1u) / 2u;
        if (there < left) {
            const vec3 other = widest_of[there];
            mine.z = max(mine.z, other.z);
            if (wider(other.xy, mine.xy, longest))
                mine.xy = other.xy;
            widest_of[thread] = mine;
        }
        barrier();
    }
    return widest_of[0];
}
#endif

// A thread goes down four rows of one column of the tile, so that a row's range of depth serves three pixels.
const uint rows = 4u;

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy * tile_size);
    const ivec2 size = ivec2(constants.size);
    // The lists are empty until the next pass fills them; no other workgroup touches these words here.
    if (gl_WorkGroupID.xy == uvec2(0) && gl_LocalInvocationIndex < 12u)
        lists.words[gl_LocalInvocationIndex] = 0u;
    if (repair_edges)
        load_depths(origin);
    const uint column = gl_LocalInvocationIndex % tile_size;
    const uint top = gl_LocalInvocationIndex / tile_size * rows;
    // The rows of this thread that lie in the image.
    const int inside = min(int(rows), size.y - origin.y - int(top));
    const bool is_in = origin.x + int(column) < size.x;
    const uint count = is_in ? uint(max(inside, 0)) : 0u;
    vec2 above = vec2(0), middle = vec2(0); // ranges of the rows above and at the pixel
    if (repair_edges && is_in) {
        above = range_of_row(top * apron + column);
        middle = range_of_row((top + 1u) * apron + column);
    }
    vec2 longest = vec2(0);
    vec4 known[rows];
    float z[rows];
    [[unroll]] for (uint k = 0u; k < rows; ++k) { // all loads are under way at once
        const ivec2 pixel = min(origin + ivec2(column, top + k), size - 1);
        known[k] = stored_velocities_at(pixel);
        if (!repair_edges)
            z[k] = depth_at(pixel);
    }
    [[unroll]] for (uint k = 0u; k < rows; ++k) {
        const uint y = top + k;
        if (k >= count)
            continue;
        const ivec2 pixel = origin + ivec2(column, y);
        if (repair_edges) {
            const vec2 below = range_of_row((y + 2u) * apron + column);
            z[k] = depths[(y + 1u) * apron + column + 1u];
            const float least = min(min(above.x, middle.x), below.x);
            const float greatest = max(max(above.y, middle.y), below.y);
            above = middle;
            middle = below;
            if (has_velocity && (greatest > like_ratio * z[k] || z[k] > like_ratio * least))
                known[k] = repaired_velocities_at(pixel, y * apron + column);
        }
        const vec2 v = half_displacement(pixel, completed(known[k], pixel, z[k]));
        store_pixel(pixel, y * tile_size + column, Surface(v, z[k]));
        const vec2 stored = stored_vector(y * tile_size + column);
        if (longer(stored, longest))
            longest = stored;
    }
    longest = reduce_longest(longest);
    vec3 widest = vec3(0); // vector, squared spread; pixels outside the image do not count
    if (longest != vec2(0)) { // the same for all threads; in a still tile all vectors are zero
        for (uint k = 0u; k < count; ++k) {
            const vec2 v = stored_vector((top + k) * tile_size + column);
            const vec2 d = v - longest;
            widest.z = max(widest.z, dot(d, d));
            if (wider(v, widest.xy, longest))
                widest.xy = v;
        }
        widest = reduce_widest(widest, longest);
    }
    if (gl_LocalInvocationIndex == 0u) {
        imageStore(tile_image, ivec2(gl_WorkGroupID.xy), vec4(longest, widest.xy));
        imageStore(spread_image, ivec2(gl_WorkGroupID.xy), vec4(sqrt(widest.z)));
    }
}
