// Neighbour maximum: of every tile, the longest vector of the tiles around whose blur can reach it; the tile's class;
// and the lists of tiles by class, from which the gather is dispatched.

// Sixteen threads a tile share its neighbourhood: there are few tiles, and waiting is what costs.
layout(local_size_x = 4, local_size_y = 4, local_size_z = 16) in;

layout(constant_id = 0) const int tile_size = 32;
layout(constant_id = 1) const int rings = 1;
layout(constant_id = 2) const uint dilation = 1; // box, selective, line
layout(constant_id = 3) const bool test_edge_neighbours = false;
layout(constant_id = 4) const bool classify = true;
layout(constant_id = 5) const uint blocks_per_side = 4; // of 8×8 pixels

layout(set = 0, binding = 0) uniform sampler2D tile_image;
layout(set = 0, binding = 1) uniform sampler2D spread_image;
layout(set = 0, binding = 2) uniform writeonly image2D neighbour_image; // longest (xy), widest beside it (zw)
layout(set = 0, binding = 3) uniform writeonly image2D class_image;
// Three VkDispatchIndirectCommands (still, uniform, full), three words of padding, then a list of tiles for each.
layout(set = 0, binding = 4) buffer TileLists { uint words[]; } lists;

// A tile swept along the segment from -reach to +reach meets the tile in the middle exactly if that segment meets a
// square of twice the tile's size around the middle. The square is widened by what the tile's other vectors reach to the
// side of the longest, so that none of its pixels is missed. `selective` takes the segment's whole line, `line`
// its true length. Symmetric in the sign of the vector, since the blur reaches both ways.
bool reaches(vec4 tile, ivec2 offset) {
    if (dilation == 0 || offset == ivec2(0))
        return true;
    const bool diagonal = offset.x != 0 && offset.y != 0;
    if (dilation == 1 && !diagonal && !test_edge_neighbours)
        return true;
    const vec2 v = tile.xy;
    const float l = length(v);
    const float half_size = float(tile_size) + (l > 0.0 ? abs(cross_product(tile.zw, v)) / l : 0.0);
    const float limit = dilation == 2 ? 1.0 + abs(constants.centre) : 1e30;
    const vec2 middle = vec2(-offset * tile_size);
    const bvec2 is_flat = equal(v, vec2(0));
    if (any(bvec2(is_flat.x && abs(middle.x) >= half_size, is_flat.y && abs(middle.y) >= half_size)))
        return false;
    const vec2 inverse = 1.0 / mix(v, vec2(1), is_flat);
    const vec2 a = (middle - half_size) * inverse, b = (middle + half_size) * inverse;
    const vec2 low = mix(min(a, b), vec2(-limit), is_flat), high = mix(max(a, b), vec2(limit), is_flat);
    return max(max(low.x, low.y), -limit) < min(min(high.x, high.y), limit);
}

// The tiles that the workgroup looks at, where they fit into shared memory.
const int apron = 4 + 2 * rings;
const bool fits = apron <= 20;
shared vec4 tiles_of[fits ? apron * apron : 1];
shared float spreads_of[fits ? apron * apron : 1];
shared vec2 longest_of[256];
shared vec3 widest_of[256]; // vector, spread

shared uint moving; // whether any of them has motion that is blurred

void load_tiles(ivec2 tiles) {
    if (gl_LocalInvocationIndex == 0u)
        moving = 0u;
    barrier();
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * 4 - rings;
    for (int i = int(gl_LocalInvocationIndex); i < apron * apron; i += 256) {
        const ivec2 tile = clamp(origin + ivec2(i % apron, i / apron), ivec2(0), tiles - 1);
        tiles_of[i] = texelFetch(tile_image, tile, 0);
        if (dot(tiles_of[i].xy, tiles_of[i].xy) >= still_length * still_length)
            moving = 1u; // whoever writes, writes the same
        spreads_of[i] = texelFetch(spread_image, tile, 0).x;
    }
    barrier();
}

int slot_of(ivec2 tile) {
    const ivec2 local = tile - ivec2(gl_WorkGroupID.xy) * 4 + rings;
    return local.y * apron + local.x;
}
vec4 tile_at(ivec2 tile) { return fits ? tiles_of[slot_of(tile)] : texelFetch(tile_image, tile, 0); }
float spread_at(ivec2 tile) { return fits ? spreads_of[slot_of(tile)] : texelFetch(spread_image, tile, 0).x; }

