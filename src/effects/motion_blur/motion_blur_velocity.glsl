// Velocity and tile maximum in one pass: a workgroup a tile. Combines the inputs to a half displacement, clamps its
// length, stores it with the depth, and reduces the tile: vectors stay in registers, subgroups or shared memory find the
// greatest.

layout(local_size_x_id = 15) in; // the tile's pixels over those of a thread

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
layout(set = 0, binding = 9) uniform writeonly uimage2D tile_image; // longest, widest beside it, spread

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
    vec2 u = known.xy;
    if (has_next_velocity || has_next_camera) {
        // The path through the three known points is a parabola, p(t) = t (next + previous) / 2 +
        // t² (next - previous) / 2. The shutter is open from (c - 1) E/2 to (c + 1) E/2; the half displacement is half
        // the chord between the two.
        const vec2 mean = 0.5 * (known.xy + known.zw);
        const vec2 bend = 0.5 * (known.zw - known.xy);
        u = mean + constants.centre * constants.shutter * bend;
    }
    if (layer_1 != 0)
        u = apply_layer(u, layer_1, layer_1_image, constants.layer_1_scale, layer_1_has_mask, layer_1_mask,
                        constants.layer_1_mask_ratio, pixel);
    if (layer_2 != 0)
        u = apply_layer(u, layer_2, layer_2_image, constants.layer_2_scale, layer_2_has_mask, layer_2_mask,
                        constants.layer_2_mask_ratio, pixel);
    vec2 v = 0.5 * constants.shutter * u;
    if (has_exclusion)
        v *= 1.0 - mask_value(nearest(exclusion_image, constants.exclusion_ratio, pixel).x);
    const float squared = dot(v, v);
    if (!is_finite(squared) || squared < no_length * no_length)
        return vec2(0);
    if (squared > constants.radius * constants.radius)
        v *= constants.radius * inversesqrt(squared);
    return v;
}

// Writes a pixel's surface; its vector as it is stored is the result: what is compared is what the gather will read.
uint store_pixel(ivec2 pixel, Surface s) {
    if (is_packed) {
        const uint code = pack_8_bit(steps_8_bit(s.v, constants.radius), s.z);
        imageStore(surface_image, pixel, uvec4(code));
        return code & 0xffffu;
    }
    const uvec2 code = pack_half(s);
    imageStore(surface_image, pixel, uvec4(code, 0, 0));
    return code.x;
}

// Vectors as they are compared: pixels, or steps of 8 bits.
vec2 compared(uint code) { return is_packed ? steps_of_8_bit(code) : unpackHalf2x16(code); }

// The best of the workgroup. Each call has its own `slot`, so that no barrier need stand between two of them. Where
// `spread` is asked for, it is reduced along: what it is the greatest of is not negative either.
#ifdef SUBGROUPS
const uint partials = 64u; // subgroups of a workgroup of 256, at least 4 wide
shared Best best_of[2u * partials];
shared uint spread_of[partials];

Best best_of_all(Best mine, inout uint spread, bool has_spread, uint slot) {
    mine = subgroup_best(mine, zero_vector(is_packed));
    if (has_spread)
        spread = subgroupMax(spread);
    if (gl_NumSubgroups == 1u)
        return mine;
    if (subgroupElect()) {
        best_of[slot * partials + gl_SubgroupID] = mine;
        if (has_spread)
            spread_of[gl_SubgroupID] = spread;
    }
    barrier();
    // The invocations of a full subgroup share the partial results; otherwise each looks at all.
    const bool is_full = gl_NumSubgroups * gl_SubgroupSize == threads;
    const uint step = is_full ? gl_SubgroupSize : 1u;
    for (uint i = is_full ? gl_SubgroupInvocationID : 0u; i < gl_NumSubgroups; i += step) {
        mine = better(mine, best_of[slot * partials + i]);
        if (has_spread)
            spread = max(spread, spread_of[i]);
    }
    if (has_spread)
        spread = subgroupMax(spread);
    return subgroup_best(mine, zero_vector(is_packed));
}
#else
shared Best best_of[512];
shared uint spread_of[256];

