// Neighbour maximum: of every tile, the longest vector of the tiles around whose blur can reach it, the widest beside that,
// and the tile's class. A subgroup a tile, without shared memory or barriers: there are few tiles, and waiting is what
// costs.

layout(local_size_x = 128) in;

layout(constant_id = 0) const int tile_size = 32;
layout(constant_id = 1) const bool is_packed = false;
layout(constant_id = 2) const int rings = 1;
layout(constant_id = 3) const uint dilation = 1; // box, selective, line
layout(constant_id = 4) const bool test_edge_neighbours = false;
layout(constant_id = 5) const bool classify = true;

layout(set = 0, binding = 0) uniform usampler2D tile_image; // longest, widest beside it, spread
// Of every tile, row by row, the longest vector and the widest beside it; or, by the latter, what class it is.
layout(set = 0, binding = 1) writeonly buffer Neighbours { uvec2 vectors[]; } neighbours;

struct Tile {
    uint longest_code, widest_code;
    vec2 longest, widest;
    float spread;
};

Tile tile_at(ivec2 at) {
    const uvec3 t = texelFetch(tile_image, at, 0).xyz;
    return Tile(t.x, t.y, vector_of(t.x, is_packed, constants.radius), vector_of(t.y, is_packed, constants.radius),
                uintBitsToFloat(t.z));
}

// A tile swept along the segment from -reach to +reach meets the tile in the middle exactly if that segment meets a
// square of twice the tile's size around the middle. The square is widened by what the tile's other vectors reach to the
// side of the longest, so that none of its pixels is missed. `selective` takes the segment's whole line, `line`
// its true length. Symmetric in the sign of the vector, since the blur reaches both ways.
bool reaches(Tile tile, ivec2 offset) {
    if (dilation == 0 || offset == ivec2(0))
        return true;
    const bool diagonal = offset.x != 0 && offset.y != 0;
    if (dilation == 1 && !diagonal && !test_edge_neighbours)
        return true;
    const vec2 v = tile.longest;
    if (dilation == 2 && v == vec2(0))
        return false;
    const float l = length(v);
    const float half_size = float(tile_size) + (l > 0.0 ? abs(cross_product(tile.widest, v)) / l : 0.0);
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

// ---- who shares a tile's work ----
// A workgroup has four tiles. With subgroup operations each subgroup takes a whole tile, then the next; without, 32
// invocations a tile meet in shared memory.
const uint tiles_of_group = 4u; // in a row

#ifdef SUBGROUPS
Best best_of_tile(Best mine) { return subgroup_best(mine, zero_vector(is_packed)); }
uint greatest_of_tile(uint mine) { return subgroupMax(mine); }
#else
shared Best best_of[128];
shared uint greatest_of[128];

Best best_of_tile(Best mine) {
    barrier(); // until all have read what was there before
    best_of[gl_LocalInvocationIndex] = mine;
    barrier();
    for (uint i = 0u; i < 32u; ++i)
        mine = better(mine, best_of[(gl_LocalInvocationIndex & ~31u) + i]);
    return mine.key == 0u ? Best(0u, zero_vector(is_packed)) : mine;
}
uint greatest_of_tile(uint mine) {
    barrier();
    greatest_of[gl_LocalInvocationIndex] = mine;
    barrier();
    for (uint i = 0u; i < 32u; ++i)
        mine = max(mine, greatest_of[(gl_LocalInvocationIndex & ~31u) + i]);
    return mine;
}
#endif

// A tile around another one.
struct Around {
    Tile tile;
    ivec2 offset;
    bool exists, does_reach;
};

Around around(ivec2 tile, ivec2 tiles, int i) {
    const int side = 2 * rings + 1;
    Around a;
    a.offset = ivec2(i % side, i / side) - rings;
    const ivec2 at = tile + a.offset;
    a.exists = i < side * side && all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, tiles));
    a.does_reach = false;
    if (a.exists) {
        a.tile = tile_at(at);
        a.does_reach = reaches(a.tile, a.offset);
    }
    return a;
}

void take_longest(inout Best longest, Around a) {
    const Best it = best_by_length(a.tile.longest_code, a.tile.longest);
    if (a.exists && a.does_reach && uintBitsToFloat(it.key) >= still_length * still_length)
        longest = better(longest, it);
}

void take_others(inout Best widest, inout uint spread, Around a, vec2 n, int own_rings) {
    if (a.exists && (a.does_reach || max(abs(a.offset.x), abs(a.offset.y)) <= own_rings))
        spread = max(spread, floatBitsToUint(distance(a.tile.longest, n) + a.tile.spread));
    if (a.exists && a.does_reach)
        widest = better(widest, better(best_by_width(a.tile.longest_code, a.tile.longest, n),
                                       best_by_width(a.tile.widest_code, a.tile.widest, n)));
}

// Invocation `rank` of `count` that share the tile. There are few tiles around: the first of each invocation, which is
// mostly all, is looked at once.
void find(ivec2 tile, ivec2 tiles, uint rank, uint count, bool is_inside) {
    const int most = (2 * rings + 1) * (2 * rings + 1);
    const uint none = zero_vector(is_packed);
    const Tile own = tile_at(tile);
    const Around first = around(tile, tiles, int(rank));
    Best longest = Best(0u, none);
    take_longest(longest, first);
    for (int i = int(rank + count); i < most; i += int(count))
        take_longest(longest, around(tile, tiles, i));
    longest = best_of_tile(longest);
    const vec2 n = vector_of(longest.code, is_packed, constants.radius);
    const float l = sqrt(uintBitsToFloat(longest.key));
    Best widest = Best(0u, none);
    uint spread = 0u;
    if (longest.key != 0u) { // the same for all that share the tile; otherwise it is still
        // Whether motion is even concerns what reaches the tile, and what its own vectors reach.
        const float own_reach = length(own.longest) * (1.0 + abs(constants.centre));
        const int own_rings = int(ceil(own_reach / float(tile_size)));
        take_others(widest, spread, first, n, own_rings);
        for (int i = int(rank + count); i < most; i += int(count))
            take_others(widest, spread, around(tile, tiles, i), n, own_rings);
    }
    spread = greatest_of_tile(spread);
    widest = best_of_tile(widest);
    uint mark = widest.code;
    if (classify && uintBitsToFloat(spread) <= max(constants.uniform_tolerance * l, constants.uniform_pixels))
        mark = uniform_mark;
    if (rank == 0u && is_inside)
        neighbours.vectors[tile.y * tiles.x + tile.x] = uvec2(longest.code, mark);
}

void main() {
    const ivec2 tiles = (ivec2(constants.size) + tile_size - 1) / tile_size;
    const ivec2 first = ivec2(gl_WorkGroupID.xy) * ivec2(tiles_of_group, 1);
#ifdef SUBGROUPS
    // A subgroup that is not full counts those it has.
    const bool is_full = gl_NumSubgroups * gl_SubgroupSize == gl_WorkGroupSize.x;
    const uint count = is_full ? gl_SubgroupSize : subgroupAdd(1u);
    const uint rank = is_full ? gl_SubgroupInvocationID : subgroupExclusiveAdd(1u);
    for (uint i = gl_SubgroupID; i < tiles_of_group; i += gl_NumSubgroups) {
        const ivec2 tile = first + ivec2(i, 0);
        if (tile.x < tiles.x)
            find(tile, tiles, rank, count, true);
    }
#else
    const ivec2 tile = first + ivec2(gl_LocalInvocationIndex / 32u, 0);
    find(min(tile, tiles - 1), tiles, gl_LocalInvocationIndex & 31u, 32u, tile.x < tiles.x);
#endif
}