// The best of what the sixteen threads of a tile found.
vec2 longest_of_all(vec2 mine) {
    const uint thread = gl_LocalInvocationIndex;
    longest_of[thread] = mine;
    barrier();
    [[dont_unroll]] for (uint i = 0u; i < 16u; ++i) {
        const vec2 other = longest_of[(thread & 15u) + 16u * i];
        mine = longer(other, mine) ? other : mine;
    }
    return mine;
}

vec3 widest_of_all(vec3 mine, vec2 longest) {
    const uint thread = gl_LocalInvocationIndex;
    widest_of[thread] = mine;
    barrier();
    [[dont_unroll]] for (uint i = 0u; i < 16u; ++i) {
        const vec3 other = widest_of[(thread & 15u) + 16u * i];
        mine.z = max(mine.z, other.z);
        mine.xy = wider(other.xy, mine.xy, longest) ? other.xy : mine.xy;
    }
    return mine;
}

shared uint counts[3];
shared uint starts[3];

// One addition a class and workgroup to the lists' counts: thousands to three words would queue up.
void append(bool is_one, ivec2 tile, ivec2 tiles, uint class_index) {
    const uint thread = gl_LocalInvocationIndex;
    if (thread < 3u)
        counts[thread] = 0u;
    barrier();
    uint slot = 0u;
    if (is_one)
        slot = atomicAdd(counts[class_index], 1u);
    barrier();
    if (thread < 3u && counts[thread] > 0u) {
        starts[thread] = atomicAdd(lists.words[thread * 3u + 1u], counts[thread]);
        if (starts[thread] == 0u) {
            // A workgroup copies four rows of blocks, or blurs four blocks.
            const uint blocks = thread == 0u ? blocks_per_side : blocks_per_side * blocks_per_side;
            lists.words[thread * 3u] = (blocks + 3u) / 4u;
            lists.words[thread * 3u + 2u] = 1u;
        }
    }
    barrier();
    const uint tile_count = uint(tiles.x * tiles.y);
    if (is_one)
        lists.words[12u + class_index * tile_count + starts[class_index] + slot] = uint(tile.y * tiles.x + tile.x);
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    const ivec2 tiles = textureSize(tile_image, 0);
    const bool exists = all(lessThan(tile, tiles)); // the threads of tiles outside stay for the barriers
    if (fits)
        load_tiles(tiles);
    const int side = 2 * rings + 1;
    vec2 longest = vec2(0);
    vec3 widest = vec3(0);
    if (!fits || moving != 0u) { // the same for all threads
        for (int i = int(gl_LocalInvocationID.z); i < side * side; i += 16) {
            const ivec2 offset = ivec2(i % side, i / side) - rings;
            const ivec2 other = tile + offset;
            if (!exists || any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, tiles)))
                continue;
            const vec4 t = tile_at(other);
            if (longer(t.xy, longest) && reaches(t, offset))
                longest = t.xy;
        }
        longest = longest_of_all(longest);
        // Whether motion is even concerns what reaches the tile, and what its own vectors reach.
        const float own_reach = exists ? length(tile_at(tile).xy) * (1.0 + abs(constants.centre)) : 0.0;
        const int own_rings = int(ceil(own_reach / float(tile_size)));
        for (int i = int(gl_LocalInvocationID.z); i < side * side; i += 16) {
            const ivec2 offset = ivec2(i % side, i / side) - rings;
            const ivec2 other = tile + offset;
            if (!exists || any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, tiles)))
                continue;
            const vec4 t = tile_at(other);
            const bool does_reach = reaches(t, offset);
            if (does_reach || max(abs(offset.x), abs(offset.y)) <= own_rings)
                widest.z = max(widest.z, distance(t.xy, longest) + spread_at(other));
            const vec2 v = wider(t.zw, t.xy, longest) ? t.zw : t.xy;
            if (does_reach && wider(v, widest.xy, longest))
                widest.xy = v;
        }
        widest = widest_of_all(widest, longest);
    }
    const float l = length(longest);
    uint class_index = 2u;
    if (l < still_length)
        class_index = 0u;
    else if (classify && widest.z <= max(constants.uniform_tolerance * l, constants.uniform_pixels))
        class_index = 1u;
    const bool is_one = exists && gl_LocalInvocationID.z == 0u;
    if (is_one) {
        imageStore(neighbour_image, tile, vec4(longest, widest.xy));
        imageStore(class_image, tile, vec4(float(class_index)));
    }
    append(is_one, tile, tiles, class_index);
}
