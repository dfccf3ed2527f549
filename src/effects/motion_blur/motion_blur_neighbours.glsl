// Neighbour maximum: of every tile, the longest vector of the tiles around whose blur can reach it; the tile's class;
// and the lists of tiles by class, from which the gather is dispatched.

// Four threads a tile share the rows of its neighbourhood: there are few tiles, and waiting is what costs.
layout(local_size_x = 8, local_size_y = 8, local_size_z = 4) in;

layout(constant_id = 0) const int tile_size = 32;
layout(constant_id = 1) const int rings = 1;
layout(constant_id = 2) const uint dilation = 1; // box, selective, line
layout(constant_id = 3) const bool test_edge_neighbours = false;
layout(constant_id = 4) const bool classify = true;
layout(constant_id = 5) const uint blocks_per_side = 4; // workgroups of the gather

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
    float low = -limit, high = limit;
    const vec2 middle = vec2(-offset * tile_size);
    for (int axis = 0; axis < 2; ++axis) {
        if (v[axis] == 0.0) {
            if (abs(middle[axis]) >= half_size)
                return false;
            continue;
        }
        const float a = (middle[axis] - half_size) / v[axis];
        const float b = (middle[axis] + half_size) / v[axis];
        low = max(low, min(a, b));
        high = min(high, max(a, b));
    }
    return low < high;
}

// The tiles that the workgroup looks at, where they fit into shared memory.
const int apron = 8 + 2 * rings;
const bool fits = apron <= 24;
shared vec4 tiles_of[fits ? apron * apron : 1];
shared float spreads_of[fits ? apron * apron : 1];
shared vec2 longest_of[256];
shared vec3 widest_of[256]; // vector, spread

void load_tiles(ivec2 tiles) {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * 8 - rings;
    for (int i = int(gl_LocalInvocationIndex); i < apron * apron; i += 256) {
        const ivec2 tile = clamp(origin + ivec2(i % apron, i / apron), ivec2(0), tiles - 1);
        tiles_of[i] = texelFetch(tile_image, tile, 0);
        spreads_of[i] = texelFetch(spread_image, tile, 0).x;
    }
    barrier();
}

int slot_of(ivec2 tile) {
    const ivec2 local = tile - ivec2(gl_WorkGroupID.xy) * 8 + rings;
    return local.y * apron + local.x;
}
vec4 tile_at(ivec2 tile) { return fits ? tiles_of[slot_of(tile)] : texelFetch(tile_image, tile, 0); }
float spread_at(ivec2 tile) { return fits ? spreads_of[slot_of(tile)] : texelFetch(spread_image, tile, 0).x; }

// The best of what the four threads of a tile found.
vec2 longest_of_four(vec2 mine) {
    const uint thread = gl_LocalInvocationIndex;
    longest_of[thread] = mine;
    barrier();
    vec2 result = mine;
    for (uint i = thread & 63u; i < 256u; i += 64u)
        if (longer(longest_of[i], result))
            result = longest_of[i];
    return result;
}

vec3 widest_of_four(vec3 mine, vec2 longest) {
    const uint thread = gl_LocalInvocationIndex;
    widest_of[thread] = mine;
    barrier();
    vec3 result = mine;
    for (uint i = thread & 63u; i < 256u; i += 64u) {
        result.z = max(result.z, widest_of[i].z);
        if (wider(widest_of[i].xy, result.xy, longest))
            result.xy = widest_of[i].xy;
    }
    return result;
}

void append(ivec2 tile, ivec2 tiles, uint class_index) {
    const uint slot = atomicAdd(lists.words[class_index * 3u + 1u], 1u);
    if (slot == 0u) {
        // A workgroup copies a row of blocks, or blurs a block.
        lists.words[class_index * 3u] = class_index == 0u ? blocks_per_side : blocks_per_side * blocks_per_side;
        lists.words[class_index * 3u + 2u] = 1u;
    }
    const uint tile_count = uint(tiles.x * tiles.y);
    lists.words[12u + class_index * tile_count + slot] = uint(tile.y * tiles.x + tile.x);
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    const ivec2 tiles = textureSize(tile_image, 0);
    const bool exists = all(lessThan(tile, tiles)); // the threads of tiles outside stay for the barriers
    if (fits)
        load_tiles(tiles);
    const ivec2 first = max(tile - rings, ivec2(0));
    const ivec2 last = exists ? min(tile + rings, tiles - 1) : first - 1;
    const int first_row = first.y + int(gl_LocalInvocationID.z);
    vec2 longest = vec2(0);
    for (int y = first_row; y <= last.y; y += 4)
        for (int x = first.x; x <= last.x; ++x) {
            const vec4 t = tile_at(ivec2(x, y));
            if (longer(t.xy, longest) && reaches(t, ivec2(x, y) - tile))
                longest = t.xy;
        }
    longest = longest_of_four(longest);
    // Whether motion is even concerns what reaches the tile, and what its own vectors reach.
    const float own_reach = exists ? length(tile_at(tile).xy) * (1.0 + abs(constants.centre)) : 0.0;
    const int own_rings = int(ceil(own_reach / float(tile_size)));
    vec3 widest = vec3(0);
    for (int y = first_row; y <= last.y; y += 4)
        for (int x = first.x; x <= last.x; ++x) {
            const vec4 t = tile_at(ivec2(x, y));
            const ivec2 offset = ivec2(x, y) - tile;
            const bool does_reach = reaches(t, offset);
            if (does_reach || max(abs(offset.x), abs(offset.y)) <= own_rings)
                widest.z = max(widest.z, length(t.xy - longest) + spread_at(ivec2(x, y)));
            const vec2 v = wider(t.zw, t.xy, longest) ? t.zw : t.xy;
            if (does_reach && wider(v, widest.xy, longest))
                widest.xy = v;
        }
    widest = widest_of_four(widest, longest);
    if (!exists || gl_LocalInvocationID.z != 0u)
        return;
    const float l = length(longest);
    uint class_index = 2u;
    if (l < still_length)
        class_index = 0u;
    else if (classify && widest.z <= max(constants.uniform_tolerance * l, constants.uniform_pixels))
        class_index = 1u;
    imageStore(neighbour_image, tile, vec4(longest, widest.xy));
    imageStore(class_image, tile, vec4(float(class_index)));
    append(tile, tiles, class_index);
}