Best best_of_all(Best mine, inout uint spread, bool has_spread, uint slot) {
    const uint thread = gl_LocalInvocationIndex;
    best_of[slot * 256u + thread] = mine;
    if (has_spread)
        spread_of[thread] = spread;
    barrier();
    for (uint left = threads; left > 1u; left = (left + 1u) / 2u) {
        const uint other = thread + (left + 1u) / 2u;
        if (other < left) {
            mine = better(mine, best_of[slot * 256u + other]);
            best_of[slot * 256u + thread] = mine;
            if (has_spread) {
                spread = max(spread, spread_of[other]);
                spread_of[thread] = spread;
            }
        }
        barrier();
    }
    if (has_spread)
        spread = spread_of[0];
    mine = best_of[slot * 256u];
    return mine.key == 0u ? Best(0u, zero_vector(is_packed)) : mine;
}
#endif

const uint pixels = tile_size * tile_size / threads; // of a thread

// Pixel k of this thread in the tile. A subgroup's pixels are blocks of 8×4, whose texels lie together in memory. To
// repair edges a thread goes down a column instead, so that a row's range of depth serves three pixels.
uvec2 place_in_tile(uint k) {
    if (repair_edges)
        return uvec2(gl_LocalInvocationIndex % tile_size, gl_LocalInvocationIndex / tile_size * pixels + k);
    const uint number = gl_LocalInvocationIndex + k * threads;
    const uint block = number / 32u, blocks = tile_size / 8u; // in a row of the tile
    return uvec2(8u * (block % blocks) + number % 8u, 4u * (block / blocks) + number / 8u % 4u);
}

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy * tile_size);
    const ivec2 size = ivec2(constants.size);
    if (repair_edges)
        load_depths(origin);
    vec4 known[pixels];
    float z[pixels];
    [[unroll]] for (uint k = 0u; k < pixels; ++k) { // all loads are under way at once
        const ivec2 pixel = min(origin + ivec2(place_in_tile(k)), size - 1);
        known[k] = stored_velocities_at(pixel);
        if (!repair_edges)
            z[k] = depth_at(pixel);
    }
    vec2 above = vec2(0), middle = vec2(0); // ranges of the rows above and at the pixel
    if (repair_edges) {
        const uvec2 top = place_in_tile(0u);
        above = range_of_row(top.y * apron + top.x);
        middle = range_of_row((top.y + 1u) * apron + top.x);
    }
    Best longest = Best(0u, zero_vector(is_packed));
    uint codes[pixels];
    uint inside = 0u; // pixels outside the image do not count
    [[unroll]] for (uint k = 0u; k < pixels; ++k) {
        const uvec2 at = place_in_tile(k);
        const ivec2 pixel = origin + ivec2(at);
        codes[k] = zero_vector(is_packed);
        if (any(greaterThanEqual(pixel, size)))
            continue;
        inside |= 1u << k;
        if (repair_edges) {
            const vec2 below = range_of_row((at.y + 2u) * apron + at.x);
            z[k] = depths[(at.y + 1u) * apron + at.x + 1u];
            const float least = min(min(above.x, middle.x), below.x);
            const float greatest = max(max(above.y, middle.y), below.y);
            above = middle;
            middle = below;
            if (has_velocity && (greatest > like_ratio * z[k] || z[k] > like_ratio * least))
                known[k] = repaired_velocities_at(pixel, at.y * apron + at.x);
        }
        const vec2 v = half_displacement(pixel, completed(known[k], pixel, z[k]));
        codes[k] = store_pixel(pixel, Surface(v, z[k]));
        longest = better(longest, best_by_length(codes[k], compared(codes[k])));
    }
    uint spread = 0u; // squared, as bits
    longest = best_of_all(longest, spread, false, 0u);
    Best widest = Best(0u, zero_vector(is_packed));
    if (longest.key != 0u) { // the same for all threads; in a still tile all vectors are zero
        const vec2 l = compared(longest.code);
        [[unroll]] for (uint k = 0u; k < pixels; ++k) {
            if ((inside >> k & 1u) == 0u)
                continue;
            const vec2 v = compared(codes[k]);
            const vec2 d = v - l;
            spread = max(spread, floatBitsToUint(dot(d, d)));
            widest = better(widest, best_by_width(codes[k], v, l));
        }
        widest = best_of_all(widest, spread, true, 1u);
    }
    if (gl_LocalInvocationIndex == 0u) {
        const float pixels_of_step = is_packed ? constants.radius / 127.0 : 1.0;
        const float spread_pixels = pixels_of_step * sqrt(uintBitsToFloat(spread));
        imageStore(tile_image, ivec2(gl_WorkGroupID.xy),
                   uvec4(longest.code, widest.code, floatBitsToUint(spread_pixels), 0u));
    }
}
